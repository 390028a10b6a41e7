//! `cargo xtask bench coordination`: CPU time from the input to the snapshots of the bodies, per picture of 16 ms, of the script that passes each level,
//! with the shares of the stages. `-- MODULE [LEVEL...]` measures another module, or single levels. Prints a table; all levels of
//! `coordination` are also written to `tests/results/bench_coordination.md`.
//!
//! Measured in this process with the host's own engine and the built plugins. The times are CPU times of the one thread that
//! computes (`CLOCK_THREAD_CPUTIME_ID`), and wall-clock times beside them. Nothing is asserted about time.

use abi_stable::sabi_trait::TD_Opaque;
use abi_stable::std_types::{ROption, RResult, RSlice, RStr, RVec};
use microsim_abi::{Call, Fault, Output, ParallelFor, PluginBox, PluginObject, PluginObject_TO};
use microsim_bus::{Frames, Limits, kind_id};
use microsim_host::Engine;
use microsim_host::assemble::Input;
use microsim_host::loader::load;
use microsim_host::parallel::Parallel;
use microsim_host::run::RunError;
use microsim_message::{Message, TrainingResult};
use microsim_tests::in_process::{plan, tick};
use microsim_tests::measured::thread_time;
use microsim_tests::statistics::percentile;
use microsim_tests::{command, repository, scratch, tree};
use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;

/// The time of a picture \[ns\].
const PICTURE: u64 = 16_000_000;

/// CPU time of this thread \[ms\].
fn now() -> f64 {
    1e3 * thread_time()
}

thread_local! {
    /// CPU time of each plugin in this picture \[ms\], in the order of the plan.
    static STAGES: Rc<RefCell<Vec<f64>>> = Rc::default();
}

/// A plugin whose ticks are timed.
struct Timed {
    plugin: PluginBox,
    stage: usize,
}

impl PluginObject for Timed {
    fn initialise(
        &mut self,
        setup: RSlice<'_, u8>,
        parallel: ROption<ParallelFor>,
    ) -> RResult<(), Fault> {
        self.plugin.initialise(setup, parallel)
    }

    fn reset(&mut self) -> RResult<(), Fault> {
        self.plugin.reset()
    }

    fn process(&mut self, call: Call<'_>) -> RResult<Output, Fault> {
        let begin = now();
        let output = self.plugin.process(call);
        STAGES.with(|stages| stages.borrow_mut()[self.stage] += now() - begin);
        output
    }

    fn save(&mut self) -> RResult<RVec<u8>, Fault> {
        self.plugin.save()
    }

    fn restore(&mut self, state: RSlice<'_, u8>) -> RResult<(), Fault> {
        self.plugin.restore(state)
    }

    fn extension(
        &mut self,
        name: RStr<'_>,
        request: RSlice<'_, u8>,
    ) -> RResult<ROption<RVec<u8>>, Fault> {
        self.plugin.extension(name, request)
    }

    fn stop(&mut self) -> RResult<(), Fault> {
        self.plugin.stop()
    }
}

/// A picture: CPU and wall-clock time, CPU time of each plugin \[ms\].
struct Picture {
    cpu: f64,
    wall: f64,
    stages: Vec<f64>,
}

/// Whether the level has ended.
fn has_result(log: &[u8]) -> bool {
    let frames = Frames::new(log).filter_map(Result::ok);
    frames
        .into_iter()
        .any(|frame| frame.header.kind == kind_id(TrainingResult::KIND))
}

/// The script that passes a level.
fn script(module: &str, level: u32) -> PathBuf {
    tree().join(format!("modules/{module}/scripts/level{level}-pass.toml"))
}

/// Runs the script that passes a level, on so many threads; the names of the plugins and all pictures.
fn measure(module: &str, level: u32, threads: usize) -> (Vec<String>, Vec<Picture>) {
    let script = script(module, level);
    let folder = scratch();
    let session = folder.path().join("unused.session");
    let plan = plan(module, level, Input::Script(script), session);
    let names: Vec<String> = plan.plugins.iter().map(|p| p.name.clone()).collect();
    let parallel = (threads > 1).then(|| Parallel::new(threads).expect("threads"));
    let engine = Engine::new(&plan, Limits::default(), parallel, |planned| {
        let stage = names.iter().position(|name| *name == planned.name);
        let plugin = load(planned).map_err(RunError::from)?.into_plugin();
        let timed = Timed {
            plugin,
            stage: stage.unwrap_or_default(),
        };
        Ok::<_, RunError>(Some(PluginObject_TO::from_value(timed, TD_Opaque)))
    });
    let mut engine = engine.expect("the plugins start");
    let ticks = (PICTURE / plan.tick_ns).max(1);
    let mut pictures = Vec::new();
    let mut ended = false;
    while !ended {
        STAGES.with(|stages| *stages.borrow_mut() = vec![0.0; names.len()]);
        let (begin, start) = (now(), Instant::now());
        for _ in 0..ticks {
            ended |= has_result(&tick(&mut engine).log);
        }
        pictures.push(Picture {
            cpu: now() - begin,
            wall: 1e3 * start.elapsed().as_secs_f64(),
            stages: STAGES.with(|stages| stages.borrow().clone()),
        });
    }
    (names, pictures)
}

/// Wall-clock time of drawing a picture \[ms\]: what a run of the program takes longer that draws every picture of 16 ms into a file.
fn drawing(module: &str, level: u32) -> f64 {
    let folder = scratch();
    let [plain, mut drawn] = ["plain", "drawn"].map(|name| {
        let mut run = command(["run", module, "--headless", "--no-pictures", "--level"]);
        let source = format!("script:{}", script(module, level).display());
        run.args([&level.to_string(), "--input", &source, "--session"]);
        run.arg(folder.path().join(name).with_extension("session"));
        run
    });
    let pictures = folder.path().join("pictures");
    drawn
        .arg("--frames")
        .arg(&pictures)
        .args(["--frame-rate", "62.5"]);
    let seconds = [plain, drawn].map(|mut run| {
        let start = Instant::now();
        let output = run.output().expect("the program runs");
        assert!(output.status.success(), "{output:?}");
        start.elapsed().as_secs_f64()
    });
    let count = std::fs::read_dir(pictures).expect("pictures").count();
    1e3 * (seconds[1] - seconds[0]) / count as f64
}

/// The table of a module's levels.
fn table(module: &str, levels: &[u32]) -> String {
    let mut text = String::new();
    for level in levels {
        let (names, pictures) = measure(module, *level, 1);
        let (_, beside) = measure(module, *level, 2);
        let beside: Vec<_> = beside.iter().map(|picture| picture.wall).collect();
        let p = |of: &dyn Fn(&Picture) -> f64, share| {
            percentile(&pictures.iter().map(of).collect::<Vec<_>>(), share)
        };
        if text.is_empty() {
            let stages: Vec<_> = names.iter().map(|name| format!(" {name} |")).collect();
            let _ = writeln!(
                text,
                "| level | pictures | CPU p50 [ms] | CPU p99 [ms] | CPU most [ms] | wall p99 [ms] | wall p99, 2 threads [ms] | drawing [ms] | real-time factor |{} host |\n|{}",
                stages.concat(),
                "---|".repeat(10 + names.len())
            );
        }
        let cpu: f64 = pictures.iter().map(|picture| picture.cpu).sum();
        let mut shares: Vec<f64> = (0..names.len())
            .map(|stage| {
                pictures
                    .iter()
                    .map(|picture| picture.stages[stage])
                    .sum::<f64>()
                    / cpu
            })
            .collect();
        shares.push(1.0 - shares.iter().sum::<f64>());
        let shares: Vec<_> = shares
            .iter()
            .map(|share| format!(" {:.1} % |", 100.0 * share))
            .collect();
        let simulated = 1e-6 * (PICTURE * pictures.len() as u64) as f64;
        let _ = writeln!(
            text,
            "| {level} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} | {:.1} |{}",
            pictures.len(),
            p(&|picture| picture.cpu, 0.5),
            p(&|picture| picture.cpu, 0.99),
            p(&|picture| picture.cpu, 1.0),
            p(&|picture| picture.wall, 0.99),
            percentile(&beside, 0.99),
            drawing(module, *level),
            simulated / pictures.iter().map(|picture| picture.wall).sum::<f64>(),
            shares.concat(),
        );
    }
    text
}

/// Levels of a module with a script that passes.
fn levels(module: &str) -> Vec<u32> {
    (1..)
        .take_while(|level| script(module, *level).is_file())
        .collect()
}

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1);
    let named = words.next();
    let module = named.clone().unwrap_or_else(|| "coordination".into());
    let some: Vec<u32> = words.filter_map(|word| word.parse().ok()).collect();
    let measured = if some.is_empty() {
        levels(&module)
    } else {
        some
    };
    let table = table(&module, &measured);
    print!("{table}");
    if named.is_some() {
        return ExitCode::SUCCESS;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let text = format!(
        "# Cost of the levels of coordination\n\nCommand: `cargo xtask bench coordination`, on a machine with {cores} processor cores; one thread but where it says two. The script that passes each\n\
         level, from the input to the snapshots of the bodies, per picture of 16 ms. Shares are of all CPU time of the run, by plugin; the host is what is left:\n\
         bus, running hash. Drawing is what a run takes longer per picture that draws each of them into a file with the graphics driver that was found; it is not in the\n\
         other columns. The times are this machine's.\n\n{table}"
    );
    match std::fs::write(
        repository().join("tests/results/bench_coordination.md"),
        text,
    ) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("the result cannot be written: {error}");
            ExitCode::FAILURE
        }
    }
}
