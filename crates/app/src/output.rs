//! How the program ends and prints: exit status, standard output, the log.

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

/// Exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done,
    /// The verdict that was asked for is negative.
    Negative,
    /// Could not run.
    CouldNotRun,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        match exit {
            Exit::Done => Self::SUCCESS,
            Exit::Negative => Self::from(1),
            Exit::CouldNotRun => Self::from(2),
        }
    }
}

/// Why a command could not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// Nobody reads standard output any more; not an error.
    BrokenPipe,
    /// One or several sentences.
    Text(String),
}

impl<E: Display> From<E> for Problem {
    fn from(error: E) -> Self {
        Self::Text(error.to_string())
    }
}

/// Writes a line to standard output.
pub fn print(text: impl Display) -> Result<(), Problem> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{text}").map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => Problem::BrokenPipe,
        _ => Problem::Text(format!("standard output: {error}")),
    })
}

/// Writes a line to standard output for those who read it: where an exit status follows, it does not depend on that.
pub fn print_if_read(text: impl Display) -> Result<(), Problem> {
    match print(text) {
        Err(Problem::BrokenPipe) => Ok(()),
        other => other,
    }
}

/// Writes a JSON document, and nothing else, to standard output.
pub fn print_json(value: &serde_json::Value) -> Result<(), Problem> {
    print(format!("{value:#}"))
}
