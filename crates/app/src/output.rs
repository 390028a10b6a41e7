//! How the program ends and prints: exit status, standard output, the log.

use std::borrow::Cow;
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
    /// Ran and recorded, but the report could not be written.
    NoReport,
}

impl Exit {
    /// The number that the system is given.
    pub fn status(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Negative => 1,
            Self::CouldNotRun => 2,
            Self::NoReport => 3,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.status())
    }
}

/// Why a command could not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// Nobody reads standard output any more, as a pipe or terminal was closed; not an error.
    BrokenPipe,
    /// One or several sentences.
    Text(String),
}

impl<E: Display> From<E> for Problem {
    fn from(error: E) -> Self {
        Self::Text(error.to_string())
    }
}

/// Text that comes from files as it can be shown: control characters, with which a terminal could be commanded, are written as numbers.
/// Line ends and tabs stay. In JSON, where they may stand in texts alone, the numbers mean the same.
fn harmless(text: &str) -> Cow<'_, str> {
    let commands = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(commands) {
        return text.into();
    }
    let shown = text.chars().map(|c| match commands(c) {
        true => format!("\\u{:04x}", u32::from(c)),
        false => c.to_string(),
    });
    shown.collect::<String>().into()
}

/// Writes a line to standard error, if anybody reads it.
pub fn complain(text: impl Display) {
    let text = text.to_string();
    let _ = writeln!(std::io::stderr().lock(), "microsim: {}", harmless(&text));
}

/// Writes a line to standard output.
pub fn print(text: impl Display) -> Result<(), Problem> {
    let text = text.to_string();
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", harmless(&text)).map_err(|error| match error.kind() {
        ErrorKind::BrokenPipe => Problem::BrokenPipe,
        // What writing to a closed terminal gives.
        _ if error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error()) => {
            Problem::BrokenPipe
        }
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

#[cfg(test)]
mod tests {
    use super::harmless;

    /// A title with the command that renames or clears a terminal.
    #[test]
    fn terminals_are_not_commanded_by_texts() {
        assert_eq!(harmless("a\tb\nc äµ"), "a\tb\nc äµ");
        assert_eq!(harmless("\u{1b}]0;x\u{7}"), "\\u001b]0;x\\u0007");
        assert_eq!(harmless("\u{9b}2J"), "\\u009b2J");
    }
}
