//! The log, and the trace of where time goes.
//!
//! Both are made of the spans and events of `tracing`. The log goes to standard error: warnings and errors, more with `-v`, less with `-q`, as
//! `RUST_LOG` has it without either; from `debug` on every span prints how long it took. A file in the folder of logs has what was done, warnings
//! and errors, with times: one a day, the last [`FILES`] of them. It is written by a thread of its own, and what that cannot write is lost: no tick
//! waits for a disk. Names of trainees are not in it. A trace goes to a file that Perfetto and `chrome://tracing` open.

use crate::cli::Verbosity;
use crate::folders;
use crate::output::Problem;
use crate::terminal;
use microsim_settings::unwritable;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tracing::level_filters::LevelFilter;
use tracing_appender::non_blocking::{NonBlocking, NonBlockingBuilder, WorkerGuard};
use tracing_appender::rolling::{RollingFileAppender, Rotation};
use tracing_chrome::{ChromeLayerBuilder, FlushGuard};
use tracing_subscriber::filter::{EnvFilter, Targets};
use tracing_subscriber::fmt::format::FmtSpan;
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// The crates whose spans are stages of a run or scene; those of libraries would only hide them.
const TRACED: [&str; 3] = ["microsim", "microsim_host", "microsim_scene"];

/// Target of events for the file alone: standard error has them in other words.
pub const FILE: &str = "file";

/// Log files that stay, one a day.
const FILES: usize = 14;

/// Most that one process writes into log files \[bytes\].
const LIMIT: u64 = 16 << 20;

/// Lines that may wait to be written.
const WAITING: usize = 10_000;

/// How the names of log files begin and end.
const NAME: (&str, &str) = ("microsim", "log");

/// What writes log and trace: both are complete once this is dropped.
pub struct Writing {
    _file: Option<WorkerGuard>,
    _trace: Option<FlushGuard>,
}

/// Starts the log; that in files, if a folder is given; and the trace, if a file is named.
pub fn start(
    verbosity: &Verbosity,
    folder: Option<&Path>,
    trace: Option<&Path>,
) -> Result<Writing, Problem> {
    let log = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(terminal::has_colours())
        .with_target(false)
        .without_time()
        // Where nobody reads standard error any more, that is no reason to end.
        .log_internal_errors(false)
        .with_span_events(FmtSpan::CLOSE)
        .with_filter(filter(verbosity));
    let opened = folder.map(open);
    let (file, why) = match opened {
        Some(Ok(file)) => (Some(file), None),
        Some(Err(why)) => (None, Some(why)),
        None => (None, None),
    };
    let (writer, file) = file.unzip();
    let in_file = writer.map(|writer| {
        tracing_subscriber::fmt::layer()
            .with_writer(writer)
            .with_ansi(false)
            .log_internal_errors(false)
            .with_filter(LevelFilter::INFO)
    });
    let (in_trace, guard) = match trace {
        None => (None, None),
        Some(path) => {
            let made = File::create_new(path);
            let made = made.map_err(|e| format!("trace {}", unwritable(path, e)))?;
            let (layer, guard) = ChromeLayerBuilder::new()
                .writer(BufWriter::new(made))
                .include_args(true)
                .build();
            let traced = TRACED.map(|name| (name, LevelFilter::DEBUG));
            let layer = layer.with_filter(traced.into_iter().collect::<Targets>());
            (Some(layer), Some(guard))
        }
    };
    tracing_subscriber::registry()
        .with(log)
        .with(in_file)
        .with(in_trace)
        .init();
    if let Some(why) = why {
        // Nothing depends on it; `doctor` states it too.
        tracing::info!("there is no log file: {why}");
    }
    Ok(Writing {
        _file: file,
        _trace: guard,
    })
}

/// What goes to standard error.
fn filter(verbosity: &Verbosity) -> EnvFilter {
    let named = |level: &str| EnvFilter::new(format!("{level},{FILE}=off"));
    match verbosity.level() {
        0 => match EnvFilter::try_from_default_env() {
            Ok(filter) => match format!("{FILE}=off").parse() {
                Ok(directive) => filter.add_directive(directive),
                Err(_) => filter,
            },
            Err(_) => named("warn"),
        },
        ..=-2 => named("off"),
        -1 => named("error"),
        1 => named("info"),
        2 => named("debug"),
        3.. => named("trace"),
    }
}

/// Begins to write into the file of today.
fn open(folder: &Path) -> Result<(NonBlocking, WorkerGuard), String> {
    folders::make(folder)?;
    let files = RollingFileAppender::builder()
        .rotation(Rotation::DAILY)
        .filename_prefix(NAME.0)
        .filename_suffix(NAME.1)
        .max_log_files(FILES)
        .build(folder)
        .map_err(|e| format!("{}: {e}", folder.display()))?;
    let bounded = Bounded {
        out: files,
        left: LIMIT,
    };
    let builder = NonBlockingBuilder::default()
        .lossy(true)
        .buffered_lines_limit(WAITING)
        .thread_name("log");
    Ok(builder.finish(bounded))
}

/// The newest log file of a folder: names have the date.
pub fn newest(folder: &Path) -> Option<PathBuf> {
    let files = crate::listing::files_in(folder, NAME.1);
    files.into_iter().next_back()
}

/// Writes so much and no more, and states at the end that there is more.
struct Bounded<W> {
    out: W,
    left: u64,
}

impl<W: Write> Write for Bounded<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let length = bytes.len() as u64;
        if self.left > 0 && length >= self.left {
            self.left = 0;
            writeln!(
                self.out,
                "This process has written enough: the rest is left out"
            )?;
        } else if self.left > 0 {
            self.out.write_all(bytes)?;
            self.left -= length;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::Bounded;
    use std::io::Write;

    /// Whole lines up to the limit, then one that states it, then nothing.
    #[test]
    fn a_process_that_complains_without_end_does_not_fill_the_disk() {
        let mut bounded = Bounded {
            out: Vec::new(),
            left: 10,
        };
        for _ in 0..1000 {
            bounded.write_all(b"four\n").expect("memory");
        }
        let text = String::from_utf8(bounded.out).expect("text");
        assert_eq!(
            text,
            "four\nThis process has written enough: the rest is left out\n"
        );
    }
}
