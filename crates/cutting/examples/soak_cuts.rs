//! Random cuts as many as wanted: `cargo run --release -p microsim-cutting --example soak_cuts -- STROKES SEED`.

#[path = "../tests/random_cuts/bodies.rs"]
mod bodies;
#[path = "../tests/random_cuts/soak.rs"]
mod soak;

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<u64>());
    let mut next = |default| numbers.next().unwrap_or(Ok(default));
    let (Ok(strokes), Ok(seed)) = (next(10_000), next(1)) else {
        eprintln!("usage: soak_cuts STROKES SEED");
        return ExitCode::from(2);
    };
    let mut last = 0;
    let report = |summary: &soak::Summary| {
        if summary.strokes / 1000 > last {
            last = summary.strokes / 1000;
            println!("{summary:?}");
        }
    };
    match soak::run(strokes as usize, seed, 12, &mut (), report) {
        Ok(summary) => {
            println!("{summary:#?}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
