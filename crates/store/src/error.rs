//! Why the store could not do what was asked.

use rusqlite::ErrorCode;
use std::fmt;

/// Why the store could not do what was asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// Another process has held it for longer than one waits.
    Busy,
    /// It, or its folder, cannot be written.
    ReadOnly,
    /// There is no room for it.
    Full,
    /// It was written by a later version of MicroSim.
    Newer {
        /// Version of its tables.
        found: i64,
        /// The latest version that this program knows.
        known: i64,
    },
    /// Its bytes are wrong, or it is no store.
    Damaged(String),
    /// It cannot be opened.
    CannotOpen(String),
    /// What was asked is refused, in a sentence.
    Refused(String),
    /// Anything else that the database reports.
    Other(String),
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy => f.write_str("the store is locked by another process"),
            Self::ReadOnly => {
                f.write_str("the store cannot be written: it or its folder is read-only")
            }
            Self::Full => f.write_str("the store cannot be written: the disk is full"),
            Self::Newer { found, known } => write!(
                f,
                "the store has version {found} and this MicroSim knows versions up to {known}: a later MicroSim has to open it; nothing was changed"
            ),
            Self::Damaged(what) => write!(
                f,
                "the store is damaged ({what}); `microsim store export FILE.json` writes what is intact, and `microsim store rebuild` reads the sessions again"
            ),
            Self::CannotOpen(why) => write!(f, "the store cannot be opened: {why}"),
            Self::Refused(sentence) => f.write_str(sentence),
            Self::Other(what) => write!(f, "the store: {what}"),
        }
    }
}

impl std::error::Error for StoreError {}

impl From<rusqlite::Error> for StoreError {
    fn from(error: rusqlite::Error) -> Self {
        let text = error.to_string();
        let code = match &error {
            rusqlite::Error::SqliteFailure(failure, _) => failure.code,
            // A value of another type than every version writes.
            rusqlite::Error::FromSqlConversionFailure(..)
            | rusqlite::Error::InvalidColumnType(..)
            | rusqlite::Error::IntegralValueOutOfRange(..)
            | rusqlite::Error::Utf8Error(..) => return Self::Damaged(text),
            _ => return Self::Other(text),
        };
        match code {
            ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked => Self::Busy,
            ErrorCode::ReadOnly => Self::ReadOnly,
            ErrorCode::DiskFull => Self::Full,
            ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase => Self::Damaged(text),
            ErrorCode::CannotOpen | ErrorCode::PermissionDenied => Self::CannotOpen(text),
            _ => Self::Other(text),
        }
    }
}

/// A refusal in a sentence.
pub(crate) fn refuse<T>(sentence: impl Into<String>) -> Result<T, StoreError> {
    Err(StoreError::Refused(sentence.into()))
}
