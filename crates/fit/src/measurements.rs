//! Measured stretches and stresses: a table of comma-separated values with a header.
//!
//! | column | what |
//! |---|---|
//! | `stretch_1`, `stretch_2` | length over that at rest along axes 1 and 2; an empty cell, or no such column: free, so that there is no stress |
//! | `cauchy_1 [kPa]`, `cauchy_2 [kPa]` | Cauchy stress, force per area as it is; an empty cell: not measured |
//! | `piola_1 [kPa]`, `piola_2 [kPa]` | instead: first Piola–Kirchhoff stress, force per area at rest |
//! | `protocol` | name of the test that a row is of; one test without it |
//!
//! The unit of a stress stands in brackets, one of those that files have. Lines that begin with `#` are remarks. A uniaxial test along the
//! first axis has `stretch_1` and a stress there; one of a strip across it `stretch_2`; a biaxial one both. Commas alone separate cells:
//! there are no quotes.

use microsim_settings::Unit;
use std::fmt;

/// Which stress a table has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StressMeasure {
    /// Force per area of the deformed body.
    Cauchy,
    /// First Piola–Kirchhoff: force per area at rest.
    Piola,
}

/// A row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Index of its protocol.
    pub protocol: usize,
    /// Along axes 1 and 2; `None` where the specimen is free.
    pub stretch: [Option<f64>; 2],
    /// Along axes 1 and 2 \[Pa\]; `None` where it was not measured.
    pub stress: [Option<f64>; 2],
}

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurements {
    /// Which stress it is.
    pub measure: StressMeasure,
    /// Names of the protocols, as they come.
    pub protocols: Vec<String>,
    /// In the order of the table.
    pub rows: Vec<Measurement>,
}

/// What is wrong with a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableError {
    /// Line of the text, from 1.
    pub line: u64,
    /// The column, where it is that of one.
    pub column: Option<String>,
    /// What stands there.
    pub found: String,
    /// What should.
    pub expected: String,
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.line)?;
        if let Some(column) = &self.column {
            write!(f, "column `{column}`: ")?;
        }
        write!(f, "found {}, expected {}", self.found, self.expected)
    }
}

impl std::error::Error for TableError {}

impl StressMeasure {
    /// As columns name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cauchy => "cauchy",
            Self::Piola => "piola",
        }
    }
}

/// A line of a table, cut into cells.
struct Record<'a> {
    line: u64,
    cells: Vec<&'a str>,
}

/// What a column holds; axes from 0.
enum Column {
    Protocol,
    Stretch(usize),
    Stress {
        measure: StressMeasure,
        axis: usize,
        unit: String,
    },
}

const COLUMNS: &str = "`protocol`, `stretch_1`, `stretch_2`, and `cauchy_1 [kPa]`, `cauchy_2 [kPa]` or `piola_1 [kPa]`, `piola_2 [kPa]`";

impl Column {
    /// By its heading; the error is what is expected.
    fn parse(heading: &str) -> Result<Self, String> {
        let (name, unit) = match heading.split_once('[') {
            Some((name, unit)) => (name.trim(), unit.trim().strip_suffix(']').map(str::trim)),
            None => (heading, None),
        };
        let (quantity, axis) = match name.rsplit_once('_') {
            Some((quantity, "1")) => (quantity, 0),
            Some((quantity, "2")) => (quantity, 1),
            _ if name == "protocol" => return Ok(Self::Protocol),
            _ => return Err(format!("one of the columns {COLUMNS}")),
        };
        let measure = match quantity {
            "stretch" if heading.contains('[') => {
                return Err("no unit: a stretch is a length over that at rest".to_owned());
            }
            "stretch" => return Ok(Self::Stretch(axis)),
            "cauchy" => StressMeasure::Cauchy,
            "piola" => StressMeasure::Piola,
            _ => return Err(format!("one of the columns {COLUMNS}")),
        };
        let unit = unit.filter(|unit| Unit::Pressure.to_si(1.0, unit).is_some());
        let unit = unit.ok_or_else(|| {
            let symbols: Vec<&str> = Unit::Pressure.symbols().collect();
            format!("a unit in brackets behind it: {}", symbols.join(", "))
        })?;
        Ok(Self::Stress {
            measure,
            axis,
            unit: unit.to_owned(),
        })
    }

    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Protocol, Self::Protocol) => true,
            (Self::Stretch(a), Self::Stretch(b)) => a == b,
            (Self::Stress { axis: a, .. }, Self::Stress { axis: b, .. }) => a == b,
            _ => false,
        }
    }
}

impl Measurements {
    /// Reads a table.
    ///
    /// ```
    /// use microsim_fit::Measurements;
    ///
    /// let table = "stretch_1,piola_1 [kPa]\n1.1,4.5\n1.2,8.2\n";
    /// let read = Measurements::read(table)?;
    /// assert_eq!(read.rows[1].stretch, [Some(1.2), None]);
    /// assert_eq!(read.rows[1].stress, [Some(8200.0), None]);
    /// # Ok::<(), microsim_fit::TableError>(())
    /// ```
    pub fn read(text: &str) -> Result<Self, TableError> {
        // What spreadsheets put before a text in UTF-8.
        let text = text.trim_start_matches('\u{feff}');
        let lines = (1..).zip(text.lines().map(str::trim));
        let mut records = lines
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
            .map(|(line, text)| Record {
                line,
                cells: text.split(',').map(str::trim).collect(),
            });
        let header = records.next().ok_or_else(|| TableError {
            line: 1,
            column: None,
            found: "nothing".to_owned(),
            expected: format!("a header with {COLUMNS}"),
        })?;
        let (columns, measure) = columns(&header)?;
        let mut read = Self {
            measure,
            protocols: Vec::new(),
            rows: Vec::new(),
        };
        for record in records {
            read.push(&record, &header, &columns)?;
        }
        match read.rows.is_empty() {
            true => Err(TableError {
                line: header.line,
                column: None,
                found: "a header alone".to_owned(),
                expected: "rows below it".to_owned(),
            }),
            false => Ok(read),
        }
    }

    /// The measured stresses \[Pa\], row by row, with the index of their protocol.
    pub fn stresses(&self) -> impl Iterator<Item = (usize, f64)> {
        let of_row = |row: &Measurement| {
            let protocol = row.protocol;
            row.stress.into_iter().flatten().map(move |s| (protocol, s))
        };
        self.rows.iter().flat_map(of_row)
    }

    fn push(
        &mut self,
        record: &Record<'_>,
        header: &Record<'_>,
        columns: &[Column],
    ) -> Result<(), TableError> {
        let line = record.line;
        if record.cells.len() != columns.len() {
            return Err(TableError {
                line,
                column: None,
                found: format!("a row of length {}", record.cells.len()),
                expected: format!("{}, as the header has", columns.len()),
            });
        }
        let (mut stretch, mut stress) = ([None; 2], [None; 2]);
        let mut protocol = "";
        for (index, column) in columns.iter().enumerate() {
            let cell = record.cells[index];
            let wrong = |found: String, expected: &str| TableError {
                line,
                column: Some(header.cells[index].to_owned()),
                found,
                expected: expected.to_owned(),
            };
            let number = |expected: &str| match cell {
                "" => Ok(None),
                cell => match cell.parse::<f64>() {
                    Ok(number) if number.is_finite() => Ok(Some(number)),
                    _ => Err(wrong(format!("`{cell}`"), expected)),
                },
            };
            match column {
                Column::Protocol if cell.is_empty() => {
                    return Err(wrong("nothing".to_owned(), "the name of a test"));
                }
                Column::Protocol => protocol = cell,
                Column::Stretch(axis) => {
                    let expected = "a stretch above 0, or nothing where the specimen is free";
                    stretch[*axis] = number(expected)?;
                    if stretch[*axis].is_some_and(|stretch| stretch <= 0.0) {
                        return Err(wrong(format!("`{cell}`"), expected));
                    }
                }
                Column::Stress { axis, unit, .. } => {
                    let number = number("a stress, or nothing where it was not measured")?;
                    stress[*axis] = number.and_then(|n| Unit::Pressure.to_si(n, unit));
                }
            }
        }
        let wrong = |found: &str, expected: &str| TableError {
            line,
            column: None,
            found: found.to_owned(),
            expected: expected.to_owned(),
        };
        for (axis, (stress, stretch)) in stress.iter().zip(stretch).enumerate() {
            if stress.is_some() && stretch.is_none() {
                let found = format!("a stress along axis {} without a stretch", axis + 1);
                return Err(wrong(&found, "both: an axis without a stretch is free"));
            }
        }
        if stress == [None; 2] {
            return Err(wrong("no stress", "one at least in each row"));
        }
        let known = self.protocols.iter().position(|known| known == protocol);
        let protocol = known.unwrap_or_else(|| {
            self.protocols.push(protocol.to_owned());
            self.protocols.len() - 1
        });
        self.rows.push(Measurement {
            protocol,
            stretch,
            stress,
        });
        Ok(())
    }
}

/// What the columns hold, and which stress it is.
fn columns(header: &Record<'_>) -> Result<(Vec<Column>, StressMeasure), TableError> {
    let mut columns: Vec<Column> = Vec::new();
    let mut measure = None;
    for heading in &header.cells {
        let wrong = |found: String, expected: String| TableError {
            line: header.line,
            column: Some((*heading).to_owned()),
            found,
            expected,
        };
        let column = Column::parse(heading).map_err(|expected| {
            let found = match heading {
                &"" => "a column without a name".to_owned(),
                heading => format!("`{heading}`"),
            };
            wrong(found, expected)
        })?;
        if let Column::Stress { measure: own, .. } = column {
            if measure.is_some_and(|measure| measure != own) {
                let found = "a second kind of stress".to_owned();
                let expected = "Cauchy stresses or first Piola-Kirchhoff ones in all columns";
                return Err(wrong(found, expected.to_owned()));
            }
            measure = Some(own);
        }
        if columns.iter().any(|known| known.is_same(&column)) {
            let expected = "each column once".to_owned();
            return Err(wrong(format!("`{heading}` a second time"), expected));
        }
        columns.push(column);
    }
    let missing = |found: &str| TableError {
        line: header.line,
        column: None,
        found: found.to_owned(),
        expected: format!("columns among {COLUMNS}"),
    };
    if !columns.iter().any(|c| matches!(c, Column::Stretch(_))) {
        return Err(missing("no column with a stretch"));
    }
    let measure = measure.ok_or_else(|| missing("no column with a stress"))?;
    Ok((columns, measure))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_in_si_with_its_protocols() {
        let table = "# a remark\nprotocol, stretch_1, stretch_2, cauchy_1 [kPa], cauchy_2 [MPa]\n\
                     along, 1.1,, 2, \n across,, 1.2,, 0.003\nboth,1.05,1.1,1,-0.5\nalong,1.2,,4,\n";
        let read = Measurements::read(table).expect("the table is right");
        assert_eq!(read.measure, StressMeasure::Cauchy);
        assert_eq!(read.protocols, ["along", "across", "both"]);
        let row = |protocol, stretch, stress| Measurement {
            protocol,
            stretch,
            stress,
        };
        assert_eq!(
            read.rows,
            [
                row(0, [Some(1.1), None], [Some(2e3), None]),
                row(1, [None, Some(1.2)], [None, Some(3e3)]),
                row(2, [Some(1.05), Some(1.1)], [Some(1e3), Some(-5e5)]),
                row(0, [Some(1.2), None], [Some(4e3), None]),
            ]
        );
        let stresses: Vec<(usize, f64)> = read.stresses().collect();
        assert_eq!(
            stresses,
            [(0, 2e3), (1, 3e3), (2, 1e3), (2, -5e5), (0, 4e3)]
        );
    }

    #[test]
    fn each_mistake_is_named_with_its_line() {
        let columns = format!("columns among {COLUMNS}");
        for (table, expected) in [
            ("", format!("1: found nothing, expected a header with {COLUMNS}")),
            ("stretch_1,cauchy_1 [kPa]\n", "1: found a header alone, expected rows below it".to_owned()),
            ("stretch_1\n1.1\n", format!("1: found no column with a stress, expected {columns}")),
            ("piola_1 [Pa]\n1\n", format!("1: found no column with a stretch, expected {columns}")),
            (
                "stretch_1,stress\n1,2\n",
                format!("1: column `stress`: found `stress`, expected one of the columns {COLUMNS}"),
            ),
            (
                "stretch_1,cauchy_1\n1,2\n",
                "1: column `cauchy_1`: found `cauchy_1`, expected a unit in brackets behind it: Pa, GPa, MPa, kPa".to_owned(),
            ),
            (
                "stretch_1,cauchy_1 [mm]\n1,2\n",
                "1: column `cauchy_1 [mm]`: found `cauchy_1 [mm]`, expected a unit in brackets behind it: Pa, GPa, MPa, kPa".to_owned(),
            ),
            (
                "stretch_1 [%],cauchy_1 [Pa]\n1,2\n",
                "1: column `stretch_1 [%]`: found `stretch_1 [%]`, expected no unit: a stretch is a length over that at rest".to_owned(),
            ),
            (
                "stretch_1,stretch_2,cauchy_1 [Pa],piola_2 [Pa]\n1,1,1,1\n",
                "1: column `piola_2 [Pa]`: found a second kind of stress, expected Cauchy stresses or first Piola-Kirchhoff ones in all columns".to_owned(),
            ),
            (
                "stretch_1,cauchy_1 [Pa],cauchy_1 [kPa]\n1,1,1\n",
                "1: column `cauchy_1 [kPa]`: found `cauchy_1 [kPa]` a second time, expected each column once".to_owned(),
            ),
            (
                "# 1\nstretch_1,cauchy_1 [Pa]\n1.1,1\n1.2\n",
                "4: found a row of length 1, expected 2, as the header has".to_owned(),
            ),
            (
                "stretch_1,cauchy_1 [Pa]\n1.1,1\n\nzwei,1\n",
                "4: column `stretch_1`: found `zwei`, expected a stretch above 0, or nothing where the specimen is free".to_owned(),
            ),
            (
                "stretch_1,cauchy_1 [Pa]\n-0.5,1\n",
                "2: column `stretch_1`: found `-0.5`, expected a stretch above 0, or nothing where the specimen is free".to_owned(),
            ),
            (
                "stretch_1,cauchy_1 [Pa]\n1.5,nan\n",
                "2: column `cauchy_1 [Pa]`: found `nan`, expected a stress, or nothing where it was not measured".to_owned(),
            ),
            (
                "stretch_1,cauchy_1 [Pa]\n1.5,\n",
                "2: found no stress, expected one at least in each row".to_owned(),
            ),
            (
                "stretch_1,cauchy_1 [Pa],cauchy_2 [Pa]\n1.5,1,0\n",
                "2: found a stress along axis 2 without a stretch, expected both: an axis without a stretch is free".to_owned(),
            ),
            (
                "protocol,stretch_1,cauchy_1 [Pa]\n,1.5,1\n",
                "2: column `protocol`: found nothing, expected the name of a test".to_owned(),
            ),
        ] {
            let error = Measurements::read(table).expect_err(table);
            assert_eq!(error.to_string(), expected, "{table}");
        }
    }
}
