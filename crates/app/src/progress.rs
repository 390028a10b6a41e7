//! How far a command is that takes longer than two seconds, on standard error: the one form in which all commands state it.

use crate::terminal;
use std::io::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// What is done sooner prints nothing; elsewhere than at a terminal that is what ends before its first line.
const FIRST: Duration = Duration::from_secs(2);
/// Time between two lines where there is no terminal, and between two updates of a line where there is one.
const LINES: Duration = Duration::from_secs(10);
const UPDATES: Duration = Duration::from_millis(200);

static SILENT: AtomicBool = AtomicBool::new(false);

/// From now on nothing is shown.
pub fn silence() {
    SILENT.store(true, Ordering::Relaxed);
}

/// One line that is written over at a terminal, and now and then a line elsewhere.
#[derive(Debug)]
pub struct Progress {
    start: Instant,
    state: Mutex<State>,
    terminal: bool,
}

#[derive(Debug)]
struct State {
    /// When the next line is due.
    due: Instant,
    /// Whether a line stands there to be written over.
    shown: bool,
}

impl Progress {
    /// Begins now.
    pub fn new() -> Self {
        let (start, terminal) = (Instant::now(), terminal::overwrites());
        let first = if terminal { FIRST } else { LINES };
        Self {
            start,
            state: Mutex::new(State {
                due: start + first,
                shown: false,
            }),
            terminal,
        }
    }

    /// States which part is done, from 0 to 1 (`None`: nobody knows how much there is), and what is being done, if it is time for a line.
    pub fn show(&self, part: Option<f64>, what: impl FnOnce() -> String) {
        let now = Instant::now();
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        if now < state.due || SILENT.load(Ordering::Relaxed) {
            return;
        }
        state.due = now + if self.terminal { UPDATES } else { LINES };
        let line = line(now - self.start, part, &what());
        let mut err = std::io::stderr();
        // Progress that nobody reads is no reason to stop.
        let _ = match self.terminal {
            true => write!(err, "\r\x1b[K{line}"),
            false => writeln!(err, "{line}"),
        };
        state.shown = self.terminal;
    }

    /// Removes the line of a terminal: something else is printed, or all is done.
    pub fn clear(&self) {
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        if std::mem::take(&mut state.shown) {
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}

/// Does work that seldom states how far it is, and shows what it stated last again and again, so that time goes on also before the first of its parts is done.
pub fn shown_while<T>(work: impl FnOnce(&mut dyn FnMut(f64, &str)) -> T) -> T {
    let progress = Progress::new();
    let stated = Mutex::new((0.0, String::new()));
    let (goes_on, has_ended) = mpsc::channel::<()>();
    let show = || {
        let (part, what) = stated.lock().unwrap_or_else(|e| e.into_inner()).clone();
        progress.show(Some(part), || what);
    };
    std::thread::scope(|scope| {
        scope.spawn(move || {
            // Ends with the work, also with one that panics: nobody can send any more.
            while has_ended.recv_timeout(UPDATES) == Err(RecvTimeoutError::Timeout) {
                show();
            }
        });
        let _goes_on = goes_on;
        work(&mut |part, what| {
            *stated.lock().unwrap_or_else(|e| e.into_inner()) = (part, what.to_owned());
        })
    })
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Part, time that has passed, time that is left if what is to come takes as long as what was, and what is being done.
fn line(passed: Duration, part: Option<f64>, what: &str) -> String {
    let passed_s = passed.as_secs_f64();
    match part.map(|part| part.clamp(0.0, 1.0)) {
        Some(part) if part > 0.0 => format!(
            "{:3.0} %, {} passed, about {} left: {what}",
            100.0 * part,
            in_words(passed_s),
            in_words(passed_s * (1.0 - part) / part)
        ),
        Some(_) => format!("  0 %, {} passed: {what}", in_words(passed_s)),
        None => format!("{} passed: {what}", in_words(passed_s)),
    }
}

/// A time as people state it.
fn in_words(seconds: f64) -> String {
    match seconds {
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 99.5 * 60.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::line;
    use std::time::Duration;

    /// A quarter took 10 s, so three quarters take 30 s.
    #[test]
    fn what_is_left_takes_as_long_as_what_was() {
        let after = |seconds| Duration::from_secs(seconds);
        assert_eq!(
            line(after(10), Some(0.25), "work"),
            " 25 %, 10 s passed, about 30 s left: work"
        );
        assert_eq!(
            line(after(100), Some(0.01), "work"),
            "  1 %, 2 min passed, about 2.8 h left: work"
        );
        assert_eq!(line(after(3), Some(0.0), "work"), "  0 %, 3 s passed: work");
        assert_eq!(line(after(3), None, "work"), "3 s passed: work");
        // A level goes on a little when its input has ended.
        assert_eq!(
            line(after(8), Some(1.2), "work"),
            "100 %, 8 s passed, about 0 s left: work"
        );
    }
}
