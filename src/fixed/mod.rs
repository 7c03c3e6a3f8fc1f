//! Numbers: fixed-point formats, rounding modes, exact ranges and exact linear forms.

pub mod format;

pub use format::Format;
