//! Tidy tables: one row per observation, one column per variable, each column of one kind; written as CSV or Parquet, row by row.
//!
//! Rows in, bytes out: same rows, same bytes. Not here: where rows come from, and files.
//!
//! # CSV
//! UTF-8, a header, a comma between fields, a point in numbers, line feeds; a value that is not there is an empty field. Numbers have the shortest
//! digits that give the same bits again. A spreadsheet takes a text that begins with `=`, `+`, `-`, `@`, a tab or a line end for a formula or an order of
//! its own, so such a text gets an apostrophe before it (OWASP, "CSV injection"), and so does one that begins with an apostrophe: whoever takes one
//! leading apostrophe off every text has all texts as they were. NUL, which readers of CSV refuse, is written as `␀` (U+2400).
//!
//! # Parquet
//! Columns that may be empty (`OPTIONAL`), of the types string, 64-bit integer, double and boolean; not compressed; texts are as they were.

#![forbid(unsafe_code)]

mod csv_file;
mod kind;
mod parquet_file;
mod writer;

pub use kind::{Cell, Column, Format, Kind};
pub use writer::{TableError, TableWriter};
