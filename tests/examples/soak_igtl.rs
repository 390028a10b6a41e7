//! `cargo xtask soak igtl -- MINUTES SEED`: mutated frames of real peers into the decoder for as long as one likes, ten minutes otherwise. A stream that breaks a rule is
//! printed as hexadecimal with the seed that makes it, and the exit status is 1.

#[path = "../../crates/igtl/tests/fuzz/mutate.rs"]
mod mutate;

use mutate::{Numbers, check, corpus, stream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Streams between two looks at the clock.
const BATCH: u64 = 1000;

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let mut number = |what: &str, default: f64| match words.next() {
        None => Some(default),
        Some(word) => word.parse().ok().or_else(|| {
            eprintln!("{what}: expected a number, found {word}");
            None
        }),
    };
    let (Some(minutes), Some(seed)) = (number("minutes", 10.0), number("seed", 1.0)) else {
        return ExitCode::from(2);
    };
    let seed = seed as u64;
    let corpus = corpus();
    let start = Instant::now();
    let end = Duration::from_secs_f64(60.0 * minutes);
    let (mut streams, mut messages, mut failed, mut bytes_all) = (0_u64, 0_u64, 0_u64, 0_u64);
    while start.elapsed() < end {
        for _ in 0..BATCH {
            // Each stream from numbers of its own, so that one can be made again alone.
            let mut numbers = Numbers(seed.wrapping_mul(1 << 40).wrapping_add(streams));
            let bytes = stream(&corpus, &mut numbers);
            let checked = catch_unwind(AssertUnwindSafe(|| check(&bytes, &mut numbers)));
            let Ok((count, has_failed)) = checked else {
                let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
                println!("FOUND: seed {seed}, stream {streams}: {digits}");
                return ExitCode::from(1);
            };
            streams += 1;
            messages += count as u64;
            failed += u64::from(has_failed);
            bytes_all += bytes.len() as u64;
        }
    }
    println!(
        "{streams} streams ({} MB, {:.0} s, seed {seed}): {messages} messages, {failed} streams ended in an error, nothing found",
        bytes_all >> 20,
        start.elapsed().as_secs_f64()
    );
    ExitCode::SUCCESS
}
