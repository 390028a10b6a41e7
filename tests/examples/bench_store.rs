//! `cargo xtask bench store`: a store of 50,000 results of 500 trainees, 12 metrics each; how long the built program takes to find those of a trainee, to
//! export all, to export and import the whole store. Writes `tests/results/bench_store.md`.
//!
//! Wall-clock time of the whole process, from start to exit. The results are made up: random numbers in the form of real ones.

use microsim_random::SplitMix64;
use microsim_store::{Id, Measured, Metric, Role, Session, Store, Trainee, Verdict};
use microsim_tests::repository;
use microsim_tests::stations::Station;
use microsim_tests::statistics::percentile;
use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Instant;

const SESSIONS: u64 = 50_000;
const TRAINEES: u64 = 500;
const METRICS: usize = 12;

fn id(random: &mut SplitMix64) -> Id {
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&random.bits().to_le_bytes());
    bytes[8..].copy_from_slice(&random.bits().to_le_bytes());
    Id::from_random(bytes)
}

/// A number from 0 to 1.
fn fraction(random: &mut SplitMix64) -> f64 {
    1e-6 * random.below(1_000_000) as f64
}

fn session(n: u64, trainee: Id, random: &mut SplitMix64) -> Session {
    let metrics: Vec<Measured> = (0..METRICS)
        .map(|k| {
            let value = fraction(random);
            Measured {
                metric: Metric {
                    id: format!("metric-{k}"),
                    title: format!("Metric number {k}"),
                    unit: "m".into(),
                    display_unit: "mm".into(),
                    display_factor: 1e3,
                    direction: "lower-is-better".into(),
                    category: "efficiency".into(),
                    formula: format!("metric-{k}/1"),
                }
                .into(),
                value: Some(value),
                min: None,
                max: Some(0.8),
                decides: Some(true),
                within: Some(value <= 0.8),
                score: Some(100.0 * value),
            }
        })
        .collect();
    let passed = fraction(random) < 0.7;
    Session {
        id: id(random),
        path: format!("/home/user/.local/share/microsim/sessions/touch-spheres-level1-{n}.session"),
        trainee: Some(trainee),
        module: "touch-spheres".into(),
        level: 1 + (n % 5) as u32,
        started: 1_700_000_000 + 600 * n as i64,
        simulated: 60.0 * fraction(random),
        finished: true,
        seed: random.bits(),
        input: "openigtlink://127.0.0.1:18944".into(),
        version: "0.3.0".into(),
        realtime: true,
        synthetic: None,
        state_hash: Some(format!("{:064x}", random.bits())),
        verdict: if passed {
            Verdict::Passed
        } else {
            Verdict::Failed
        },
        counts: true,
        failed: if passed {
            Vec::new()
        } else {
            vec!["too-slow".into()]
        },
        duration: 60.0 * fraction(random),
        targets_done: 6,
        targets: 6,
        score: Some(100.0 * fraction(random)),
        categories: ["efficiency", "handling", "target"]
            .map(|c| (c.to_owned(), 80.0))
            .to_vec(),
        metrics,
    }
}

/// Fills the store; how long that took \[s\].
fn fill(station: &Station) -> f64 {
    let mut random = SplitMix64(1);
    let mut store = Store::open(&station.store()).expect("a store");
    let trainees: Vec<Id> = (0..TRAINEES).map(|_| id(&mut random)).collect();
    for (n, id) in trainees.iter().enumerate() {
        let trainee = Trainee {
            id: *id,
            name: Some(format!("Trainee {n}")),
            role: Role::Trainee,
            created: 1_700_000_000,
        };
        store.add_trainee(&trainee).expect("added");
    }
    let sessions: Vec<Session> = (0..SESSIONS)
        .map(|n| session(n, trainees[random.below(TRAINEES) as usize], &mut random))
        .collect();
    let start = Instant::now();
    for part in sessions.chunks(1000) {
        store.enter(part).expect("entered");
    }
    start.elapsed().as_secs_f64()
}

/// Seconds that a command takes, `times` times; its last output.
fn measure(station: &Station, args: &[&str], times: usize) -> (Vec<f64>, String) {
    let mut seconds = Vec::new();
    let mut out = String::new();
    for _ in 0..times {
        let start = Instant::now();
        let finished = station.microsim(args).expect(0);
        seconds.push(start.elapsed().as_secs_f64());
        out = finished.out;
    }
    (seconds, out)
}

fn main() -> ExitCode {
    let station = Station::new();
    let filled = fill(&station);
    let file = |name: &str| {
        station
            .folder()
            .join(name)
            .to_str()
            .expect("text")
            .to_owned()
    };
    let (csv, parquet, json) = (file("all.csv"), file("all.parquet"), file("all.json"));
    let mut rows = String::new();
    let mut ok = true;
    for (what, args, times, limit) in [
        (
            "`results --trainee NAME`",
            vec!["results", "--trainee", "Trainee 77"],
            20,
            Some(0.1),
        ),
        (
            "`results --trainee NAME --json`, with all metrics",
            vec!["results", "--trainee", "Trainee 77", "--json"],
            20,
            Some(0.1),
        ),
        (
            "`results --export all.csv`",
            vec!["results", "--export", &csv],
            3,
            Some(5.0),
        ),
        (
            "`results --export all.parquet`",
            vec!["results", "--export", &parquet],
            3,
            Some(5.0),
        ),
        ("`results`, all on one line each", vec!["results"], 3, None),
        (
            "`store export all.json`",
            vec!["store", "export", &json],
            3,
            None,
        ),
        ("`store check`", vec!["store", "check"], 3, None),
        ("`trainees list`", vec!["trainees", "list"], 3, None),
    ] {
        let (seconds, out) = measure(&station, &args, times);
        let (median, most) = (percentile(&seconds, 0.5), percentile(&seconds, 1.0));
        let met = limit.map(|limit| median < limit);
        ok &= met != Some(false);
        let limit = match (limit, met) {
            (Some(limit), Some(true)) => format!("{limit} s: met"),
            (Some(limit), _) => format!("{limit} s: **not met**"),
            (None, _) => "–".into(),
        };
        eprintln!("{what}: {median:.3} s ({} bytes printed)", out.len());
        let _ = writeln!(
            rows,
            "| {what} | {median:.3} s | {most:.3} s | {times} | {limit} |"
        );
    }
    let size = |path: &str| std::fs::metadata(path).map_or(0, |f| f.len()) as f64 / 1e6;
    let store = size(station.store().to_str().expect("text"));
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let text = format!(
        "# The store with 50,000 results

Command: `cargo xtask bench store`, on a Linux machine with {cores} processor cores. {SESSIONS} sessions of {TRAINEES} trainees with {METRICS} metrics each,
made up with the numbers and texts of real ones in length; wall-clock time of the built program from start to exit.

| | median | largest | times | limit |
|---|---|---|---|---|
{rows}
Entering them through the library, 1,000 in a transaction: {:.0} µs each. Sizes: store {store:.0} MB, CSV {:.0} MB, Parquet {:.0} MB, JSON {:.0} MB.
",
        1e6 * filled / SESSIONS as f64,
        size(&csv),
        size(&parquet),
        size(&json)
    );
    println!("{text}");
    let path = repository().join("tests/results/bench_store.md");
    if let Err(error) = std::fs::write(&path, text) {
        eprintln!("{}: {error}", path.display());
        return ExitCode::from(2);
    }
    match ok {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}
