//! The numbers of the paper's figures, measured (Bischoff, Kobbelt, Seidel 2000, figures 16 and 17).

pub mod counted;
pub mod deviation;
pub mod operations;
