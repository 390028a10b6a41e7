//! `cargo xtask bench levels [-- TRAINEES [MODULE...]]`: CPU time of a picture of 16 ms in every level with vessels, or in those of the named modules: over the script that passes
//! and over so many synthetic trainees, 10 if not given, the first half of them experts, with seeds from 1. Beside it what the solver did not come to the end with, and how many
//! trainees have no verdict. Written to `tests/results/levels.md`.
//!
//! Each run is a process of the shipped program without pictures, one after the other; the time is that of the thread that computes, from the trace. Nothing is
//! asserted about time.
//!
//! A processor that others use as well takes up to twice as long for the same instructions. So the factor of a fixed matrix is timed before and after every run, and a run
//! during which it was slow is made again, a limited number of times, after waiting for a fast one as long as there is patience. The one with the fastest factor counts,
//! whatever its own times are; what the first runs gave stands beside it.

use microsim_mesh::{Block, CellSplit};
use microsim_sparse::{BlockMatrix, Factor, Ordering, Pattern, Symbolic};
use microsim_tests::hands::stages;
use microsim_tests::measured::thread_time;
use microsim_tests::statistics::percentile;
use microsim_tests::{microsim, report_beside, repository, scratch, trainees};
use nalgebra::Matrix3;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

/// The time of a picture \[s\].
const PICTURE: f64 = 16e-3;

/// What input to snapshots may take of it at the 99th percentile \[ms\].
const AIM: f64 = 11.0;

/// Trainees of a level if no number is given.
const TRAINEES: u64 = 10;

/// Modules with vessels.
const MODULES: [&str; 4] = ["diagonal-cut", "dilatation", "trim-blunt", "trim-sharp"];

/// Cells along each edge of the cube whose matrix is factored: about as many elements as the vessels of a level.
const CELLS: usize = 6;

/// How often it is factored before and after a run.
const REPEATS: usize = 15;

/// Over so long \[s\] the machine is watched first, in so many samples, for the speed that it has when nobody else uses it.
const WATCHED: f64 = 30.0;
const SAMPLES: u32 = 60;

/// A run counts as undisturbed up to this ratio of the factor's time to that of the fastest twentieth of the samples.
const UNDISTURBED: f64 = 1.15;

/// Most runs of one script.
const ATTEMPTS: u32 = 3;

/// Runs wait so long in all, with pauses \[s\].
const PATIENCE: f64 = 900.0;
const PAUSE: f64 = 0.5;

/// The speed of the machine: an f64 factor of a fixed matrix, as a tick of a level makes several.
struct Yardstick {
    matrix: BlockMatrix,
    factor: Factor<f64>,
    /// Time of a factor when nobody else uses the machine \[s\].
    undisturbed: f64,
    /// How long runs have waited so far \[s\].
    waited: f64,
}

impl Yardstick {
    fn new() -> Result<Self, String> {
        let block = Block {
            center: [0.0; 3],
            size: [1.0; 3],
            cells: [CELLS; 3],
            split: CellSplit::Kuhn,
        };
        let mesh = block.mesh().map_err(|error| error.to_string())?;
        let pattern = Arc::new(Pattern::from_cliques(mesh.positions.len(), &mesh.tets));
        let ordering = Ordering::nested_dissection(&pattern, Some(&mesh.positions));
        let symbolic = Arc::new(Symbolic::analyse(&pattern, &ordering));
        // Edges as springs of stiffness 1 in each direction, and one at each node to the ground.
        let mut matrix = BlockMatrix::zeros(pattern.clone());
        for i in 0..pattern.nodes() {
            matrix.add_diagonal(i, &Matrix3::identity());
            for &j in pattern.row(i).iter().filter(|j| (**j as usize) < i) {
                matrix.add(i, j as usize, &-Matrix3::identity());
                matrix.add_diagonal(i, &Matrix3::identity());
                matrix.add_diagonal(j as usize, &Matrix3::identity());
            }
        }
        let mut yardstick = Self {
            matrix,
            factor: Factor::new(symbolic),
            undisturbed: 1.0,
            waited: 0.0,
        };
        let mut samples = Vec::new();
        for _ in 0..SAMPLES {
            samples.push(yardstick.measure()?);
            std::thread::sleep(Duration::from_secs_f64(WATCHED / f64::from(SAMPLES)));
        }
        yardstick.undisturbed = percentile(&samples, 0.05);
        Ok(yardstick)
    }

    /// Waits until the machine is undisturbed, as long as there is patience; returns the median time of a factor then.
    fn wait(&mut self) -> Result<f64, String> {
        loop {
            let slower = self.measure()?;
            if slower <= UNDISTURBED || self.waited >= PATIENCE {
                return Ok(slower);
            }
            std::thread::sleep(Duration::from_secs_f64(PAUSE));
            self.waited += PAUSE;
        }
    }

    /// The median time of a factor now, relative to the undisturbed one.
    fn measure(&mut self) -> Result<f64, String> {
        let mut times = Vec::new();
        for _ in 0..REPEATS {
            let start = thread_time();
            let factor = self.factor.factorise(&self.matrix, None);
            factor.map_err(|error| error.to_string())?;
            times.push(thread_time() - start);
        }
        Ok(percentile(&times, 0.5) / self.undisturbed)
    }
}

/// Runs of one kind.
#[derive(Default)]
struct Runs {
    count: u32,
    no_verdict: u32,
    /// CPU time of each picture \[ms\].
    pictures: Vec<f64>,
    /// The same of the first run of each script, disturbed or not.
    first: Vec<f64>,
    /// How much slower the machine was during each run.
    slower: Vec<f64>,
    ticks: u64,
    unconverged: u64,
    invalid: u64,
    repeated: u64,
    over_budget: u64,
}

impl Runs {
    /// Plays a script, named as `--input` takes it, until the machine was undisturbed meanwhile, or often enough.
    fn play(
        &mut self,
        module: &str,
        level: u32,
        script: &str,
        yardstick: &mut Yardstick,
    ) -> Result<(), String> {
        let mut best: Option<(f64, Self)> = None;
        for attempt in 0..ATTEMPTS {
            let before = match attempt {
                0 => yardstick.measure()?,
                _ => yardstick.wait()?,
            };
            let mut run = Self::default();
            run.play_once(module, level, script)?;
            let slower = before.max(yardstick.measure()?);
            if attempt == 0 {
                self.first.extend(&run.pictures);
            }
            if best.as_ref().is_none_or(|(least, _)| slower < *least) {
                best = Some((slower, run));
            }
            if slower <= UNDISTURBED {
                break;
            }
        }
        if let Some((slower, run)) = best {
            self.slower.push(slower);
            self.add(run);
        }
        Ok(())
    }

    fn add(&mut self, other: Self) {
        self.count += other.count;
        self.no_verdict += other.no_verdict;
        self.pictures.extend(other.pictures);
        self.ticks += other.ticks;
        self.unconverged += other.unconverged;
        self.invalid += other.invalid;
        self.repeated += other.repeated;
        self.over_budget += other.over_budget;
    }

    fn play_once(&mut self, module: &str, level: u32, script: &str) -> Result<(), String> {
        let folder = scratch();
        let folder = folder.path();
        let trace = folder.join("trace.json");
        let session = folder.join("run.session");
        let (number, input) = (level.to_string(), format!("script:{script}"));
        let run = microsim([
            "run",
            module,
            "--level",
            &number,
            "--input",
            &input,
            "--no-store",
            "--no-pictures",
            "--session",
            session.to_str().ok_or("UTF-8")?,
            "--trace",
            trace.to_str().ok_or("UTF-8")?,
            "--json",
        ])
        .json();
        let text = std::fs::read_to_string(&trace);
        let text = text.map_err(|error| format!("{}: {error}", trace.display()))?;
        let events: Vec<Value> =
            serde_json::from_str(&text).map_err(|error| format!("{}: {error}", trace.display()))?;
        let ticks = events
            .iter()
            .filter(|of| of["name"] == "tick" && of["ph"] == "E");
        let ticks: Option<Vec<f64>> = ticks.map(cpu_ms).collect();
        let ticks = ticks.ok_or("a tick of the trace has no cpu_us")?;
        let solver = |name: &str| {
            let count = run["solver"][name].as_u64();
            count.ok_or_else(|| format!("the result of {module} {level} has no solver.{name}"))
        };
        let tick_s = report_beside(&session)["session"]["tick_s"].as_f64();
        let tick_s = tick_s.ok_or("the report has no session.tick_s")?;
        let of_picture = (PICTURE / tick_s).round().max(1.0);
        let pictures = ticks.chunks_exact(of_picture as usize);
        self.pictures
            .extend(pictures.map(|of| of.iter().sum::<f64>()));
        self.count += 1;
        let verdict = run["verdict"].as_str().ok_or("the result has no verdict")?;
        self.no_verdict += u32::from(verdict == "not-judged");
        self.ticks += ticks.len() as u64;
        self.unconverged += solver("unconverged")?;
        self.invalid += solver("invalid")?;
        self.repeated += solver("repeated")?;
        self.over_budget += solver("over_budget")?;
        Ok(())
    }

    fn row(&self, level: &str, who: &str) -> String {
        let of = |fraction: f64| percentile(&self.pictures, fraction);
        let longer = |than: f64| self.pictures.iter().filter(|ms| **ms > than).count();
        let mean = self.pictures.iter().sum::<f64>() / self.pictures.len() as f64;
        format!(
            "| {level} | {who} | {} | {:.2} | {:.1} | {mean:.1} | {:.1} | {:.1} | {:.0} | {} | {} of {} | {} | {} | {} | {} of {} | {} |\n",
            self.count,
            percentile(&self.slower, 0.5),
            percentile(&self.first, 0.99),
            of(0.5),
            of(0.99),
            of(1.0),
            longer(1e3 * PICTURE),
            longer(2e3 * PICTURE),
            self.pictures.len(),
            self.repeated,
            self.over_budget,
            self.unconverged,
            self.invalid,
            self.ticks,
            self.no_verdict,
        )
    }
}

/// CPU time of an event \[ms\].
fn cpu_ms(event: &Value) -> Option<f64> {
    let microseconds: f64 = event["args"]["cpu_us"].as_str()?.parse().ok()?;
    Some(1e-3 * microseconds)
}

/// Number of trainees and the modules.
fn order(words: &[String]) -> Option<(u64, Vec<String>)> {
    let Some((count, modules)) = words.split_first() else {
        return Some((TRAINEES, MODULES.map(String::from).into()));
    };
    let modules = match modules {
        [] => MODULES.map(String::from).into(),
        named => named.to_vec(),
    };
    Some((count.parse().ok()?, modules))
}

fn page(trainees: u64, modules: &[String]) -> Result<String, String> {
    let mut yardstick = Yardstick::new()?;
    let mut text = format!(
        "# Cost of the levels with vessels\n\nCommand: `cargo xtask bench levels -- {trainees}{}`. CPU time of a picture of 16 ms from input to snapshots, in ms, of the one thread that computes: over the script that passes, and over {trainees} \
         synthetic trainees (`microsim trainee` from that script: experts, then as many novices, seeds from 1), run one after the other with all their pictures together. The aim is {AIM} ms at p99. A tick is `repeated` where its forces would mean nothing, `over budget` where its work was \
         bounded, `unconverged` where a step of it ended above the tolerance, `without meaning` where no metric takes its forces; too many of these, and there is no verdict.\n\n\
         The machine is not ours alone, and takes up to twice as long for the same instructions when others use it. So the f64 factor of the matrix of a cube of {} tetrahedra is timed before and after each run (p50 of {REPEATS}). In the fastest twentieth of {SAMPLES} samples over {WATCHED} s before all runs it took \
         {:.2} ms; a run during which it took more than {UNDISTURBED} times as long is made again, at most {} times and after waiting for such a factor, for {PATIENCE} s in all; that with the fastest factor counts, whatever its own times are. `slower` is that ratio at p50 over the runs that count. `p99 first` is of the first run of each script, whatever the machine did.\n\n\
         | level | hands | runs | slower | p99 first | mean | p50 | p99 | longest | > 16 ms | > 32 ms | repeated | over budget | unconverged | without meaning | no verdict |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        modules_of_command(modules),
        6 * CELLS.pow(3),
        1e3 * yardstick.undisturbed,
        ATTEMPTS - 1,
    );
    let levels: BTreeSet<(String, u32)> = stages()?
        .into_iter()
        .map(|(stage, _)| (stage.module, stage.level.number))
        .filter(|(module, _)| modules.contains(module))
        .collect();
    for module in modules {
        if !levels.iter().any(|(of, _)| of == module) {
            return Err(format!("no level of {module} has a script that passes"));
        }
    }
    let mut beyond = Vec::new();
    for (module, level) in levels {
        let folder = scratch();
        let name = format!("{module} {level}");
        let mut passing = Runs::default();
        let script = format!("level{level}-pass.toml");
        passing.play(&module, level, &script, &mut yardstick)?;
        let mut trembling = Runs::default();
        for trainee in 0..trainees {
            let experts = trainees.div_ceil(2);
            let (profile, seed) = match trainee < experts {
                true => ("expert", trainee + 1),
                false => ("novice", trainee - experts + 1),
            };
            let script = trainees::make(&module, level, profile, seed, folder.path());
            let script = script.to_str().ok_or("UTF-8")?;
            trembling.play(&module, level, script, &mut yardstick)?;
        }
        for (runs, who) in [(&passing, "script"), (&trembling, "trainees")] {
            if runs.count > 0 {
                let row = runs.row(&name, who);
                eprint!("{row}");
                text.push_str(&row);
                if percentile(&runs.pictures, 0.99) > AIM {
                    beyond.push(format!("{name} ({who})"));
                }
            }
        }
    }
    let _ = match beyond.as_slice() {
        [] => writeln!(text, "\nAll are within the aim."),
        beyond => writeln!(text, "\nAbove the aim: {}.", beyond.join(", ")),
    };
    Ok(text)
}

/// What stands behind the number in the command.
fn modules_of_command(modules: &[String]) -> String {
    match modules == MODULES {
        true => String::new(),
        false => format!(" {}", modules.join(" ")),
    }
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some((trainees, modules)) = order(&words) else {
        eprintln!("expected [TRAINEES [MODULE...]]");
        return ExitCode::from(2);
    };
    let written = page(trainees, &modules).and_then(|text| {
        print!("{text}");
        let file = repository().join("tests/results/levels.md");
        std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("bench levels: {why}");
            ExitCode::FAILURE
        }
    }
}
