//! Strokes of a trembling hand, as many as wanted: `cargo run --release -p microsim-cutting --example soak_tremor -- STROKES SEED`.

#[path = "../tests/tremor/hand.rs"]
mod hand;
#[path = "../tests/tremor/regions.rs"]
mod regions;
#[path = "../tests/tremor/soak.rs"]
mod soak;

use hand::Course;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<u64>());
    let mut next = |default| numbers.next().unwrap_or(Ok(default));
    let (Ok(strokes), Ok(seed)) = (next(1_000), next(1)) else {
        eprintln!("usage: soak_tremor STROKES SEED");
        return ExitCode::from(2);
    };
    let report = |summary: &soak::Summary| {
        if summary.strokes.is_multiple_of(100) {
            println!("{summary:?}");
        }
    };
    let mut failed = false;
    for course in [Course::Straight, Course::Looped] {
        match soak::run(strokes as usize, seed, course, report) {
            Ok(summary) => {
                println!("{course:?}: {summary:#?}");
                failed |= !summary.joined.is_empty() || !summary.split.is_empty();
            }
            Err(error) => {
                eprintln!("error: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::from(u8::from(failed))
}
