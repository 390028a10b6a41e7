//! `--trace`: where the time of every tick goes, as a file that Perfetto opens.

use microsim_tests::{command, finish, microsim, scratch};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Stages of a tick of a level with tissue.
const STAGES: [&str; 6] = [
    "input",
    "translate",
    "physics",
    "module",
    "objects",
    "record",
];

/// CPU time of each tick in a trace \[µs\].
fn cpu_times(trace: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(trace).expect("a trace");
    let events: Vec<Value> = serde_json::from_str(&text).expect("JSON");
    let ends = events
        .iter()
        .filter(|event| event["name"] == "tick" && event["ph"] == "E");
    ends.filter_map(|event| event["args"]["cpu_us"].as_str()?.parse().ok())
        .collect()
}

/// How often each span begins directly inside of another one, or of none, by the names of both.
fn spans(trace: &Path) -> BTreeMap<(String, String), usize> {
    let text = std::fs::read_to_string(trace).expect("a trace");
    let events: Vec<Value> = serde_json::from_str(&text).expect("JSON");
    let mut counts = BTreeMap::new();
    // Of each thread.
    let mut open: BTreeMap<u64, Vec<String>> = BTreeMap::new();
    for event in &events {
        let open = open.entry(event["tid"].as_u64().unwrap_or_default());
        let open = open.or_default();
        let name = event["name"].as_str().unwrap_or_default().to_owned();
        match event["ph"].as_str() {
            Some("B") => {
                assert!(event["ts"].is_number(), "{event}");
                let outer = open.last().cloned().unwrap_or_default();
                *counts.entry((outer, name.clone())).or_default() += 1;
                open.push(name);
            }
            Some("E") => assert_eq!(open.pop(), Some(name), "{event}"),
            _ => {}
        }
    }
    assert!(open.values().all(Vec::is_empty), "{open:?}");
    counts
}

fn count(spans: &BTreeMap<(String, String), usize>, outer: &str, inner: &str) -> usize {
    let key = (outer.to_owned(), inner.to_owned());
    spans.get(&key).copied().unwrap_or_default()
}

#[test]
fn every_tick_of_a_run_has_its_stages() {
    let folder = scratch();
    let (session, trace) = (
        folder.path().join("a.session"),
        folder.path().join("a.trace"),
    );
    let mut run = command(["run", "push-strip", "--json", "--session"]);
    run.arg(&session);
    run.args([
        "--input",
        "script:level1-fail-not-deep-enough.toml",
        "--trace",
    ]);
    let finished = finish(run.arg(&trace)).expect(0);
    assert!(finished.err.is_empty(), "{}", finished.err);
    let ticks = finished.json()["ticks"].as_u64().expect("a number") as usize;
    let spans = spans(&trace);
    assert_eq!(count(&spans, "", "tick"), ticks);
    for stage in &STAGES[..5] {
        assert_eq!(count(&spans, "tick", stage), ticks, "{stage}");
        // Once, before the first tick.
        assert_eq!(count(&spans, "", "initialise"), STAGES.len());
    }
    // Header and end are not of a tick.
    assert_eq!(count(&spans, "tick", "record"), ticks);
    assert!(count(&spans, "tick", "save") > 0);
    assert_eq!(count(&spans, "", "stop"), STAGES.len());

    // The thread that computes has worked in every tick.
    let cpu = cpu_times(&trace);
    assert_eq!(cpu.len(), ticks);
    assert!(cpu.iter().all(|us| us.is_finite() && *us > 0.0), "{cpu:?}");

    // Nothing is overwritten, and a replay has the same stages but for the input, which is recorded.
    let path = session.to_str().expect("UTF-8");
    let again = microsim(["replay", path, "--trace", trace.to_str().expect("UTF-8")]);
    assert!(again.expect(2).err.contains("exists"));
    let second = folder.path().join("b.trace");
    let replay = ["replay", path, "--trace", second.to_str().expect("UTF-8")];
    microsim(replay).expect(0);
    let spans = self::spans(&second);
    assert_eq!(count(&spans, "tick", "physics"), ticks);
    assert_eq!(count(&spans, "tick", "input"), 0);
    assert_eq!(cpu_times(&second).len(), ticks);
}

#[test]
fn a_scene_shows_solver_and_contact() {
    let folder = scratch();
    let trace = folder.path().join("a.trace");
    let path = trace.to_str().expect("UTF-8");
    microsim([
        "simulate",
        "block-on-slope",
        "--set",
        "run.duration=20ms",
        "--trace",
        path,
    ]);
    let spans = spans(&trace);
    let samples = count(&spans, "", "sample");
    assert!(samples > 0);
    assert!(count(&spans, "sample", "solve") >= samples, "{spans:?}");
    assert!(count(&spans, "solve", "contact-detection") > 0, "{spans:?}");
}
