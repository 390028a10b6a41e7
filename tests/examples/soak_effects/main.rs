//! `cargo xtask soak effects -- N FIRST_SEED [MODULE [LEVEL]]`: N synthetic experts and N novices on a level, on all levels of a module, or on every level: effect sizes of score and metrics with
//! their errors as the level is shipped, at twice the iterations and at half the tick, and how many verdicts change with these. Limits and profiles are those of the built tree.
//!
//! All runs are in a table of each level in `tests/results/effects/`, from which `tests/results/effects.md` is made after every seed. It may be stopped and goes on with the runs that are
//! missing there; the first expert of each level is played again, and the soak ends where that is another computation. Seeds are played one after the other on all levels and in all
//! computations, so that one that is stopped has as many of each.

mod page;

use microsim_tests::changed_levels::{COMPUTATIONS, ChangedLevels};
use microsim_tests::sensitivity::{KINDS, Key, Outcome, Table};
use microsim_tests::{repository, scratch, trainees, tree};
use page::SCORE;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Runs at the same time, a process each.
const WORKERS: usize = 2;

/// What is asked for.
struct Order {
    /// Trainees of each kind.
    count: u64,
    first_seed: u64,
    module: Option<String>,
    level: Option<u32>,
}

impl Order {
    fn of(words: &[String]) -> Option<Self> {
        let (count, first_seed, rest) = match words {
            [count, first_seed, rest @ ..] => (count.parse().ok()?, first_seed.parse().ok()?, rest),
            _ => return None,
        };
        let (module, level) = match rest {
            [] => (None, None),
            [module] => (Some(module.clone()), None),
            [module, level] => (Some(module.clone()), Some(level.parse().ok()?)),
            _ => return None,
        };
        (count >= 2).then_some(Self {
            count,
            first_seed,
            module,
            level,
        })
    }
}

/// A level that is studied.
struct Study {
    module: String,
    level: u32,
    table: Mutex<Table>,
    /// The computations that are another one for this level: one without tissue has no iterations.
    computations: Vec<usize>,
    /// Runs so far, and how long they took [s].
    taken: Mutex<(u32, f64)>,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some(order) = Order::of(&words) else {
        eprintln!("expected N FIRST_SEED [MODULE [LEVEL]]: two trainees of each kind or more");
        return ExitCode::from(2);
    };
    match soak(&order) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// The levels that are asked for and have a script that passes, in the order of their names.
fn levels(order: &Order) -> Result<Vec<(String, u32)>, String> {
    let folder = tree().join("modules");
    let entries = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let names = entries
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok());
    let mut levels = Vec::new();
    for module in names.filter(|name| order.module.as_ref().is_none_or(|asked| asked == name)) {
        let scripts = folder.join(&module).join("scripts");
        let all =
            (1..).take_while(|level| scripts.join(format!("level{level}-pass.toml")).is_file());
        let asked = all.filter(|level| order.level.is_none_or(|asked| asked == *level));
        levels.extend(asked.map(|level| (module.clone(), level)));
    }
    levels.sort();
    match levels.is_empty() {
        true => Err("there is no such level".to_owned()),
        false => Ok(levels),
    }
}

fn soak(order: &Order) -> Result<(), String> {
    let levels = levels(order)?;
    let mut trees = BTreeMap::new();
    for (module, _) in &levels {
        trees
            .entry(module.clone())
            .or_insert_with(|| COMPUTATIONS.map(|(_, change)| ChangedLevels::new(module, change)));
    }
    let play = |(module, level): &(String, u32), kind: &str, seed: u64, computation: usize| {
        let began = Instant::now();
        let folder = scratch();
        let script = trainees::make(module, *level, kind, seed, folder.path());
        let session = folder.path().join("session");
        let input = format!("script:{}", script.display());
        let number = level.to_string();
        let args = ["--no-pictures", "--level", &number, "--input", &input];
        trees[module][computation].run(&session, &args);
        let outcome = outcome(&microsim_tests::report_beside(&session));
        let seconds = began.elapsed().as_secs_f64();
        eprintln!(
            "{module} {level}, {kind} {seed}, {}: {} {} in {seconds:.0} s",
            COMPUTATIONS[computation].0, outcome.verdict, outcome.failed
        );
        (outcome, seconds)
    };
    let mut studies = Vec::new();
    for of in &levels {
        let (first, seconds) = play(of, KINDS[0], order.first_seed, 0);
        let ids: Vec<String> = metrics(&of.0, of.1, &first)?;
        let mut table = Table::open(&file(of), ids)?;
        table.add(key(KINDS[0], order.first_seed, 0), &first)?;
        studies.push(Study {
            module: of.0.clone(),
            level: of.1,
            table: Mutex::new(table),
            computations: computations(&of.0, of.1)?,
            taken: Mutex::new((1, seconds)),
        });
    }
    for seed in order.first_seed..order.first_seed + order.count {
        let mut jobs = Vec::new();
        for (at, study) in studies.iter().enumerate() {
            let table = study.table.lock().expect("no panic");
            for kind in KINDS {
                let all = study.computations.iter();
                let missing = all.filter(|change| !table.has(&key(kind, seed, **change)));
                jobs.extend(missing.map(|change| (at, kind, *change)));
            }
        }
        let next = AtomicUsize::new(0);
        let work = || -> Result<(), String> {
            while let Some(&(at, kind, change)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                let study = &studies[at];
                let (outcome, seconds) = play(&levels[at], kind, seed, change);
                let mut table = study.table.lock().expect("no panic");
                table.add(key(kind, seed, change), &outcome)?;
                let mut taken = study.taken.lock().expect("no panic");
                *taken = (taken.0 + 1, taken.1 + seconds);
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let workers = [(); WORKERS].map(|()| scope.spawn(work));
            workers
                .into_iter()
                .try_for_each(|worker| worker.join().expect("no panic"))
        })?;
        for study in &studies {
            study.table.lock().expect("no panic").sort()?;
        }
        page::write()?;
    }
    print_times(&studies);
    Ok(())
}

/// How long a run takes, and how long twenty experts and twenty novices would.
fn print_times(studies: &[Study]) {
    let mut all = 0.0;
    for study in studies {
        let (runs, seconds) = *study.taken.lock().expect("no panic");
        let each = seconds / f64::from(runs);
        let whole = each * (40 * study.computations.len()) as f64 / WORKERS as f64 / 3600.0;
        all += whole;
        println!(
            "{} {}: {each:.1} s a run, {WORKERS} at a time; 20 experts and 20 novices take {whole:.2} h",
            study.module, study.level
        );
    }
    println!("all of these levels: {all:.1} h");
}

/// Those that change a level's file, and that as it is shipped.
fn computations(module: &str, level: u32) -> Result<Vec<usize>, String> {
    let path = tree().join(format!("modules/{module}/levels/level{level}.toml"));
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let all = COMPUTATIONS.iter().enumerate();
    let others = all.filter(|(at, (_, change))| *at == 0 || change(&text) != text);
    Ok(others.map(|(at, _)| at).collect())
}

fn key(kind: &str, seed: u64, computation: usize) -> Key {
    (
        kind.to_owned(),
        seed,
        COMPUTATIONS[computation].0.to_owned(),
    )
}

/// The table of a level.
fn file((module, level): &(String, u32)) -> PathBuf {
    repository().join(format!("tests/results/effects/{module}-{level}.csv"))
}

/// The outcome of a run, its score beside the metrics.
fn outcome(report: &Value) -> Outcome {
    let mut outcome = Outcome::of(report);
    let score = report["score"].as_f64();
    let is_judged = outcome.verdict != "not-judged";
    outcome.values.extend(
        score
            .filter(|_| is_judged)
            .map(|score| (SCORE.to_owned(), score)),
    );
    outcome
}

/// Columns of the table of a level: score, the metrics that it limits, and what else the run measured.
fn metrics(module: &str, level: u32, first: &Outcome) -> Result<Vec<String>, String> {
    let mut ids = vec![SCORE.to_owned()];
    ids.extend(page::limits(module, level)?.into_keys());
    let more = first.values.keys().filter(|id| !ids.contains(id));
    let more: Vec<String> = more.cloned().collect();
    ids.extend(more);
    Ok(ids)
}
