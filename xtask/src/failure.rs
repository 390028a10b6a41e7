//! How a command ends when it does not end well.

use std::fmt;
use std::process::ExitStatus;

/// Why a command stops, and with which exit code.
#[derive(Debug, PartialEq, Eq)]
pub enum Failure {
    /// A check was made and its answer is no: 1.
    Check(String),
    /// What was asked for could not be done: 2.
    Cannot(String),
    /// A program that was started has printed why it stops: its own code.
    Child(u8),
}

impl Failure {
    /// The code for the shell.
    pub fn code(&self) -> u8 {
        match self {
            Self::Check(_) => 1,
            Self::Cannot(_) => 2,
            Self::Child(code) => *code,
        }
    }

    /// Of a program that has spoken for itself. One that a signal ended could not run: 2.
    pub fn child(status: ExitStatus) -> Self {
        let code = status.code().and_then(|code| u8::try_from(code).ok());
        Self::Child(code.unwrap_or(2))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Check(text) | Self::Cannot(text) => f.write_str(text),
            Self::Child(_) => Ok(()),
        }
    }
}
