//! A table as Parquet.

use crate::kind::{Cell, Column, Kind};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// Rows of a group, which are in memory until it is written.
const GROUP: usize = 1 << 16;

/// Values of a column that are not written yet, and for each row whether it has one.
struct Values {
    of: Typed,
    /// 1 where there is a value.
    defined: Vec<i16>,
}

enum Typed {
    Text(Vec<ByteArray>),
    Integer(Vec<i64>),
    Real(Vec<f64>),
    Flag(Vec<bool>),
}

impl Values {
    fn new(kind: Kind) -> Self {
        Self {
            of: match kind {
                Kind::Text => Typed::Text(Vec::new()),
                Kind::Integer => Typed::Integer(Vec::new()),
                Kind::Real => Typed::Real(Vec::new()),
                Kind::Flag => Typed::Flag(Vec::new()),
            },
            defined: Vec::new(),
        }
    }

    fn push(&mut self, cell: Cell<'_>) {
        let is_there = match (&mut self.of, cell) {
            (Typed::Text(values), Cell::Text(text)) => {
                // Rows of one observation repeat its texts, which are in memory once then.
                let bytes = text.as_bytes();
                let last = values.last().filter(|last| last.data() == bytes);
                let value = last.map_or_else(|| ByteArray::from(bytes.to_vec()), Clone::clone);
                values.push(value);
                true
            }
            (Typed::Integer(values), Cell::Integer(value)) => {
                values.push(value);
                true
            }
            (Typed::Real(values), Cell::Real(value)) => {
                values.push(value);
                true
            }
            (Typed::Flag(values), Cell::Flag(value)) => {
                values.push(value);
                true
            }
            // Rows are checked before.
            _ => false,
        };
        self.defined.push(i16::from(is_there));
    }

    /// Writes and forgets them.
    fn write(&mut self, column: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
        let defined = std::mem::take(&mut self.defined);
        let levels = Some(&defined[..]);
        match (&mut self.of, column) {
            (Typed::Text(values), ColumnWriter::ByteArrayColumnWriter(column)) => {
                column.write_batch(&std::mem::take(values), levels, None)?;
            }
            (Typed::Integer(values), ColumnWriter::Int64ColumnWriter(column)) => {
                column.write_batch(&std::mem::take(values), levels, None)?;
            }
            (Typed::Real(values), ColumnWriter::DoubleColumnWriter(column)) => {
                column.write_batch(&std::mem::take(values), levels, None)?;
            }
            (Typed::Flag(values), ColumnWriter::BoolColumnWriter(column)) => {
                column.write_batch(&std::mem::take(values), levels, None)?;
            }
            _ => return Err(ParquetError::General("a column of another type".into())),
        }
        Ok(())
    }
}

/// A Parquet file that is being written.
pub(crate) struct ParquetFile<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    columns: Vec<Values>,
    rows: usize,
}

impl<W: Write + Send> ParquetFile<W> {
    pub fn new(columns: &[Column], sink: W) -> Result<Self, ParquetError> {
        let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields);
        let schema = Arc::new(schema.build()?);
        let properties = Arc::new(WriterProperties::builder().build());
        Ok(Self {
            writer: SerializedFileWriter::new(sink, schema, properties)?,
            columns: columns.iter().map(|c| Values::new(c.kind)).collect(),
            rows: 0,
        })
    }

    pub fn group<'a>(
        &mut self,
        common: &[Cell<'_>],
        rows: impl Iterator<Item = &'a [Cell<'a>]>,
    ) -> Result<(), ParquetError> {
        for row in rows {
            let cells = common.iter().chain(row);
            for (column, cell) in self.columns.iter_mut().zip(cells) {
                column.push(*cell);
            }
            self.rows += 1;
            if self.rows == GROUP {
                self.write_group()?;
            }
        }
        Ok(())
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for values in &mut self.columns {
            let column = group.next_column()?;
            let mut column =
                column.ok_or_else(|| ParquetError::General("a column too many".into()))?;
            values.write(column.untyped())?;
            column.close()?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }

    pub fn finish(mut self) -> Result<W, ParquetError> {
        if self.rows > 0 {
            self.write_group()?;
        }
        self.writer.into_inner()
    }
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Kind::Integer => (Physical::INT64, None),
        Kind::Real => (Physical::DOUBLE, None),
        Kind::Flag => (Physical::BOOLEAN, None),
    };
    let field = Type::primitive_type_builder(column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical);
    Ok(Arc::new(field.build()?))
}
