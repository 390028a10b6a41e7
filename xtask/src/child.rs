//! Starts other programs and prints their command lines on standard error.

use crate::failure::Failure;
use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::Path;
use std::process::{Command, ExitStatus};

/// Runs a program to its end, with this program's input and output.
pub fn run(command: &mut Command) -> Result<ExitStatus, Failure> {
    echo(command);
    command.status().map_err(|e| not_started(command, &e))
}

/// Runs a program that has to succeed; if it does not, it has printed why.
pub fn must(command: &mut Command) -> Result<(), Failure> {
    let status = run(command)?;
    if status.success() {
        Ok(())
    } else {
        Err(Failure::child(status))
    }
}

/// Becomes another program, so that signals and exit code are its own. Returns only if it cannot be started.
#[cfg(unix)]
pub fn become_program(command: &mut Command) -> Failure {
    use std::os::unix::process::CommandExt;
    echo(command);
    let error = command.exec();
    not_started(command, &error)
}

/// Runs another program and ends as it does.
#[cfg(not(unix))]
pub fn become_program(command: &mut Command) -> Failure {
    match run(command) {
        Ok(status) => Failure::child(status),
        Err(failure) => failure,
    }
}

fn not_started(command: &Command, error: &std::io::Error) -> Failure {
    let program = command.get_program().to_string_lossy();
    Failure::Cannot(format!("{program} cannot be started: {error}"))
}

/// One line, dim at a terminal.
fn echo(command: &Command) {
    let here = std::env::current_dir().unwrap_or_default();
    let line = line(command, &here);
    let dim = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    match dim {
        true => eprintln!("\x1b[2m> {line}\x1b[0m"),
        false => eprintln!("> {line}"),
    }
}

/// The command as one would type it in the folder `here`.
fn line(command: &Command, here: &Path) -> String {
    let program = Path::new(command.get_program());
    let program = match program.file_stem() {
        // Cargo tells its children the full path of itself.
        Some(stem) if stem == "cargo" => stem,
        _ => program.strip_prefix(here).unwrap_or(program).as_os_str(),
    };
    let words: Vec<String> = [program]
        .into_iter()
        .chain(command.get_args())
        .map(word)
        .collect();
    words.join(" ")
}

fn word(word: &OsStr) -> String {
    let word = word.to_string_lossy();
    let plain = |c: char| c.is_alphanumeric() || "-_./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_echo_can_be_typed() {
        let mut command = Command::new("/home/a/clone/target/microsim/microsim");
        command.args([
            "run",
            "touch-spheres",
            "--input",
            "script:my file.toml",
            "*",
            "it's",
            "",
        ]);
        assert_eq!(
            line(&command, Path::new("/home/a/clone")),
            r"target/microsim/microsim run touch-spheres --input 'script:my file.toml' '*' 'it'\''s' ''"
        );
        assert_eq!(
            line(&Command::new("/opt/rust/bin/cargo"), Path::new("/")),
            "cargo"
        );
    }
}
