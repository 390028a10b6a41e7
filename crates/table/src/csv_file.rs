//! A table as CSV (RFC 4180).

use crate::kind::{Cell, Column};
use std::io::{Error, Write};

/// A CSV file that is being written.
pub(crate) struct CsvFile<W: Write> {
    sink: W,
    /// The row that is being written.
    row: Vec<u8>,
}

impl<W: Write> CsvFile<W> {
    pub fn new(columns: &[Column], sink: W) -> Result<Self, Error> {
        let row = Vec::new();
        let mut file = Self { sink, row };
        let names: Vec<Cell<'_>> = columns.iter().map(|c| Cell::Text(c.name)).collect();
        file.group(&[], std::iter::once(&names[..]))?;
        Ok(file)
    }

    /// Rows that begin with the same cells, which are put into words once.
    pub fn group<'a>(
        &mut self,
        common: &[Cell<'_>],
        rows: impl Iterator<Item = &'a [Cell<'a>]>,
    ) -> Result<(), Error> {
        self.row.clear();
        common.iter().try_for_each(|cell| self.cell(cell))?;
        let length = self.row.len();
        for row in rows {
            self.row.truncate(length);
            row.iter().try_for_each(|cell| self.cell(cell))?;
            // In the place of the comma behind the last field.
            self.row.pop();
            // Readers skip a line without anything.
            if self.row.is_empty() {
                self.row.extend(b"\"\"");
            }
            self.row.push(b'\n');
            self.sink.write_all(&self.row)?;
        }
        Ok(())
    }

    /// Appends a field and a comma.
    fn cell(&mut self, cell: &Cell<'_>) -> Result<(), Error> {
        match cell {
            Cell::Empty => {}
            Cell::Text(text) => self.text(text),
            Cell::Integer(value) => write!(self.row, "{value}")?,
            Cell::Real(value) => write!(self.row, "{value}")?,
            Cell::Flag(value) => write!(self.row, "{value}")?,
        }
        self.row.push(b',');
        Ok(())
    }

    /// Appends a text that no spreadsheet takes for a formula and no reader refuses; see the documentation of the crate.
    fn text(&mut self, text: &str) {
        let is_guarded = text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n', '\'']);
        let special = |byte: u8| matches!(byte, b',' | b'"' | b'\n' | b'\r');
        let is_quoted = text.bytes().any(special);
        let quote: &[u8] = if is_quoted { b"\"" } else { b"" };
        self.row.extend(quote);
        self.row.extend(is_guarded.then_some(b'\''));
        if is_quoted || text.contains('\0') {
            let text = text.replace('\0', "\u{2400}").replace('"', "\"\"");
            self.row.extend(text.as_bytes());
        } else {
            self.row.extend(text.as_bytes());
        }
        self.row.extend(quote);
    }

    pub fn finish(mut self) -> Result<W, Error> {
        self.sink.flush()?;
        Ok(self.sink)
    }
}

#[cfg(test)]
mod tests {
    use super::CsvFile;
    use crate::kind::{Cell, Column, Kind};

    /// The row of a text and a number behind it, without the header.
    fn written(text: &str) -> String {
        let columns = ["text", "n"].map(|name| Column {
            name,
            kind: Kind::Text,
        });
        let mut file = CsvFile::new(&columns, Vec::new()).expect("memory");
        let row = [Cell::Integer(1)];
        file.group(&[Cell::Text(text)], std::iter::once(&row[..]))
            .expect("memory");
        let text = String::from_utf8(file.finish().expect("memory")).expect("text");
        text.strip_prefix("text,n\n").expect("a header").to_owned()
    }

    #[test]
    fn no_text_is_a_formula_and_each_comes_back() {
        for (text, field) in [
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
            ("a,b", "\"a,b\""),
            ("=\"a\",\0", "\"'=\"\"a\"\",\u{2400}\""),
            ("\r\n", "\"'\r\n\""),
        ] {
            let line = written(text);
            assert_eq!(line, format!("{field},1\n"));
            let mut reader = csv::ReaderBuilder::new();
            let mut reader = reader.has_headers(false).from_reader(line.as_bytes());
            let record = reader.records().next().expect("a row").expect("a row");
            let back = record[0].strip_prefix('\'').unwrap_or(&record[0]);
            assert_eq!(back.replace('\u{2400}', "\0"), text);
        }
    }
}
