//! How far a long command is, on standard error.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time between two lines where there is no terminal, and between two updates of a line where there is one.
const LINES: Duration = Duration::from_secs(10);
const UPDATES: Duration = Duration::from_millis(200);

/// A bar of this length, or a spinner without a length, at a terminal; nothing elsewhere.
pub fn bar(length: Option<u64>, template: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = match length {
        Some(length) => ProgressBar::new(length),
        None => ProgressBar::new_spinner(),
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// One line that is written over at a terminal, and now and then a line elsewhere.
pub struct StatusLine {
    last: Mutex<Option<Instant>>,
    terminal: bool,
}

impl StatusLine {
    pub fn new() -> Self {
        Self {
            last: Mutex::new(None),
            terminal: std::io::stderr().is_terminal(),
        }
    }

    /// One whose first line comes after the time between two: what is soon done prints nothing.
    pub fn later() -> Self {
        let line = Self::new();
        *line.last.lock().unwrap_or_else(|e| e.into_inner()) = Some(Instant::now());
        line
    }

    /// Shows a line, if it is time for one.
    pub fn show(&self, line: impl FnOnce() -> String) {
        let mut last = self.last.lock().unwrap_or_else(|e| e.into_inner());
        let often = if self.terminal { UPDATES } else { LINES };
        if last.is_some_and(|last| last.elapsed() < often) {
            return;
        }
        *last = Some(Instant::now());
        let (line, mut err) = (line(), std::io::stderr());
        // Progress that nobody reads is no reason to stop.
        let _ = match self.terminal {
            true => write!(err, "\r\x1b[K{line}"),
            false => writeln!(err, "{line}"),
        };
    }

    /// Removes the line of a terminal.
    pub fn finish(&self) {
        if self.terminal {
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}
