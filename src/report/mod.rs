//! Pictures, plots and tables, from plain data: numbers come in, text and bytes go out.

pub mod page;
pub mod picture;
pub mod plot;
pub mod table;
