//! `cargo xtask soak store`: sessions of several trainees, two at a time on one store, every other one killed by SIGKILL; whether a finished session is
//! lost, and whether the store is as the sessions show. Writes `tests/results/store.md`.
//!
//! `-- --runs N --trainees N --seed N` for other numbers (100, 10, 1).

use microsim_tests::repository;
use microsim_tests::stations::{KilledRuns, killed_runs};
use std::process::ExitCode;

fn report(found: &KilledRuns, trainees: usize, seed: u64) -> String {
    let KilledRuns {
        runs,
        killed,
        readable,
        finished,
        caught_up,
        ..
    } = found;
    let yes = |is: bool| if is { "yes" } else { "**no**" };
    format!(
        "# Sessions and the store, with `kill -9` in between

Command: `cargo xtask soak store`. {runs} runs of level 1 of touch-spheres of {trainees} trainees, every third by a script that fails, two at a time on one
store. Every other one is killed: half of these at a moment that is random (seed {seed}) over 1.2 times the length of a run that has the machine alone, half
up to 60 ms after its session has an end, while its report is written or its result entered. The store is then compared with one that the sessions alone give.

| | |
|---|---|
| runs | {runs} |
| … killed | {killed} |
| sessions that can be read | {readable} |
| … with an end | {finished} |
| … of these, not in the store when their process was killed, between end and entry, and entered by a later command | {caught_up} |
| **sessions that can be read and are not in the store** | **{}** |
| same sessions and results after `store rebuild` | {} |
| same sessions and results in a store made from the sessions alone | {} |
| `store check` finds nothing | {} |
",
        found.missing.len(),
        yes(found.same_after_rebuild),
        yes(found.same_as_rebuilt),
        yes(found.intact)
    )
}

fn main() -> ExitCode {
    let mut numbers = [100_u64, 10, 1];
    let args: Vec<String> = std::env::args().skip(1).collect();
    for pair in args.chunks(2) {
        let at = ["--runs", "--trainees", "--seed"]
            .iter()
            .position(|name| *name == pair[0]);
        match (at, pair.get(1).and_then(|n| n.parse().ok())) {
            (Some(at), Some(number)) if number > 0 => numbers[at] = number,
            _ => {
                eprintln!("usage: cargo xtask soak store [-- --runs N --trainees N --seed N]");
                return ExitCode::from(2);
            }
        }
    }
    let [runs, trainees, seed] = numbers;
    let found = killed_runs(runs as usize, trainees as usize, seed);
    let text = report(&found, trainees as usize, seed);
    println!("{text}");
    for path in &found.missing {
        println!("missing: {path}");
    }
    if args.is_empty() {
        let path = repository().join("tests/results/store.md");
        if let Err(error) = std::fs::write(&path, text) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::from(2);
        }
    }
    match found.is_good() {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}
