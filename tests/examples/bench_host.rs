//! `cargo xtask bench host`: what a step costs besides physics: host, bus and recording. Prints a table and writes
//! `tests/results/bench_host.md` and `bench_host.csv`.
//!
//! Measured in this process with the host's own engine and the built plugins, on touch-spheres with the recorded hand;
//! one wall-clock interval per row and tick, percentiles over all of them. Nothing is asserted about time.

use abi_stable::std_types::{ROption, RSlice};
use microsim_abi::{Call, PluginBox};
use microsim_bus::{Frames, Limits, Router, frame::push_frame, kind_id};
use microsim_host::Engine;
use microsim_host::assemble::Input;
use microsim_host::loader::load;
use microsim_host::plan::{PluginKind, RunPlan};
use microsim_host::record::{Header, TickRecord, kind, record};
use microsim_host::run::RunError;
use microsim_message::{
    InputEnd, Message, SessionRecord, ToolStates, core_kinds, decode, encode, push,
};
use microsim_sdk::{Fault, Plugin, Services, Setup, Tick};
use microsim_tests::in_process::{engine, plan, tick};
use microsim_tests::statistics::percentile;
use microsim_tests::{repository, scratch, tree};
use std::fmt::Write as _;
use std::fs;
use std::process::ExitCode;
use std::time::Instant;

/// Times that the recording is played, each with a session of its own.
const ROUNDS: usize = 3;
/// Batches of the parts that are too short for one reading of the clock, and what one batch holds.
const BATCHES: usize = 2000;
const BATCH: usize = 100;

/// Intervals of one row \[µs\].
struct Row {
    name: &'static str,
    what: &'static str,
    times: Vec<f64>,
}

impl Row {
    fn new(name: &'static str, what: &'static str) -> Self {
        Self {
            name,
            what,
            times: Vec::new(),
        }
    }

    fn measure<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let value = work();
        self.times.push(1e6 * start.elapsed().as_secs_f64());
        value
    }

    /// A batch of short pieces of work: the mean of each batch is one value.
    fn measure_batch(&mut self, mut work: impl FnMut()) {
        let start = Instant::now();
        for _ in 0..BATCH {
            work();
        }
        self.times
            .push(1e6 * start.elapsed().as_secs_f64() / BATCH as f64);
    }

    fn p(&self, share: f64) -> f64 {
        percentile(&self.times, share)
    }
}

/// A plugin that subscribes to nothing and publishes nothing.
struct Silent;

impl Plugin for Silent {
    fn new() -> Self {
        Self
    }

    fn initialise(&mut self, _: &Setup, _: Services) -> Result<(), Fault> {
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    fn process(&mut self, _: &mut Tick<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    fn restore(&mut self, _: &[u8]) -> Result<(), Fault> {
        Ok(())
    }
}

fn silent() -> PluginBox {
    let created = microsim_sdk::export::create::<Silent>().into_result();
    created.expect("nothing can fail")
}

/// The recorder of a plan, as the host drives it.
fn recorder(plan: &RunPlan) -> PluginBox {
    let planned = plan.plugins.iter().find(|p| p.kind == PluginKind::Recorder);
    let planned = planned.expect("every plan has a recorder");
    let mut recorder = load(planned).expect("the recorder loads").into_plugin();
    let setup = encode(&planned.setup);
    let started = recorder
        .initialise(RSlice::from_slice(&setup), ROption::RNone)
        .into_result();
    started.expect("the recorder starts");
    recorder
}

fn call<'a>(plan: &RunPlan, index: u64, messages: &'a [u8]) -> Call<'a> {
    Call {
        tick: index,
        time_ns: (index + 1) * plan.tick_ns,
        tick_ns: plan.tick_ns,
        steps: plan.steps,
        messages: RSlice::from_slice(messages),
        blocks: RSlice::from_slice(&[]),
    }
}

fn write(plan: &RunPlan, recorder: &mut PluginBox, record: &SessionRecord) {
    let mut messages = Vec::with_capacity(record.bytes.len() + 64);
    push(&mut messages, record);
    let written = recorder
        .process(call(plan, record.tick, &messages))
        .into_result();
    written.expect("the session is written");
}

/// Whole runs: one row each for the tick of the engine, the state hash and the recording, and their sum.
fn whole_runs() -> Vec<Row> {
    let mut engine_row = Row::new(
        "engine",
        "one tick: source, translator, module, objects, bus and running hash",
    );
    let mut hash_row = Row::new(
        "state hash",
        "saving and hashing every plugin's state, every 31st tick (250 ms)",
    );
    let mut record_row = Row::new(
        "recording",
        "one tick into the session: encoding, crossing, checksum, write to the file",
    );
    let mut sum_row = Row::new("whole tick", "engine, recording and, where due, state hash");
    let recording = tree().join("assets/recordings/cataract-stylus/stylus.csv");
    for round in 0..ROUNDS {
        let folder = scratch();
        let session = folder.path().join(format!("{round}.session"));
        let plan = plan(
            "touch-spheres",
            1,
            Input::Recording(recording.clone()),
            session,
        );
        let mut engine = engine(&plan);
        let mut recorder = recorder(&plan);
        write(
            &plan,
            &mut recorder,
            &record(
                kind::HEADER,
                0,
                &Header {
                    format: 1,
                    version: String::new(),
                    started: 0,
                    started_subsec_ns: 0,
                    trainee: None,
                    id: None,
                    unlisted: true,
                    realtime: false,
                    plan: plan.clone(),
                },
            ),
        );
        loop {
            let start = Instant::now();
            let index = engine.tick_index();
            let output = engine_row.measure(|| tick(&mut engine));
            let states = (index + 1)
                .is_multiple_of(plan.hash_every)
                .then(|| hash_row.measure(|| engine.state_digests(&[]).expect("plugins save")));
            record_row.measure(|| {
                write(
                    &plan,
                    &mut recorder,
                    &record(
                        kind::TICK,
                        index,
                        &TickRecord {
                            arrival_ns: 0,
                            log: output.log.clone(),
                            chain: output.chain.to_vec(),
                            states,
                            failed: false,
                        },
                    ),
                );
            });
            sum_row.times.push(1e6 * start.elapsed().as_secs_f64());
            let ended = |f: microsim_bus::Frame<'_>| decode::<InputEnd>(&f).is_some();
            if Frames::new(&output.log).filter_map(Result::ok).any(ended) {
                break;
            }
        }
        engine.stop();
    }
    vec![sum_row, engine_row, record_row, hash_row]
}

/// The host alone: the same plan, its plugins replaced by silent ones.
fn empty_ticks() -> Row {
    let mut row = Row::new(
        "host alone",
        "one tick of the same run with plugins that hear and say nothing",
    );
    let recording = tree().join("assets/recordings/cataract-stylus/stylus.csv");
    let plan = plan(
        "touch-spheres",
        1,
        Input::Recording(recording),
        "unused".into(),
    );
    let started = Engine::new(&plan, Limits::default(), None, |_| {
        Ok::<_, RunError>(Some(silent()))
    });
    let mut engine = started.expect("silent plugins start");
    for _ in 0..BATCHES {
        row.measure_batch(|| {
            tick(&mut engine);
        });
    }
    row
}

/// The bus alone: one message from one endpoint to another.
fn bus() -> Row {
    let mut row = Row::new(
        "bus",
        "one message of tool states: published, checked, logged, queued and taken",
    );
    let mut router = Router::new(Limits::default(), core_kinds()).expect("kinds");
    let kinds = [ToolStates::KIND.to_owned()];
    let sender = router.register("sender", &kinds, &[]).expect("an endpoint");
    let receiver = router
        .register("receiver", &[], &kinds)
        .expect("an endpoint");
    let mut message = Vec::new();
    // As long as that of one tool.
    push_frame(
        &mut message,
        kind_id(ToolStates::KIND),
        ToolStates::VERSION,
        &[0; 150],
    );
    for _ in 0..BATCHES {
        row.measure_batch(|| {
            router.publish(sender, 0, &message).expect("a good message");
            assert_eq!(router.take_messages(receiver).len(), message.len());
        });
        router.take_log();
    }
    row
}

/// One call over the boundary into a loaded library, and back.
fn crossing() -> Row {
    let mut row = Row::new(
        "crossing",
        "one `process` call into a library without messages, guarded against panics",
    );
    let folder = scratch();
    let recording = tree().join("assets/recordings/cataract-stylus/stylus.csv");
    let session = folder.path().join("crossing.session");
    let plan = plan("touch-spheres", 1, Input::Recording(recording), session);
    let mut recorder = recorder(&plan);
    for _ in 0..BATCHES {
        row.measure_batch(|| {
            let answered = recorder.process(call(&plan, 0, &[])).into_result();
            answered.expect("the recorder answers");
        });
    }
    row
}

fn table(rows: &[Row]) -> String {
    let whole = rows[0].p(0.5);
    let mut text = String::from(
        "| what | p50 [µs] | p99 [µs] | share of a whole tick (p50) | values |\n|---|---|---|---|---|\n",
    );
    for row in rows {
        let _ = writeln!(
            text,
            "| **{}**: {} | {:.3} | {:.3} | {:.3} | {} |",
            row.name,
            row.what,
            row.p(0.5),
            row.p(0.99),
            row.p(0.5) / whole,
            row.times.len()
        );
    }
    text
}

fn main() -> ExitCode {
    let mut rows = whole_runs();
    rows.extend([empty_ticks(), bus(), crossing()]);
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let table = table(&rows);
    let text = format!(
        "# Cost per step of host, bus and recording, without physics

Command: `cargo xtask bench host`, on a Linux machine with {cores} processor cores; wall-clock time, one thread.

Touch-spheres, level 1, the recorded hand of 98 s played {ROUNDS} times; a tick is 8 ms (8000 µs) of simulated time. Rows
that are shorter than a reading of the clock are means over batches of {BATCH}. The times are this machine's; what carries
over are the ratios, all of one run.

{table}
A whole tick at p99 is {:.2} % of the 8 ms that a paced run has for it; it is one with a state hash, whose cost grows with
the motion that the module has kept for its metrics. Recording costs {:.2} times what the engine does,
the host with silent plugins {:.2} times.
",
        100.0 * rows[0].p(0.99) / 8000.0,
        rows[2].p(0.5) / rows[1].p(0.5),
        rows[4].p(0.5) / rows[1].p(0.5)
    );
    println!("{text}");
    let mut csv = String::from("row,p50_us,p99_us,values\n");
    for row in &rows {
        let _ = writeln!(
            csv,
            "{},{:.4},{:.4},{}",
            row.name,
            row.p(0.5),
            row.p(0.99),
            row.times.len()
        );
    }
    let folder = repository().join("tests").join("results");
    let written = fs::create_dir_all(&folder)
        .and_then(|()| fs::write(folder.join("bench_host.md"), text))
        .and_then(|()| fs::write(folder.join("bench_host.csv"), csv));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", folder.display());
            ExitCode::from(2)
        }
    }
}
