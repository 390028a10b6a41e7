//! `cargo xtask soak guests`: a training module in a process of its own that ends it, in the middle of a live run, 20 times for each cause;
//! and what such processes cost per tick. Writes `tests/results/isolation.md` and `isolation.csv`.
//!
//! `-- --runs N` for another number of runs.

use microsim_bus::Frames;
use microsim_host::assemble::{Input, Isolate};
use microsim_message::{InputEnd, decode};
use microsim_tests::in_process::{engine, plan_hosted, tick};
use microsim_tests::live::LiveTree;
use microsim_tests::statistics::percentile;
use microsim_tests::{fixture_library, repository, scratch, tree};
use serde_json::json;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant, SystemTime};

const PACKAGE: &str = "microsim-fixture-awkward";
/// Tick in which the module ends its process.
const TICK: u64 = 20;
/// The sentence about a guest that is killed, in part.
const SILENT: &str = "no answer within 800 ms";
/// What ends a process, and what the sentence about it may have in it.
const ENDS: [(&str, &str, &[&str]); 5] = [
    ("segfault", "segmentation fault", &["SIGSEGV"]),
    ("abort", "`abort()`", &["SIGABRT"]),
    ("exit", "`exit(0)`", &["exit status 0"]),
    ("loop", "endless loop", &[SILENT]),
    // A busy machine gives it memory so slowly that the deadline comes first.
    (
        "allocate",
        "takes 10 GB",
        &["memory limit of 512 MiB", SILENT],
    ),
];
/// Longest time until the operator can read it.
const TOLD: Duration = Duration::from_secs(1);
/// Time for which the source of a run gives samples \[s\]: more than twice that of the ticks before the end.
const LENGTH: f64 = 0.4;
/// Times that the recorded hand is played on each side, in turns.
const ROUNDS: usize = 3;

const MANIFEST: &str = r#"name = "awkward"
kind = "module"
version = "0.1.0"
abi = 2
licence = "MIT OR Apache-2.0"
library = "microsim_fixture_awkward"
publishes = ["training.result"]
subscribes = ["level.control"]
plugins = ["translator", "objects"]

[title]
de = "Quer"
en = "Awkward"

[summary]
de = "Geht schief."
en = "Goes wrong."
"#;

const LEVEL: &str = r#"[title]
de = "Nichts"
en = "Nothing"

[summary]
de = "Nichts zu tun."
en = "Nothing to do."

[clock]
tick = "8 ms"

[view]
field = "25 mm"

[[tool]]
name = "right"
model = "forceps"
"#;

/// An installation with a live source, and a module in a folder outside of it.
struct Stage {
    tree: LiveTree,
    module: tempfile::TempDir,
    witness: PathBuf,
}

/// What came of a run.
struct Run {
    status: Option<i32>,
    /// What it printed to standard error.
    text: String,
    /// From the beginning of the last tick to the sentence that names the module.
    told: Option<Duration>,
}

impl Stage {
    fn new() -> std::io::Result<Self> {
        let mut behaviour = json!({ "duration": LENGTH, "delay": 8 });
        let tree = LiveTree::new(&behaviour);
        let witness = tree.root().join("witness");
        behaviour["witness"] = json!(witness);
        tree.behave(&behaviour);
        let module = scratch();
        let at = |name: &str| module.path().join(name);
        fs::create_dir(at("levels"))?;
        fs::write(at("module.toml"), MANIFEST)?;
        fs::write(at("levels/level1.toml"), LEVEL)?;
        let library = fixture_library(PACKAGE);
        let name = library.file_name().unwrap_or_default();
        fs::copy(&library, module.path().join(name))?;
        Ok(Self {
            tree,
            module,
            witness,
        })
    }

    /// A command for this module, with its misbehaviour prescribed.
    fn told(&self, told: &str, command: &mut Command) {
        command
            .env("MICROSIM_AWKWARD", told)
            .env(
                "MICROSIM_AWKWARD_MANIFEST",
                self.module.path().join("module.toml"),
            )
            .arg("--modules")
            .arg(self.module.path())
            .stdout(Stdio::null());
    }

    /// A live run, paced by the wall clock.
    fn run(&self, told: &str, session: &Path) -> std::io::Result<Run> {
        let mut command = self
            .tree
            .run("awkward", session, &["--realtime", "--no-pictures"]);
        self.told(told, &mut command);
        let mut child = command.stderr(Stdio::piped()).spawn()?;
        let (mut text, mut named) = (String::new(), None);
        for line in child
            .stderr
            .take()
            .into_iter()
            .flat_map(|e| BufReader::new(e).lines())
        {
            let line = line?;
            if line.starts_with("microsim: plugin \"awkward\"") {
                named.get_or_insert_with(SystemTime::now);
            }
            text += &line;
            text.push('\n');
        }
        let status = child.wait()?.code();
        // The source, called first in every tick, has written then.
        let begun = fs::metadata(&self.witness)?.modified()?;
        let told = named.and_then(|named| named.duration_since(begun).ok());
        Ok(Run { status, text, told })
    }

    fn verifies(&self, session: &Path) -> std::io::Result<bool> {
        let mut command = microsim_tests::command(["replay", "--verify"]);
        command.arg(session).arg("--root").arg(self.tree.root());
        self.told("", &mut command);
        Ok(command.stderr(Stdio::null()).status()?.success())
    }
}

/// One end of a guest's process.
struct Ended {
    how: &'static str,
    number: usize,
    /// Plugin, tick and cause were printed, and the exit status is 2.
    named: bool,
    /// Until that was printed \[ms\].
    told: f64,
    verified: bool,
    next: bool,
}

impl Ended {
    fn is_good(&self) -> bool {
        self.named && self.verified && self.next && self.told < 1e3 * TOLD.as_secs_f64()
    }
}

fn ends(runs: usize) -> std::io::Result<Vec<Ended>> {
    let stage = Stage::new()?;
    let mut ended = Vec::new();
    for (how, what, said) in ENDS {
        for number in 0..runs {
            let session = stage.tree.root().join(format!("{how}-{number}.session"));
            let run = stage.run(&format!("{how} process {TICK}"), &session)?;
            let place = format!("plugin \"awkward\" ended in `process` at tick {TICK}");
            let named = run.status == Some(2) && run.text.contains(&place);
            let next = session.with_extension("next.session");
            let (next, verified) = (stage.run("", &next)?, stage.verifies(&session)?);
            let end = Ended {
                how,
                number,
                named: named && said.iter().any(|said| run.text.contains(said)),
                told: run.told.map_or(f64::INFINITY, |t| 1e3 * t.as_secs_f64()),
                verified,
                next: next.status == Some(0),
            };
            if !end.is_good() {
                eprintln!(
                    "{how} {number}: {:?}\n{}{}",
                    run.status, run.text, next.text
                );
            }
            ended.push(end);
        }
        eprintln!("{what}: {runs} runs");
    }
    Ok(ended)
}

/// Times of the ticks of touch-spheres with the recorded hand \[µs\]: all in this process; source, translator and module each in its own.
fn tick_times() -> [Vec<f64>; 2] {
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..ROUNDS {
        for (which, times) in [Isolate::None, Isolate::All].into_iter().zip(&mut times) {
            let recording = tree().join("assets/recordings/cataract-stylus/stylus.csv");
            let input = Input::Recording(recording);
            let plan = plan_hosted(which, "touch-spheres", 1, input, "unused".into());
            let mut engine = engine(&plan);
            loop {
                let begun = Instant::now();
                let output = tick(&mut engine);
                times.push(1e6 * begun.elapsed().as_secs_f64());
                let ended = |f: microsim_bus::Frame<'_>| decode::<InputEnd>(&f).is_some();
                if Frames::new(&output.log).filter_map(Result::ok).any(ended) {
                    break;
                }
            }
            engine.stop();
        }
    }
    times
}

fn table(ended: &[Ended], runs: usize) -> String {
    let mut rows = String::new();
    for (how, what, _) in ENDS {
        let of: Vec<&Ended> = ended.iter().filter(|e| e.how == how).collect();
        let count = |is: fn(&Ended) -> bool| of.iter().filter(|e| is(e)).count();
        let told: Vec<f64> = of.iter().map(|e| e.told).collect();
        let _ = writeln!(
            rows,
            "| {what} | {runs} | {} | {:.0} | {:.0} | {} | {} |",
            count(|e| e.named),
            percentile(&told, 0.5),
            percentile(&told, 1.0),
            count(|e| e.verified),
            count(|e| e.next),
        );
    }
    rows
}

fn costs(times: &[Vec<f64>; 2]) -> String {
    let mut rows = String::new();
    let mut row = |what: &str, value: &dyn Fn(f64) -> f64| {
        let [p50, p99] = [0.5, 0.99].map(value);
        let _ = writeln!(rows, "| {what} | {p50:.1} | {p99:.1} |");
    };
    let [inside, own] = times;
    row("all in the host's process", &|share| {
        percentile(inside, share)
    });
    row("source, translator and module each in its own", &|share| {
        percentile(own, share)
    });
    row("… more, per plugin", &|share| {
        (percentile(own, share) - percentile(inside, share)) / 3.0
    });
    rows
}

fn page(ended: &[Ended], runs: usize, times: &[Vec<f64>; 2]) -> String {
    format!(
        "# Plugins in a process of their own

Command: `cargo xtask soak guests`. One row per run: [`isolation.csv`](isolation.csv).

## How they end

A training module that the installation did not bring, in live runs: samples come from a thread of a source, paced by the wall clock (`--realtime`), and
in tick {TICK} the module ends its process, or keeps it for ever. Deadline and memory limit are those of `config/host.toml`.

| the module | runs | named, exit status 2 | told after \\[ms\\], median | **longest** | session verified | next level ran |
|---|---|---|---|---|---|---|
{}
Named: standard error has plugin, tick and how the process ended; of one that takes 10 GB, that it ran into its memory limit or, where the machine
gives it memory too slowly, that it gave no answer. Told after: from the beginning of that tick, which the source writes into a file,
to that sentence, which comes when the session is closed and the report written. Verified: `replay --verify` recomputes the session to the bit, with a
module that does not end. Asked for: all of them, and told within {:.0} s: {}.

## What they cost

One tick of the engine on touch-spheres with the recorded hand, wall-clock time over {ROUNDS} × {} ticks on each side, in turns \\[µs\\].

| | p50 | p99 |
|---|---|---|
{}",
        table(ended, runs),
        TOLD.as_secs_f64(),
        if ended.iter().all(Ended::is_good) { "kept in every run" } else { "**not kept**" },
        times[0].len() / ROUNDS,
        costs(times),
    )
}

fn csv(ended: &[Ended]) -> String {
    let mut out = String::from("end,run,named,told_after_ms,verified,next_level_ran\n");
    for e in ended {
        let Ended { how, number, .. } = e;
        let _ = writeln!(
            out,
            "{how},{number},{},{:.1},{},{}",
            e.named, e.told, e.verified, e.next
        );
    }
    out
}

fn measure(runs: usize) -> std::io::Result<bool> {
    let times = tick_times();
    let ended = ends(runs)?;
    let text = page(&ended, runs, &times);
    println!("{text}");
    let folder = repository().join("tests/results");
    fs::write(folder.join("isolation.md"), text)?;
    fs::write(folder.join("isolation.csv"), csv(&ended))?;
    Ok(ended.iter().all(Ended::is_good))
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let runs = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => Some(20),
        ["--runs", n] => n.parse().ok().filter(|n| *n > 0),
        _ => None,
    };
    let Some(runs) = runs else {
        eprintln!("usage: cargo xtask soak guests [-- --runs N]");
        return ExitCode::from(2);
    };
    match measure(runs) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
