//! A table that is being written.

use crate::csv_file::CsvFile;
use crate::kind::{Cell, Column, Format};
use crate::parquet_file::ParquetFile;
use std::fmt;
use std::io::Write;

/// Why a table could not be written.
#[derive(Debug)]
pub struct TableError(String);

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for TableError {}

/// Writes rows to a sink.
pub struct TableWriter<W: Write + Send> {
    columns: Vec<Column>,
    file: File<W>,
}

enum File<W: Write + Send> {
    Csv(CsvFile<W>),
    Parquet(ParquetFile<W>),
}

impl<W: Write + Send> TableWriter<W> {
    /// Begins a table.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn new(format: Format, columns: &[Column], sink: W) -> Result<Self, TableError> {
        let file = match format {
            Format::Csv => File::Csv(CsvFile::new(columns, sink).map_err(error)?),
            Format::Parquet => File::Parquet(ParquetFile::new(columns, sink).map_err(error)?),
        };
        let columns = columns.to_vec();
        Ok(Self { columns, file })
    }

    /// Appends a row.
    ///
    /// # Errors
    /// A row that is not of the columns, and those of the sink.
    pub fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), TableError> {
        self.group(&[], std::iter::once(cells))
    }

    /// Appends rows that all begin with the same cells.
    ///
    /// # Errors
    /// A row that is not of the columns, and those of the sink.
    pub fn group<'a>(
        &mut self,
        common: &[Cell<'_>],
        rows: impl Iterator<Item = &'a [Cell<'a>]> + Clone,
    ) -> Result<(), TableError> {
        let fits = |columns: &[Column], cells: &[Cell<'_>]| {
            let mut pairs = columns.iter().zip(cells);
            columns.len() == cells.len() && pairs.all(|(column, cell)| cell.is_of(column.kind))
        };
        let parts = self.columns.split_at_checked(common.len());
        let is_fit = parts.is_some_and(|(first, rest)| {
            fits(first, common) && rows.clone().all(|row| fits(rest, row))
        });
        if !is_fit {
            return Err(TableError(
                "a row that is not of the table's columns".into(),
            ));
        }
        match &mut self.file {
            File::Csv(file) => file.group(common, rows).map_err(error),
            File::Parquet(file) => file.group(common, rows).map_err(error),
        }
    }

    /// Writes what is left, and gives the sink back.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn finish(self) -> Result<W, TableError> {
        match self.file {
            File::Csv(file) => file.finish().map_err(error),
            File::Parquet(file) => file.finish().map_err(error),
        }
    }
}

fn error(error: impl fmt::Display) -> TableError {
    TableError(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    const COLUMNS: [Column; 4] = [
        Column {
            name: "name",
            kind: Kind::Text,
        },
        Column {
            name: "level",
            kind: Kind::Integer,
        },
        Column {
            name: "value_m",
            kind: Kind::Real,
        },
        Column {
            name: "passed",
            kind: Kind::Flag,
        },
    ];

    fn rows() -> [[Cell<'static>; 4]; 3] {
        [
            [
                Cell::Text("=A. \"Muster\",\n李"),
                Cell::Integer(-3),
                Cell::Real(0.1 + 0.2),
                Cell::Flag(true),
            ],
            [Cell::Empty, Cell::Empty, Cell::Empty, Cell::Empty],
            [
                Cell::Text(""),
                Cell::Integer(i64::MAX),
                Cell::Real(1e-300),
                Cell::Flag(false),
            ],
        ]
    }

    fn written(format: Format) -> Vec<u8> {
        let mut table = TableWriter::new(format, &COLUMNS, Vec::new()).expect("memory");
        for row in rows() {
            table.row(&row).expect("memory");
        }
        table.finish().expect("memory")
    }

    #[test]
    fn csv_has_quotes_empty_fields_and_all_digits() {
        let text = String::from_utf8(written(Format::Csv)).expect("text");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let rows: Vec<_> = reader.records().map(|row| row.expect("a row")).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(&rows[0][0], "'=A. \"Muster\",\n李");
        assert_eq!(rows[0][2].parse(), Ok(0.1 + 0.2));
        assert_eq!(rows[1].iter().collect::<Vec<_>>(), [""; 4]);
        assert_eq!(rows[2][2].parse(), Ok(1e-300));
        assert_eq!(&rows[2][3], "false");
    }

    /// The reader of the same crate gives every value to the bit, and what is not there as null.
    #[test]
    fn parquet_comes_back() {
        let reader = SerializedFileReader::new(bytes::Bytes::from(written(Format::Parquet)));
        let reader = reader.expect("a file");
        assert_eq!(reader.metadata().file_metadata().num_rows(), 3);
        let rows: Vec<Vec<Field>> = reader
            .get_row_iter(None)
            .expect("rows")
            .map(|row| {
                row.expect("a row")
                    .get_column_iter()
                    .map(|(_, f)| f.clone())
                    .collect()
            })
            .collect();
        assert_eq!(
            rows[0],
            [
                Field::Str("=A. \"Muster\",\n李".into()),
                Field::Long(-3),
                Field::Double(0.1 + 0.2),
                Field::Bool(true)
            ]
        );
        assert_eq!(
            rows[1],
            [Field::Null, Field::Null, Field::Null, Field::Null]
        );
        assert_eq!(rows[2][0], Field::Str(String::new()));
        assert_eq!(rows[2][1], Field::Long(i64::MAX));
    }

    /// More rows than a group has.
    #[test]
    fn long_tables_have_all_rows() {
        let columns = [Column {
            name: "n",
            kind: Kind::Integer,
        }];
        let mut table = TableWriter::new(Format::Parquet, &columns, Vec::new()).expect("memory");
        let count = 150_000;
        for n in 0..count {
            table.row(&[Cell::Integer(n)]).expect("memory");
        }
        let bytes = bytes::Bytes::from(table.finish().expect("memory"));
        let reader = SerializedFileReader::new(bytes).expect("a file");
        let rows = reader.get_row_iter(None).expect("rows");
        let values = rows.map(|row| {
            row.expect("a row")
                .get_column_iter()
                .next()
                .map(|(_, f)| f.clone())
        });
        assert!(values.eq((0..count).map(|n| Some(Field::Long(n)))));
    }

    #[test]
    fn a_row_of_other_columns_is_refused() {
        for format in [Format::Csv, Format::Parquet] {
            let mut table = TableWriter::new(format, &COLUMNS, Vec::new()).expect("memory");
            assert!(table.row(&[Cell::Empty; 3]).is_err());
            assert!(table.row(&[Cell::Flag(true); 4]).is_err());
        }
    }

    #[test]
    fn the_name_of_a_file_states_its_format() {
        use std::path::Path;
        assert_eq!(Format::of(Path::new("a/b.csv")), Some(Format::Csv));
        assert_eq!(Format::of(Path::new("b.parquet")), Some(Format::Parquet));
        assert_eq!(Format::of(Path::new("csv")), None);
        assert_eq!(Format::of(Path::new("b.xlsx")), None);
    }
}
