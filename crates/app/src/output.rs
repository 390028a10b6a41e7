//! How the program ends and prints: exit status, standard output, the log.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{BufWriter, ErrorKind, Write};
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

/// Writes whole lines as [`harmless`] shows them.
struct HarmlessLines<W> {
    out: W,
    /// What came behind the last line feed.
    rest: Vec<u8>,
}

impl<W: Write> Write for HarmlessLines<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.rest.extend(bytes);
        if let Some(end) = self.rest.iter().rposition(|byte| *byte == b'\n') {
            let behind = self.rest.split_off(end + 1);
            let lines = std::mem::replace(&mut self.rest, behind);
            let text = String::from_utf8_lossy(&lines);
            self.out.write_all(harmless(&text).as_bytes())?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// Writes a line to standard output.
pub fn print(text: impl Display) -> Result<(), Problem> {
    print_long(|out| write!(out, "{text}"))
}

/// Writes to standard output what is too long to be in memory at once, line by line, with a line feed behind it.
pub fn print_long(
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), Problem> {
    let mut out = BufWriter::new(HarmlessLines {
        out: std::io::stdout().lock(),
        rest: Vec::new(),
    });
    let written = write(&mut out)
        .and_then(|()| writeln!(out))
        .and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
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
    use super::{HarmlessLines, harmless};
    use std::io::Write;

    /// A title with the command that renames or clears a terminal.
    #[test]
    fn terminals_are_not_commanded_by_texts() {
        assert_eq!(harmless("a\tb\nc äµ"), "a\tb\nc äµ");
        assert_eq!(harmless("\u{1b}]0;x\u{7}"), "\\u001b]0;x\\u0007");
        assert_eq!(harmless("\u{9b}2J"), "\\u009b2J");
    }
    /// However the bytes are cut: here behind each of them, also within a character.
    #[test]
    fn long_texts_command_no_terminal_either() {
        let mut lines = HarmlessLines {
            out: Vec::new(),
            rest: Vec::new(),
        };
        for byte in "ä\u{9b}2J\n\u{7f}µ\n".bytes() {
            lines.write_all(&[byte]).expect("memory");
        }
        let shown = String::from_utf8(lines.out).expect("text");
        assert_eq!(shown, "ä\\u009b2J\n\\u007fµ\n");
    }
}
