//! `cargo xtask soak training [-- --minutes N --seed S]`: N minutes, 60 if not given, of scripted training in one process: in each round every module once, in random order,
//! with a random script of a random level. Each run is recorded, its forces are looked through, and every tenth is replayed in the same process.
//!
//! Ends with status 1 if a run fails, is not that of its script's name or not computed again to the bit, or if memory grows.

use microsim_tests::training::{Memory, Order, Played, Training};
use std::process::ExitCode;

/// Minutes of simulated time if none are given.
const MINUTES: f64 = 60.0;

fn order(words: &[String]) -> Option<(f64, u64)> {
    let (mut minutes, mut seed) = (MINUTES, 1);
    for pair in words.chunks(2) {
        match pair {
            [flag, value] if flag == "--minutes" => minutes = value.parse().ok()?,
            [flag, value] if flag == "--seed" => seed = value.parse().ok()?,
            _ => return None,
        }
    }
    (minutes > 0.0).then_some((minutes, seed))
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some((minutes, seed)) = order(&words) else {
        eprintln!("expected --minutes N, above 0, and --seed S, each if it is another one");
        return ExitCode::from(2);
    };
    match soak(60.0 * minutes, seed) {
        Ok(training) => conclude(&training),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn soak(seconds: f64, seed: u64) -> Result<Training, String> {
    let mut training = Training::new()?;
    let mut order = Order::new(seed);
    while training.simulated() < seconds {
        let exercise = order.next().expect("there is always another one");
        let played = training.play(exercise)?;
        print_run(played);
    }
    Ok(training)
}

fn print_run(played: &Played) {
    let exercise = &played.exercise;
    let [before, peak, after] = played.memory.map(megabytes);
    println!(
        "{}/{}: {:.1} s in {:.1} s, held {}, invalid {}{}, memory {before:.0}, {peak:.0}, {after:.0} MB{}",
        exercise.module,
        exercise.script,
        played.simulated,
        played.wall,
        played.held,
        played.invalid,
        if played.replayed { ", replayed" } else { "" },
        match played.faults.is_empty() {
            true => String::new(),
            false => format!(", FAULTS: {}", played.faults.join("; ")),
        }
    );
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}

fn conclude(training: &Training) -> ExitCode {
    let played = &training.played;
    let sum = |of: fn(&Played) -> f64| played.iter().map(of).sum::<f64>();
    println!(
        "{} runs, {} replayed, {:.1} min simulated in {:.1} min; {} ticks held, {} without meaning",
        played.len(),
        played.iter().filter(|of| of.replayed).count(),
        sum(|of| of.simulated) / 60.0,
        sum(|of| of.wall) / 60.0,
        sum(|of| of.held as f64),
        sum(|of| of.invalid as f64),
    );
    let memory = training.memory();
    let Memory {
        start,
        quarter,
        half,
        end,
        largest_run,
        ..
    } = memory;
    let [start, quarter, half, end, largest_run] =
        [start, quarter, half, end, largest_run].map(megabytes);
    println!(
        "resident memory at the start {start:.1} MB, after a quarter {quarter:.1}, half {half:.1}, at the end {end:.1}; a run takes {largest_run:.1} at most"
    );
    let faults = training.faults();
    for fault in &faults {
        println!("FAULT: {fault}");
    }
    if !memory.is_flat() {
        println!("FAULT: memory grows");
    }
    match faults.is_empty() && memory.is_flat() {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}
