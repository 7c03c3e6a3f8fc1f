//! The mathematics of the surfaces, in exact numbers.
