//! Numbers: fixed-point formats, rounding modes, exact ranges and exact linear forms.

pub mod format;
pub mod linear;
pub mod near;
pub mod precision;
pub mod range;
pub mod rounding;

pub use format::Format;
pub use linear::Form;
pub use near::Near;
pub use precision::{Fractions, Precision, Reduced};
pub use range::Range;
pub use rounding::Rounding;
