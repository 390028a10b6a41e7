//! `cargo xtask bench peers`: the reference beam in other engines and in ours, side by side in one run. Prints tables and writes
//! `tests/results/peers.csv`, `peers.md` and `peers.svg`.
//!
//! The engines come from PyPI into a virtual environment in the target folder; scripts in `tests/peers` drive them, one process
//! per run. Ours runs in this process. Everything is on one thread and one processor core, one run after another. Nothing is
//! asserted about time.
//!
//! Arguments: `--all` makes the slow runs too; `--only ENGINE` makes those of one engine (`ours`, `mujoco`, `drake`, `pypbd`) and
//! writes nothing; `--exact` computes `tests/peers/exact.json` again, by small explicit steps, and compares it with the reference.

mod beam;
mod curve;
mod exact;
mod install;
mod labels;
mod measure;
mod ours;
mod peers;
mod picture;
mod plot;
mod report;
mod row;

use row::Row;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// What is asked for.
#[derive(Debug, Default, PartialEq)]
struct Arguments {
    all: bool,
    exact: bool,
    only: Option<String>,
}

fn main() -> ExitCode {
    match arguments(std::env::args().skip(1)).and_then(|arguments| bench(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bench peers: {error}");
            ExitCode::from(2)
        }
    }
}

fn arguments(mut words: impl Iterator<Item = String>) -> Result<Arguments, String> {
    let mut arguments = Arguments::default();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--all" => arguments.all = true,
            "--exact" => arguments.exact = true,
            "--only" => arguments.only = Some(words.next().ok_or("`--only` needs an engine")?),
            _ => {
                return Err(format!(
                    "there is no \"{word}\"; there are: --all, --only ENGINE, --exact"
                ));
            }
        }
    }
    let mut known: Vec<&str> = peers::ENGINES.iter().map(|e| e.name).collect();
    known.push(ours::ENGINE);
    match &arguments.only {
        Some(name) if !known.contains(&name.as_str()) => Err(format!(
            "there is no engine \"{name}\"; there are: {}",
            known.join(", ")
        )),
        _ => Ok(arguments),
    }
}

fn bench(arguments: &Arguments) -> Result<(), String> {
    if arguments.exact {
        return exact::write();
    }
    let start = Instant::now();
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    stay_on_one_core()?;
    let wanted = |name: &str| arguments.only.as_ref().is_none_or(|only| only == name);
    let folder = work_folder()?;
    beam::write_meshes(&folder)?;
    let mut rows = Vec::new();
    let mut missing = Vec::new();
    if peers::ENGINES.iter().any(|engine| wanted(engine.name)) {
        let python = install::environment(&folder)?;
        for engine in peers::ENGINES.iter().filter(|engine| wanted(engine.name)) {
            match peers::measure(engine, &python, &folder, arguments.all) {
                Ok(measured) => rows.extend(measured),
                Err(reason) => {
                    eprintln!("{} is missing: {reason}", engine.title);
                    missing.push((engine.title, reason));
                }
            }
        }
        if rows.is_empty() {
            return Err("no other engine could be had, so there is nothing to compare with".into());
        }
    }
    if wanted(ours::ENGINE) {
        rows.extend(ours::measure(arguments.all));
    }
    let minutes = start.elapsed().as_secs_f64() / 60.0;
    let text = report::markdown(&rows, &missing, cores, minutes);
    println!("{text}");
    if arguments.only.is_some() {
        return Ok(());
    }
    let results = microsim_tests::repository().join("tests/results");
    let write = |name: &str, text: &str| {
        let path = results.join(name);
        std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
    };
    write("peers.csv", &row::csv(&rows))?;
    write("peers.md", &text)?;
    write("peers.svg", &picture::svg(&rows))
}

/// Keeps this process, and all that it starts, on the last core that it may use: no library can then gain from a second thread.
fn stay_on_one_core() -> Result<(), String> {
    let failed = |e| format!("this process cannot be kept on one core: {e}");
    let allowed = sched_getaffinity(None).map_err(failed)?;
    let mut one = CpuSet::new();
    if let Some(core) = (0..CpuSet::MAX_CPU)
        .rev()
        .find(|&core| allowed.is_set(core))
    {
        one.set(core);
    }
    sched_setaffinity(None, &one).map_err(failed)
}

/// The folder for the environment and the meshes, in the target folder that this program was built in.
fn work_folder() -> Result<PathBuf, String> {
    let program = std::env::current_exe().map_err(|e| format!("this program has no place: {e}"))?;
    // target/release/examples/bench_peers
    let target = program
        .ancestors()
        .nth(3)
        .ok_or("this program lies in no target folder")?;
    let folder = target.join("peers");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(folder)
}

/// One line of progress.
fn say(row: &Row) {
    let mut line = format!(
        "{} {}, {}, {}:",
        row.engine,
        row.method,
        row.mesh,
        report::step(row)
    );
    if let Some(cost) = row.cpu_s_per_s {
        line += &format!(
            " {} CPU s per s, peak {} at {};",
            report::figure(cost),
            report::percent(row.peak_error),
            report::percent(row.peak_time_error)
        );
    }
    if let Some(cost) = row.cpu_s_to_rest {
        line += &format!(
            " {} CPU s to rest, {};",
            report::figure(cost),
            report::percent(row.rest_error)
        );
    }
    eprintln!("{line} {}", row.note);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_understood_or_told() {
        let parsed = |line: &str| arguments(line.split_whitespace().map(String::from));
        assert_eq!(parsed(""), Ok(Arguments::default()));
        let drake = Arguments {
            all: true,
            exact: false,
            only: Some("drake".into()),
        };
        assert_eq!(parsed("--all --only drake"), Ok(drake));
        let wrong = [
            ("--only", "`--only` needs an engine"),
            (
                "--only sofa",
                "there is no engine \"sofa\"; there are: mujoco, drake, pypbd, ours",
            ),
            (
                "--quick",
                "there is no \"--quick\"; there are: --all, --only ENGINE, --exact",
            ),
        ];
        for (line, why) in wrong {
            assert_eq!(parsed(line), Err(why.into()));
        }
    }
}
