//! Pictures, plots and tables, from plain data: numbers come in, text and bytes go out.

pub mod picture;
pub mod table;
