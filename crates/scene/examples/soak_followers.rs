//! Random cuts with model, solver and contact that follow, each compared with one rebuilt after each step:
//! `cargo run --release -p microsim-scene --example soak_followers -- STROKES SEED`.

#[path = "../../cutting/tests/random_cuts/bodies.rs"]
mod bodies;
#[path = "../tests/followers/followers.rs"]
mod followers;
#[path = "../../cutting/tests/random_cuts/soak.rs"]
mod soak;

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<u64>());
    let mut next = |default| numbers.next().unwrap_or(Ok(default));
    let (Ok(strokes), Ok(seed)) = (next(1_000), next(1)) else {
        eprintln!("usage: soak_followers STROKES SEED");
        return ExitCode::from(2);
    };
    let mut followers = followers::Followers::new(seed);
    let mut last = 0;
    let report = |summary: &soak::Summary| {
        if summary.strokes / 100 > last {
            last = summary.strokes / 100;
            println!("{} strokes", summary.strokes);
        }
    };
    match soak::run(strokes as usize, seed, 4, &mut followers, report) {
        Ok(summary) => {
            println!("{summary:#?}\n{:#?}", followers.tally);
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
