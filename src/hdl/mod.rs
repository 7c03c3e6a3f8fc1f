//! The hardware description language: a design is data.
