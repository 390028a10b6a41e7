//! `cargo xtask soak sessions`: what long sessions cost. Prints the table of `tests/results/long_sessions.md`.
//!
//! `-- SECONDS …` takes other lengths.

use microsim_tests::long::length;
use std::process::ExitCode;

/// Simulated times \[s\]; the last one is two hours.
const LENGTHS: [u32; 5] = [300, 600, 1200, 2400, 7200];

/// Most memory of `report` and `replay` \[MB\].
const MEMORY: f64 = 200.0;

fn main() -> ExitCode {
    let given: Result<Vec<u32>, _> = std::env::args().skip(1).map(|arg| arg.parse()).collect();
    let lengths = match given {
        Ok(given) if given.is_empty() => LENGTHS.to_vec(),
        Ok(given) => given,
        Err(error) => {
            eprintln!("expected lengths in whole seconds: {error}");
            return ExitCode::from(2);
        }
    };
    println!(
        "| simulated | session | `run` | per simulated second | `report` | `replay --verify` |"
    );
    println!("|---|---|---|---|---|---|");
    let mut too_much = false;
    for seconds in lengths {
        let found = length(seconds);
        let cell = |cost: microsim_tests::measured::Cost| {
            format!("{:.2} CPU s, {:.0} MB", cost.cpu, cost.memory)
        };
        println!(
            "| {seconds} s | {:.0} MB | {} | {:.2} ms | {} | {} |",
            found.file,
            cell(found.run),
            found.run.cpu / f64::from(seconds) * 1e3,
            cell(found.report),
            cell(found.replay)
        );
        too_much |= found.report.memory.max(found.replay.memory) > MEMORY;
    }
    ExitCode::from(u8::from(too_much))
}
