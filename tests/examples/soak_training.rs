//! `cargo xtask soak training [-- --minutes N --seed S]`: N minutes, 60 if not given, of scripted training in one process: in each round every module once, in random order,
//! with a random script of a random level. Each run is recorded, its forces are looked through, and every tenth is replayed in the same process.
//!
//! Writes `tests/results/training.md`. Ends with status 1 if a run fails, is not that of its script's name or not computed again to the bit, or if memory grows.

use microsim_tests::repository;
use microsim_tests::training::{Memory, Order, Played, Training};
use std::collections::BTreeMap;
use std::fmt::Write as _;
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
        Ok(training) => conclude(&training, seed),
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

fn conclude(training: &Training, seed: u64) -> ExitCode {
    let page = page(training, seed);
    print!("{page}");
    let path = repository().join("tests/results/training.md");
    if let Err(error) = std::fs::write(&path, page) {
        eprintln!("{}: {error}", path.display());
        return ExitCode::FAILURE;
    }
    match training.faults().is_empty() && training.memory().is_flat() {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

/// Sums over runs.
#[derive(Default)]
struct Sums {
    runs: u32,
    replayed: u32,
    simulated: f64,
    wall: f64,
    tissue: u64,
    held: u64,
    invalid: u64,
}

impl Sums {
    fn add(&mut self, played: &Played) {
        self.runs += 1;
        self.replayed += u32::from(played.replayed);
        self.simulated += played.simulated;
        self.wall += played.wall;
        self.tissue += played.tissue;
        self.held += played.held;
        self.invalid += played.invalid;
    }

    fn row(&self, name: &str) -> String {
        let Self {
            runs,
            replayed,
            simulated,
            wall,
            tissue,
            held,
            invalid,
        } = self;
        format!(
            "| {name} | {runs} | {replayed} | {:.1} | {:.1} | {tissue} | {held} | {invalid} |\n",
            simulated / 60.0,
            wall / 60.0
        )
    }
}

fn page(training: &Training, seed: u64) -> String {
    let (mut all, mut modules) = (Sums::default(), BTreeMap::<&str, Sums>::new());
    for played in &training.played {
        all.add(played);
        let module = modules.entry(&played.exercise.module).or_default();
        module.add(played);
    }
    let mut text = format!(
        "# An hour of scripted training\n\n`cargo xtask soak training`: scripts of all modules in one process, in each round every module once, in random order, with a random script of a random level (seed {seed}). Each run is recorded, and must be what the \
         name of its script says: passed, or failed for that reason. Each script that was played before must have the same physics digest as then, and every tenth run is replayed in the same process, to the bit. Times are in minutes; those of computation include replays, beside other work. \
         A tick is *held* where nothing else contained a divergence, and *without meaning* where no metric takes its forces.\n\n\
         | module | runs | replayed | simulated | computed in | ticks with tissue | held | without meaning |\n|---|---|---|---|---|---|---|---|\n"
    );
    for (module, sums) in &modules {
        text.push_str(&sums.row(module));
    }
    text.push_str(&all.row("all"));
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
    let _ = writeln!(
        text,
        "\nResident memory: {start:.1} MB at the start, {quarter:.1} after a quarter of the time, {half:.1} after half of it, {end:.1} at the end; a run takes {largest_run:.1} at most. {}",
        match memory.is_flat() {
            true =>
                "It is flat: from the time when all modules had been played and a quarter was over, no more was added than a run takes at most.",
            false => "**It grows.**",
        }
    );
    text.push_str("\nFaults:");
    match training.faults().as_slice() {
        [] => text.push_str(" none.\n"),
        faults => {
            text.push('\n');
            faults
                .iter()
                .for_each(|fault| text.push_str(&format!("\n- {fault}")));
            text.push('\n');
        }
    }
    text
}
