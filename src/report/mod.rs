//! Pictures, plots and tables, from plain data.
