//! `cargo xtask soak sessions`: what long sessions cost. Writes `tests/results/sessions.md`; fails if `report` or a replay of any length
//! needs more than 200 MB.
//!
//! `-- SECONDS …` prints the table for other lengths instead.

use microsim_tests::long::{Length, length};
use microsim_tests::measured::Cost;
use microsim_tests::repository;
use std::fmt::Write as _;
use std::process::ExitCode;

/// Simulated times \[s\]; the last one is two hours.
const LENGTHS: [u32; 5] = [300, 600, 1200, 2400, 7200];

/// Most memory of `report` and replays \[MB\].
const MEMORY: f64 = 200.0;

/// The page above its table.
const HEAD: &str = "\
# Long sessions

Command: `cargo xtask soak sessions`. Level 1 of touch-spheres with a second tool and a day for it: two forceps that go to and fro above the
spheres in legs of 5 s and minimum jerk, a recording of 62.5 samples a second each, tick 16 ms. No tissue: what is measured is what grows with the
length. CPU time of all threads (the kernel's count, 10 ms steps) and the largest resident memory (`VmHWM`) of each command, one run each.
`run` writes its report beside the session: page, JSON and the series of every sample, which is what its memory is.

";

fn main() -> ExitCode {
    let given: Result<Vec<u32>, _> = std::env::args().skip(1).map(|arg| arg.parse()).collect();
    let given = match given {
        Ok(given) => given,
        Err(error) => {
            eprintln!("expected lengths in whole seconds: {error}");
            return ExitCode::from(2);
        }
    };
    let lengths = match given.is_empty() {
        true => LENGTHS.to_vec(),
        false => given.clone(),
    };
    let mut page = String::from(
        "| simulated | session | `run` | per simulated second | `report` | `replay` | `replay --verify` | per simulated second |\n|---|---|---|---|---|---|---|---|\n",
    );
    print!("{page}");
    let mut too_much = false;
    for seconds in lengths {
        let found = length(seconds);
        let line = row(&found);
        print!("{line}");
        page.push_str(&line);
        let bounded = [found.report, found.replay, found.verify];
        too_much |= bounded.iter().any(|cost| cost.memory > MEMORY);
    }
    if given.is_empty() {
        let file = repository().join("tests/results/sessions.md");
        if let Err(error) = std::fs::write(&file, format!("{HEAD}{page}")) {
            eprintln!("{}: {error}", file.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::from(u8::from(too_much))
}

fn row(found: &Length) -> String {
    let cell = |cost: Cost| format!("{:.2} CPU s, {:.0} MB", cost.cpu, cost.memory);
    let each = |cost: Cost| format!("{:.2} ms", cost.cpu / f64::from(found.seconds) * 1e3);
    let mut row = format!("| {} s | {:.0} MB |", found.seconds, found.file);
    let _ = writeln!(
        row,
        " {} | {} | {} | {} | {} | {} |",
        cell(found.run),
        each(found.run),
        cell(found.report),
        cell(found.replay),
        cell(found.verify),
        each(found.verify)
    );
    row
}
