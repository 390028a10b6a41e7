//! How much verdicts and metrics depend on the computation: the same motions at twice the iterations, half the tick, and one step finer mesh.

mod section;

use super::limits::Limits;
use super::{KINDS, WORKERS};
use microsim_tests::changed_levels::{CHANGES, ChangedLevels};
use microsim_tests::sensitivity::{Key, Outcome, Runs, Table, read};
use microsim_tests::trainees;
use section::{Metric, section};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Plays `count` trainees of each kind, from `first_seed` on, at one change after the other. Runs that `csv` has already are not played again, but for the first of
/// each kind at each change: an error where they are of another computation. Gives the reports of the level as shipped, by their names, to `as_shipped` if all were played now
/// and the limits are those of the level, and the section of the page to `write` after each change. The limits are the frozen ones of the level, where it has some. A table of the same name in `before/`
/// beside `csv` is of the same trainees with the physics of before, and stands beside theirs.
pub fn study(
    module: &str,
    level: u32,
    count: usize,
    first_seed: u64,
    csv: &Path,
    mut as_shipped: impl FnMut(&[Vec<(String, Value)>]) -> Result<(), String>,
    write: impl Fn(&str) -> Result<(), String>,
) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|error| format!("a temporary folder: {error}"))?;
    let limits = Limits::of(module, level)?;
    let before = csv
        .with_file_name("before")
        .join(csv.file_name().expect("a file"));
    let before = read(&before)?.map(|(_, runs)| runs);
    let trees = CHANGES.map(|(_, change)| {
        let tree = ChangedLevels::new(module, change);
        if let Some(frozen) = &limits.frozen {
            tree.set_limits(level, frozen);
        }
        tree
    });
    let seeds = first_seed..first_seed + count as u64;
    let trainees: Vec<(&str, u64)> = KINDS
        .iter()
        .flat_map(|(kind, _)| seeds.clone().map(move |seed| (*kind, seed)))
        .collect();
    let key = |(trainee, change): (usize, usize)| -> Key {
        let (kind, seed) = trainees[trainee];
        (kind.to_owned(), seed, CHANGES[change].0.to_owned())
    };
    let play = |(trainee, change): (usize, usize)| {
        let (kind, seed) = trainees[trainee];
        let name = folder.path().join(format!("run-{trainee}-{change}"));
        std::fs::create_dir(&name).expect("a folder");
        let script = trainees::make(module, level, kind, seed, &name);
        let session = name.join("session");
        let input = format!("script:{}", script.display());
        let level = level.to_string();
        trees[change].run(&session, &["--level", &level, "--input", &input]);
        let report = std::fs::read_to_string(session.with_extension("json")).expect("a report");
        let report: Value = serde_json::from_str(&report).expect("JSON");
        // The report is all that is needed, and sessions are large.
        std::fs::remove_dir_all(name).expect("the folder that was made");
        report
    };
    let first = play((0, 0));
    let metrics = metrics(&first);
    let ids = metrics.keys().cloned().collect();
    let mut table = Table::open(csv, ids)?;
    table.add(key((0, 0)), &Outcome::of(&first))?;
    let table = Mutex::new(table);
    let shipped = Mutex::new(BTreeMap::from([(0, first)]));
    for (change, (title, _)) in CHANGES.iter().enumerate() {
        let played: Vec<usize> = {
            let table = table.lock().expect("no panic");
            let missing = |trainee: &usize| !table.has(&key((*trainee, change)));
            let there = (0..trainees.len()).filter(|trainee| !missing(trainee));
            eprintln!(
                "{}, {title}: {} of {} runs are there",
                csv.display(),
                there.count(),
                trainees.len()
            );
            let first =
                |trainee: &usize| trainee.is_multiple_of(count) && (*trainee, change) != (0, 0);
            let played = (0..trainees.len()).filter(|t| missing(t) || first(t));
            played.collect()
        };
        let next = AtomicUsize::new(0);
        let work = || -> Result<(), String> {
            while let Some(&trainee) = played.get(next.fetch_add(1, Ordering::Relaxed)) {
                let report = play((trainee, change));
                let outcome = Outcome::of(&report);
                let (kind, seed) = trainees[trainee];
                eprintln!(
                    "  {kind} {seed}, {title}: {} {}",
                    outcome.verdict, outcome.failed
                );
                let mut table = table.lock().expect("no panic");
                table.add(key((trainee, change)), &outcome)?;
                if change == 0 {
                    shipped.lock().expect("no panic").insert(trainee, report);
                }
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let workers = [(); WORKERS].map(|()| scope.spawn(work));
            workers
                .into_iter()
                .try_for_each(|worker| worker.join().expect("no panic"))
        })?;
        let shipped = shipped.lock().expect("no panic");
        if change == 0 && shipped.len() == trainees.len() && limits.are_shipped() {
            let named = shipped.iter().map(|(trainee, report)| {
                let (kind, seed) = trainees[*trainee];
                (format!("{kind} {seed}"), report.clone())
            });
            let named: Vec<_> = named.collect();
            let groups: Vec<_> = named.chunks(count).map(<[_]>::to_vec).collect();
            as_shipped(&groups)?;
        }
        let table = table.lock().expect("no panic");
        table.sort()?;
        let asked = |(kind, seed, level): &Key| {
            let done = &CHANGES[..=change];
            trainees.contains(&(kind, *seed)) && done.iter().any(|(title, _)| title == level)
        };
        let runs = table.runs().iter().filter(|(key, _)| asked(key));
        let runs: Runs = runs.map(|(key, run)| (key.clone(), run.clone())).collect();
        let who = format!(
            "{count} experts and {count} novices, seeds {first_seed} to {}; every run is counted.",
            seeds.end - 1
        );
        let title = format!("## {module}, level {level}\n\n{who}");
        write(&section(&title, &runs, before.as_ref(), &metrics, &limits))?;
    }
    Ok(())
}

/// The metrics of a report, by their ids.
fn metrics(report: &Value) -> BTreeMap<String, Metric> {
    let metric = |metric: &Value| {
        let title = format!(
            "{} [{}]",
            text(&metric["title"]["en"]),
            text(&metric["display_unit"])
        );
        let limited = !metric["limit"].is_null();
        (text(&metric["id"]), Metric { title, limited })
    };
    let metrics = report["metrics"].as_array().into_iter().flatten();
    metrics.map(metric).collect()
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}
