//! What can be wrong with a recording in CSV, and where.

use std::error::Error;
use std::fmt;

use super::MAX_SAMPLES;
use crate::QuaternionError;

/// Why a CSV file is not a recording. Its text begins with `file:line:`.
#[derive(Clone, Debug, PartialEq)]
pub struct CsvError {
    /// The file's name, as it was given.
    pub file: String,
    /// Line in the file, from 1.
    pub line: u64,
    /// What is wrong there.
    pub problem: CsvProblem,
}

/// What is wrong in a line of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub enum CsvProblem {
    /// The file has no header.
    Empty,
    /// The file has a header and no sample.
    NoSamples,
    /// The file has more than [`MAX_SAMPLES`] samples.
    TooManySamples,
    /// The CSV syntax is broken.
    Syntax(String),
    /// The header lacks a column of the column map.
    MissingColumn {
        /// The name that the column map gives.
        column: String,
        /// The names in the header.
        present: Vec<String>,
    },
    /// The header has a column of the column map twice.
    AmbiguousColumn(String),
    /// A row has another number of fields than the header.
    FieldCount {
        /// Number in the header.
        expected: usize,
        /// Number in the row.
        found: usize,
    },
    /// A field is not a number.
    NotANumber {
        /// Its column.
        column: String,
        /// What it holds.
        text: String,
    },
    /// A field is NaN, infinite or too large.
    NotFinite {
        /// Its column.
        column: String,
        /// What it holds.
        text: String,
    },
    /// A field of a visibility column is neither yes nor no.
    NotAFlag {
        /// Its column.
        column: String,
        /// What it holds.
        text: String,
    },
    /// Some but not all of a device's position fields are empty.
    PartialPosition {
        /// The device.
        device: String,
    },
    /// A row's time is not later than that of the row before.
    TimeNotIncreasing {
        /// Time of the row before `[s]`.
        before_s: f64,
        /// Time of this row `[s]`.
        found_s: f64,
    },
    /// The orientation is none.
    Quaternion {
        /// The device.
        device: String,
        /// Why.
        error: QuaternionError,
    },
}

impl fmt::Display for CsvError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.problem)
    }
}

impl Error for CsvError {}

impl fmt::Display for CsvProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(
                f,
                "the file is empty, expected a header with the names of the columns"
            ),
            Self::NoSamples => write!(f, "the header is followed by no sample"),
            Self::TooManySamples => {
                write!(f, "more than {MAX_SAMPLES} samples (rows times devices)")
            }
            Self::Syntax(message) => write!(f, "{message}"),
            Self::MissingColumn { column, present } => {
                write!(
                    f,
                    "column \"{column}\" is missing; the header has {}",
                    present.join(", ")
                )
            }
            Self::AmbiguousColumn(column) => {
                write!(f, "column \"{column}\" stands in the header more than once")
            }
            Self::FieldCount { expected, found } => {
                write!(
                    f,
                    "expected {expected} fields as in the header, found {found}"
                )
            }
            Self::NotANumber { column, text } => {
                write!(
                    f,
                    "column \"{column}\": expected a number such as -1.25, found \"{text}\""
                )
            }
            Self::NotFinite { column, text } => {
                write!(
                    f,
                    "column \"{column}\": expected a finite number, found \"{text}\""
                )
            }
            Self::NotAFlag { column, text } => {
                write!(
                    f,
                    "column \"{column}\": expected 1, 0, true or false, found \"{text}\""
                )
            }
            Self::PartialPosition { device } => write!(
                f,
                "device \"{device}\": expected all position fields to be filled, or all empty if it was not visible"
            ),
            Self::TimeNotIncreasing { before_s, found_s } => write!(
                f,
                "time {found_s} s does not come after {before_s} s of the row before"
            ),
            Self::Quaternion { device, error } => write!(f, "device \"{device}\": {error}"),
        }
    }
}
