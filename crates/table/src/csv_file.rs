//! A table as CSV.

use crate::kind::{Cell, Column};
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{Error, Write};

/// A CSV file that is being written.
pub(crate) struct CsvFile<W: Write> {
    writer: csv::Writer<W>,
    /// The number that is being written.
    number: String,
}

impl<W: Write> CsvFile<W> {
    pub fn new(columns: &[Column], sink: W) -> Result<Self, Error> {
        let mut writer = csv::Writer::from_writer(sink);
        let names = columns.iter().map(|column| column.name);
        writer.write_record(names).map_err(plain)?;
        let number = String::new();
        Ok(Self { writer, number })
    }

    pub fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), Error> {
        for cell in cells {
            self.number.clear();
            let _ = match cell {
                Cell::Empty | Cell::Text(_) => Ok(()),
                Cell::Integer(value) => write!(self.number, "{value}"),
                Cell::Real(value) => write!(self.number, "{value}"),
                Cell::Flag(value) => write!(self.number, "{value}"),
            };
            let written = match cell {
                Cell::Text(text) => self.writer.write_field(harmless(text).as_bytes()),
                _ => self.writer.write_field(&self.number),
            };
            written.map_err(plain)?;
        }
        // An empty record ends the row of the fields before it.
        let end: [&str; 0] = [];
        self.writer.write_record(end).map_err(plain)
    }

    pub fn finish(self) -> Result<W, Error> {
        self.writer
            .into_inner()
            .map_err(csv::IntoInnerError::into_error)
    }
}

/// The error beneath: rows of equal length are written, so there is no other.
fn plain(error: csv::Error) -> Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => Error::other(format!("{other:?}")),
    }
}

/// A text that no spreadsheet takes for a formula and no reader refuses; see the documentation of the crate.
fn harmless(text: &str) -> Cow<'_, str> {
    let guarded = text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n', '\'']);
    let nul = text.contains('\0');
    if !guarded && !nul {
        return text.into();
    }
    let text = text.replace('\0', "\u{2400}");
    match guarded {
        true => format!("'{text}").into(),
        false => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::harmless;

    #[test]
    fn no_text_is_a_formula_and_each_comes_back() {
        for (text, written) in [
            ("=1+1", "'=1+1"),
            ("+49 30", "'+49 30"),
            ("-2", "'-2"),
            ("@SUM(A1)", "'@SUM(A1)"),
            ("\t=1", "'\t=1"),
            ("'=1", "''=1"),
            ("A. Muster", "A. Muster"),
            ("a\0b", "a\u{2400}b"),
            ("=\0", "'=\u{2400}"),
            ("", ""),
        ] {
            assert_eq!(harmless(text), written);
            let back = harmless(text);
            let back = back.strip_prefix('\'').unwrap_or(&back);
            assert_eq!(back.replace('\u{2400}', "\0"), text);
        }
    }
}
