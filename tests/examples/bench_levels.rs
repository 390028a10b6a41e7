//! `cargo xtask bench levels [-- TRAINEES [MODULE...]]`: CPU time of a picture of 16 ms in every level with vessels, or in those of the named modules: over the script that passes
//! and over so many synthetic trainees, 10 if not given, the first half of them experts, with seeds from 1. Beside it what the solver did not come to the end with, and how many
//! trainees have no verdict. Written to `tests/results/levels.md`.
//!
//! Each run is a process of the shipped program without pictures, one after the other; the time is that of the thread that computes, from the trace. Nothing is
//! asserted about time.
//!
//! A core that others use as well takes longer for the same instructions at some moments than at others. Each script is played a second time: the computation
//! is the same to the bit, so the lesser of both times of a picture is nearer to what it takes when nobody else uses the core. It stands beside those of single runs.

use microsim_tests::hands::stages;
use microsim_tests::statistics::percentile;
use microsim_tests::{microsim, report_beside, repository, scratch, trainees};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::process::ExitCode;

/// The time of a picture \[s\].
const PICTURE: f64 = 16e-3;

/// What input to snapshots may take of it at the 99th percentile \[ms\].
const AIM: f64 = 11.0;

/// Trainees of a level if no number is given.
const TRAINEES: u64 = 10;

/// Modules with vessels.
const MODULES: [&str; 4] = ["diagonal-cut", "dilatation", "trim-blunt", "trim-sharp"];

/// Runs of one kind.
#[derive(Default)]
struct Runs {
    count: u32,
    no_verdict: u32,
    /// CPU time of each picture \[ms\].
    pictures: Vec<f64>,
    /// The lesser one of two runs.
    lesser: Vec<f64>,
    ticks: u64,
    unconverged: u64,
    invalid: u64,
    repeated: u64,
    over_budget: u64,
}

impl Runs {
    /// Plays a script, named as `--input` takes it, and again for the times alone.
    fn play(&mut self, module: &str, level: u32, script: &str) -> Result<(), String> {
        let [mut first, mut again] = [Self::default(), Self::default()];
        first.play_once(module, level, script)?;
        again.play_once(module, level, script)?;
        if first.counts() != again.counts() {
            return Err(format!(
                "{module} {level}: {script} was another computation when it was played again"
            ));
        }
        let both = first.pictures.iter().zip(&again.pictures);
        self.lesser.extend(both.map(|(a, b)| a.min(*b)));
        self.add(&first);
        Ok(())
    }

    /// All but times.
    fn counts(&self) -> [u64; 8] {
        [
            self.pictures.len() as u64,
            u64::from(self.count),
            u64::from(self.no_verdict),
            self.ticks,
            self.unconverged,
            self.invalid,
            self.repeated,
            self.over_budget,
        ]
    }

    fn add(&mut self, other: &Self) {
        self.pictures.extend(&other.pictures);
        self.count += other.count;
        self.no_verdict += other.no_verdict;
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
            "| {level} | {who} | {} | {mean:.1} | {:.1} | {:.1} | {:.0} | {:.1} | {} | {} of {} | {} | {} | {} | {} of {} | {} |\n",
            self.count,
            of(0.5),
            of(0.99),
            of(1.0),
            percentile(&self.lesser, 0.99),
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
    let mut text = format!(
        "# Cost of the levels with vessels\n\nCommand: `cargo xtask bench levels -- {trainees}{}`. CPU time of a picture of 16 ms from input to snapshots, in ms, of the one thread that computes: over the script that passes, and over {trainees} \
         synthetic trainees (`microsim trainee` from that script: experts, then as many novices, seeds from 1), run one after the other with all their pictures together. The aim is {AIM} ms at p99. A tick is `repeated` where its forces would mean nothing, `over budget` where its work was \
         bounded, `unconverged` where a step of it ended above the tolerance, `without meaning` where no metric takes its forces; too many of these, and there is no verdict. Times are those of single runs; each script was played again, which is the same computation, and `p99, lesser` is of the lesser time of each picture: \
         a core that others use as well takes longer at some moments than at others.\n\n\
         | level | hands | runs | mean | p50 | p99 | longest | p99, lesser | > 16 ms | > 32 ms | repeated | over budget | unconverged | without meaning | no verdict |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        modules_of_command(modules),
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
    let (mut beyond, mut lesser_too) = (Vec::new(), Vec::new());
    for (module, level) in levels {
        let folder = scratch();
        let name = format!("{module} {level}");
        let mut passing = Runs::default();
        passing.play(&module, level, &format!("level{level}-pass.toml"))?;
        let mut trembling = Runs::default();
        for trainee in 0..trainees {
            let experts = trainees.div_ceil(2);
            let (profile, seed) = match trainee < experts {
                true => ("expert", trainee + 1),
                false => ("novice", trainee - experts + 1),
            };
            let script = trainees::make(&module, level, profile, seed, folder.path());
            trembling.play(&module, level, script.to_str().ok_or("UTF-8")?)?;
        }
        for (runs, who) in [(&passing, "script"), (&trembling, "trainees")] {
            if runs.count > 0 {
                let row = runs.row(&name, who);
                eprint!("{row}");
                text.push_str(&row);
                if percentile(&runs.pictures, 0.99) > AIM {
                    beyond.push(format!("{name} ({who})"));
                }
                if percentile(&runs.lesser, 0.99) > AIM {
                    lesser_too.push(format!("{name} ({who})"));
                }
            }
        }
    }
    for (times, rows) in [("single runs", beyond), ("lesser times", lesser_too)] {
        let names = match rows.as_slice() {
            [] => "none".to_owned(),
            rows => rows.join(", "),
        };
        let _ = writeln!(
            text,
            "\nAbove the aim by {times} ({} rows): {names}.",
            rows.len()
        );
    }
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
