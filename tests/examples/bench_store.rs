//! `cargo xtask bench store`: a store of 50,000 results of 500 trainees, 12 metrics each; how long the built program takes to find those of a trainee, to
//! export all, to export and import the whole store. Writes `tests/results/bench_store.md`.
//!
//! Wall-clock and CPU time of the whole process, from start to exit. The results are made up: random numbers in the form of real ones.

use microsim_random::SplitMix64;
use microsim_store::{Id, Measured, Metric, Role, Session, Store, Trainee, Verdict};
use microsim_tests::measured::cpu_time;
use microsim_tests::repository;
use microsim_tests::stations::Station;
use microsim_tests::statistics::percentile;
use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
use std::fs::File;
use std::process::{ExitCode, Stdio};
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
        started_subsec_ns: 0,
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

/// A command that is measured.
struct Command {
    /// On the page.
    what: &'static str,
    arguments: Vec<String>,
    /// How often in a round.
    times: usize,
    /// Median that is aimed at, wall clock \[s\].
    limit: Option<f64>,
    /// Of all runs: from start to end \[s\].
    wall: Vec<f64>,
    /// Of all runs: CPU time of the process \[s\].
    cpu: Vec<f64>,
}

impl Command {
    /// Runs it once, its output written to a file.
    fn run(&mut self, station: &Station) {
        let out = File::create(station.folder().join("printed")).expect("a file");
        let arguments: Vec<&str> = self.arguments.iter().map(String::as_str).collect();
        let mut command = station.command(&arguments);
        command.stdin(Stdio::null()).stdout(out);
        let start = Instant::now();
        let mut child = command.spawn().expect("the program starts");
        let process = Pid::from_child(&child);
        let ended = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT;
        waitid(WaitId::Pid(process), ended).expect("it ends");
        self.wall.push(start.elapsed().as_secs_f64());
        let (cpu, _) = cpu_time(child.id()).expect("a Linux");
        self.cpu.push(cpu);
        let status = child.wait().expect("it has ended");
        assert!(status.success(), "{}: {status}", self.what);
    }

    fn is_met(&self) -> Option<bool> {
        Some(percentile(&self.wall, 0.5) < self.limit?)
    }

    /// Its row of the table.
    fn row(&self) -> String {
        let wall = [0.5, 0.99].map(|part| percentile(&self.wall, part));
        let cpu = percentile(&self.cpu, 0.5);
        let limit = match (self.limit, self.is_met()) {
            (Some(limit), Some(true)) => format!("{limit} s: met"),
            (Some(limit), _) => format!("{limit} s: **not met**"),
            (None, _) => "–".into(),
        };
        let (what, times) = (self.what, self.wall.len());
        format!(
            "| {what} | {:.3} s | {:.3} s | {cpu:.2} s | {times} | {limit} |\n",
            wall[0], wall[1]
        )
    }
}

/// Rounds over all commands, so that other work on the machine meets all of them alike.
const ROUNDS: usize = 10;

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
    let command = |what, arguments: &[&str], times, limit| Command {
        what,
        arguments: arguments.iter().map(ToString::to_string).collect(),
        times,
        limit,
        wall: Vec::new(),
        cpu: Vec::new(),
    };
    let of_one = ["results", "--trainee", "Trainee 77", "--json"];
    let mut commands = [
        command("`results --trainee NAME`", &of_one[..3], 10, Some(0.1)),
        command(
            "`results --trainee NAME --json`, with all metrics",
            &of_one,
            10,
            Some(0.1),
        ),
        command(
            "`results --export all.csv`",
            &["results", "--export", &csv],
            1,
            Some(5.0),
        ),
        command(
            "`results --export all.parquet`",
            &["results", "--export", &parquet],
            1,
            Some(5.0),
        ),
        command("`results`, all on one line each", &["results"], 1, None),
        command(
            "`store export all.json`",
            &["store", "export", &json],
            1,
            None,
        ),
        command("`store check`", &["store", "check"], 1, None),
        command("`trainees list`", &["trainees", "list"], 1, None),
    ];
    for round in 0..ROUNDS {
        for command in &mut commands {
            (0..command.times).for_each(|_| command.run(&station));
        }
        eprintln!("round {} of {ROUNDS}", round + 1);
    }
    let rows: String = commands.iter().map(Command::row).collect();
    let ok = commands
        .iter()
        .all(|command| command.is_met() != Some(false));
    let size = |path: &str| std::fs::metadata(path).map_or(0, |f| f.len()) as f64 / 1e6;
    let store = size(station.store().to_str().expect("text"));
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let text = format!(
        "# The store with 50,000 results

Command: `cargo xtask bench store`, on a Linux machine with {cores} processor cores. {SESSIONS} sessions of {TRAINEES} trainees with {METRICS} metrics each,
made up with the numbers and texts of real ones in length. Times are of single runs of the built program, from start to exit: wall clock, p50 and p99, and the
p50 of its CPU time, which the kernel counts to 10 ms. All commands in turn, {ROUNDS} rounds. Exports end when they are on the disk.

| | p50 | p99 | CPU | runs | limit for p50 |
|---|---|---|---|---|---|
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
