//! The other engines: the scripts of `tests/peers`, one process per run.

use crate::install::install;
use crate::row::Row;
use microsim_tests::repository;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// An engine and its script.
pub struct Engine {
    /// In arguments and names of files: `tests/peers/engine_NAME.py`, `tests/peers/requirements-NAME.txt`.
    pub name: &'static str,
    /// In tables.
    pub title: &'static str,
}

/// All of them.
pub const ENGINES: &[Engine] = &[
    Engine {
        name: "mujoco",
        title: "MuJoCo",
    },
    Engine {
        name: "drake",
        title: "Drake",
    },
    Engine {
        name: "pypbd",
        title: "pyPBD",
    },
];

/// One thread for every library that has its own.
const ONE_THREAD: [&str; 3] = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"];

/// A run is ended after this time, by default and if everything is asked for.
const LIMITS: [Duration; 2] = [Duration::from_secs(240), Duration::from_secs(3600)];

/// All runs of an engine, by the interpreter of the environment in `folder`. The error states in one sentence why there are none.
pub fn measure(
    engine: &Engine,
    python: &Path,
    folder: &Path,
    all: bool,
) -> Result<Vec<Row>, String> {
    install(engine, python, folder)?;
    let script = repository().join(format!("tests/peers/engine_{}.py", engine.name));
    let script = |words: &[&str]| {
        let mut command = Command::new(python);
        command.arg("-B").arg(&script).args(words);
        command.current_dir(folder);
        command.envs(ONE_THREAD.map(|name| (name, "1")));
        command
    };
    let runs = printed(&mut script(&["list"]))
        .map_err(|why| format!("it is installed but does not start: {why}"))?;
    let mut rows = Vec::new();
    for line in runs.lines() {
        let planned = Row::planned(engine.title, line);
        let (mut row, slow) =
            planned.map_err(|why| format!("its script lists a bad run: {why}"))?;
        match slow {
            Some(why) if !all => row.note = format!("left out without --all: {why}"),
            _ => {
                let command = &mut script(&["run", line, &folder.to_string_lossy()]);
                let told = limited(
                    command,
                    &folder.join("printed.txt"),
                    LIMITS[usize::from(all)],
                );
                let taken = told.and_then(|told| {
                    row.fill(&told)
                        .map_err(|why| format!("its result cannot be read: {why}"))
                });
                if let Err(why) = taken {
                    row.note = why;
                }
            }
        }
        crate::say(&row);
        rows.push(row);
    }
    Ok(rows)
}

/// The output of a program, if it ended well; if not, the last line of its complaint.
pub fn printed(command: &mut Command) -> Result<String, String> {
    let output = command
        .output()
        .map_err(|e| format!("{}: {e}", command.get_program().display()))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(complaint(&[&output.stderr, &output.stdout])
            .unwrap_or_else(|| output.status.to_string()))
    }
}

/// The last line that is not empty, of the first stream that has one.
fn complaint(streams: &[&[u8]]) -> Option<String> {
    streams.iter().find_map(|bytes| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let last = text
            .lines()
            .rev()
            .map(str::trim)
            .find(|line| !line.is_empty());
        last.map(String::from)
    })
}

/// The last line with a JSON object that a program prints before `limit`. `log` takes the rest of its output.
fn limited(command: &mut Command, log: &Path, limit: Duration) -> Result<String, String> {
    let create = |path: &Path| File::create(path).map_err(|e| format!("{}: {e}", path.display()));
    let error_log = log.with_extension("error");
    command.stdout(create(log)?).stderr(create(&error_log)?);
    let mut child = command
        .stdin(Stdio::null())
        .spawn()
        .map_err(|e| e.to_string())?;
    let start = Instant::now();
    let status = loop {
        match child.try_wait().map_err(|e| e.to_string())? {
            Some(status) => break status,
            None if start.elapsed() > limit => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("ended after {} s", limit.as_secs()));
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    };
    let output = fs::read_to_string(log).unwrap_or_default();
    if !status.success() {
        let errors = fs::read(&error_log).unwrap_or_default();
        let why = complaint(&[&errors, output.as_bytes()]).unwrap_or_default();
        return Err(format!("fails ({status}): {why}"));
    }
    let last = output.lines().rev().find(|line| line.starts_with('{'));
    last.map(String::from).ok_or("it prints no result".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_run_that_fails_or_does_not_end_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let run = |script, seconds| {
            let limit = Duration::from_secs_f64(seconds);
            limited(
                &mut shell(script),
                &folder.path().join("printed.txt"),
                limit,
            )
        };
        let told = run("echo hello; echo '{\"a\": 1}'; echo bye", 60.0);
        assert_eq!(told, Ok("{\"a\": 1}".into()));
        assert_eq!(run("echo hello", 60.0), Err("it prints no result".into()));
        assert_eq!(
            run("echo first >&2; echo why >&2; echo >&2; exit 3", 60.0),
            Err("fails (exit status: 3): why".into())
        );
        assert_eq!(run("exec sleep 60", 0.1), Err("ended after 0 s".into()));
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let why = printed(&mut Command::new("no-such-program")).unwrap_err();
        assert!(why.starts_with("no-such-program: "), "{why}");
    }
}
