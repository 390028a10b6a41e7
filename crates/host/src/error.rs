//! Why a run did not begin.

use crate::fault::Failure;
use crate::loader::LoadError;
use std::fmt;

/// A run that did not begin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunError {
    /// A library was refused.
    Load(LoadError),
    /// A plugin failed before the first tick.
    Start(Failure),
    /// The host itself could not start.
    Host(String),
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Load(e) => e.fmt(f),
            Self::Start(e) => e.fmt(f),
            Self::Host(e) => f.write_str(e),
        }
    }
}

impl std::error::Error for RunError {}

impl From<LoadError> for RunError {
    fn from(error: LoadError) -> Self {
        Self::Load(error)
    }
}

impl From<Failure> for RunError {
    fn from(failure: Failure) -> Self {
        Self::Start(failure)
    }
}
