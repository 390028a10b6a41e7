//! The `microsim` binary: command line and wiring, nothing else.
//!
//! Parsing only validates; the work is in one file per command. Exit status: 0 done (a failed level is a result, not an
//! error), 1 the verdict that was asked for is negative, 2 could not run, 3 the report of a run could not be written. Results go to standard output, logs and progress
//! to standard error.

#![allow(
    unsafe_code,
    reason = "asks the processor what it has before any code needs it; an environment variable before the first thread"
)]

mod atlas;
mod bus;
mod calibrate;
mod chart;
mod check;
mod cli;
mod completions;
mod constant;
mod courses;
mod date;
mod devices;
mod digests;
mod discretisation;
mod doctor;
mod erasure;
mod evaluation;
mod fit;
mod folders;
mod guest;
mod key_pictures;
mod list;
mod listen;
mod listing;
mod log;
mod man;
mod mesh;
mod mesh_file;
mod motion_length;
mod names;
mod output;
mod population;
mod processor;
mod progress;
mod record_input;
mod records;
mod replace_file;
mod replay;
mod report;
mod result_table;
mod results;
mod run;
mod scene_file;
mod schema;
mod series_table;
mod session_file;
mod sessions;
mod simulate;
mod station;
mod store;
mod table_rows;
mod terminal;
mod trainee;
mod trainees;
mod tune;
mod upkeep;
mod version;
mod views;
mod window;
mod working_step;
mod zone;

use clap::Parser;
use clap::error::ErrorKind;
use cli::{Cli, Command, WindowArgs};
use output::{Exit, Problem, complain};
use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    if let Some(complaint) = processor::complaint() {
        complain(complaint);
        return Exit::CouldNotRun.into();
    }
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.kind() == ErrorKind::InvalidUtf8 => {
            complain(not_utf8(std::env::args_os()).unwrap_or_else(|| error.to_string()));
            return Exit::CouldNotRun.into();
        }
        Err(error) => {
            // Help and version are no errors; everything else could not run.
            let code = if error.use_stderr() {
                Exit::CouldNotRun
            } else {
                Exit::Done
            };
            let _ = error.print();
            return code.into();
        }
    };
    // Before the log, which has a thread.
    silence_driver();
    if cli.verbosity.level() < 0 {
        progress::silence();
    }
    let command = cli
        .command
        .unwrap_or(Command::Window(WindowArgs::default()));
    let logged = command.logged();
    let folders = logged.and_then(|_| folders::Folders::of(&cli.place).ok());
    let logs = folders.as_ref().map(|folders| folders.logs.as_path());
    let writing = match log::start(&cli.verbosity, logs, command.trace()) {
        Ok(writing) => writing,
        Err(problem) => return ended(Err(problem)),
    };
    if let Some(command) = logged {
        let (version, process) = (version::text(), std::process::id());
        tracing::info!(target: log::FILE, command, version, process, "begins");
    }
    let result = match &command {
        Command::Window(args) => window::window(&cli.place, args),
        Command::List(args) => list::list(&cli.place, args),
        Command::Run(args) => run::run(&cli.place, args),
        Command::Simulate(args) => simulate::simulate(&cli.place, args),
        Command::Atlas(args) => atlas::atlas(args),
        Command::Chart(args) => chart::chart(&cli.place, args),
        Command::Tune(args) => tune::tune(&cli.place, args),
        Command::Fit(args) => fit::fit(args),
        Command::Replay(args) => replay::replay(&cli.place, args),
        Command::Report(args) => report::report(&cli.place, args),
        Command::Trainees(command) => trainees::trainees(&cli.place, command),
        Command::Courses(command) => courses::courses(&cli.place, command),
        Command::Results(args) => results::results(&cli.place, args),
        Command::Store(command) => store::store(&cli.place, command),
        Command::Trainee(args) => trainee::trainee(&cli.place, args),
        Command::Devices(args) => devices::devices(&cli.place, args),
        Command::RecordInput(args) => record_input::record_input(&cli.place, args),
        Command::Calibrate(command) => calibrate::calibrate(&cli.place, command),
        Command::Bus(args) => bus::bus(&cli.place, args),
        Command::Check(args) => check::check(&cli.place, args),
        Command::Mesh(command) => mesh::mesh(command),
        Command::Schema(args) => schema::schema(&cli.place, args),
        Command::Doctor(args) => doctor::doctor(&cli.place, args),
        Command::Completions(args) => completions::completions(args),
        Command::Man(args) => man::man(args),
        Command::Guest => guest::guest(),
        Command::Digests(args) => digests::digests(&cli.place, args),
    };
    if let Some(command) = logged {
        let status = match &result {
            Ok(exit) => exit.status(),
            Err(Problem::BrokenPipe) => Exit::Done.status(),
            Err(Problem::Text(_)) => Exit::CouldNotRun.status(),
        };
        let process = std::process::id();
        tracing::info!(target: log::FILE, command, status, process, "ends");
    }
    // Writes what is left.
    drop(writing);
    ended(result)
}

/// The exit status of a command; what it could not do goes to standard error.
fn ended(result: Result<Exit, Problem>) -> ExitCode {
    match result {
        Ok(exit) => exit.into(),
        Err(Problem::BrokenPipe) => Exit::Done.into(),
        Err(Problem::Text(text)) => {
            complain(text);
            Exit::CouldNotRun.into()
        }
    }
}

/// The first argument that is no text, in a sentence: paths go into sessions and reports as text.
fn not_utf8(arguments: impl Iterator<Item = OsString>) -> Option<String> {
    let mut arguments = arguments.enumerate();
    let (place, argument) = arguments.find(|(_, argument)| argument.to_str().is_none())?;
    Some(format!(
        "argument {place}, {argument:?}, is not UTF-8; expected arguments and names of files in UTF-8"
    ))
}

/// A layer of the graphics driver prints a line about a missing run-time folder at every start; it is not needed for
/// pictures.
fn silence_driver() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: no other thread has been started yet.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

#[cfg(test)]
mod tests {
    use super::not_utf8;
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;

    /// Of a long command line nobody finds the one that it is.
    #[test]
    fn the_argument_that_is_no_text_is_named() {
        let arguments = ["microsim", "run", "push-strip", "--input"];
        let mut arguments: Vec<OsString> = arguments.map(OsString::from).into();
        assert_eq!(not_utf8(arguments.iter().cloned()), None);
        arguments.push(OsString::from_vec(b"script:\xff.toml".into()));
        let said = "argument 4, \"script:\\xFF.toml\", is not UTF-8; expected arguments and names of files in UTF-8";
        assert_eq!(not_utf8(arguments.into_iter()).as_deref(), Some(said));
    }
}
