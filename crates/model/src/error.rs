//! Why a file is refused.

use std::fmt;

/// The kind of what is wrong with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// Its name or its first bytes are of no form that is read.
    UnknownForm,
    /// It ends too early.
    Truncated,
    /// A number is not finite, or too large for a length.
    NotANumber,
    /// An index leads nowhere.
    NoSuchIndex,
    /// There is more of something than is read.
    TooLarge,
    /// It names a file that is not in its folder by its plain name.
    OutsideFolder,
    /// It names a file that is not there.
    Missing,
    /// It needs what is not read.
    NotRead,
    /// It is not as its form demands.
    Broken,
}

/// Why a file is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelError {
    /// The kind.
    pub flaw: Flaw,
    /// What was found.
    what: String,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for ModelError {}

impl ModelError {
    pub(crate) fn new(flaw: Flaw, what: impl Into<String>) -> Self {
        Self {
            flaw,
            what: what.into(),
        }
    }
}

/// A refusal by what was found.
pub(crate) fn flawed<T>(flaw: Flaw, what: impl Into<String>) -> Result<T, ModelError> {
    Err(ModelError::new(flaw, what))
}
