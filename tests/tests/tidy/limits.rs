//! What decides over a pass depends on the hand more than on the computation: limits are those that the tables of sensitivity bear.

use crate::{assert_none, text};
use microsim_tests::changed_levels::CHANGES;
use microsim_tests::repository;
use microsim_tests::sensitivity::{Dependence, MOST_SPREAD, Runs, read};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// The metrics of a level's limits: all, and those that decide.
fn limits(level: &str) -> (BTreeSet<String>, BTreeSet<String>) {
    let table: Table = level.parse().expect("TOML");
    let limits = table.get("limit").and_then(Value::as_array);
    let metric = |limit: &Value| limit["metric"].as_str().expect("a metric").to_owned();
    let limits = || limits.into_iter().flatten();
    let decides = |limit: &&Value| limit.get("decides") != Some(&Value::Boolean(false));
    (
        limits().map(metric).collect(),
        limits().filter(decides).map(metric).collect(),
    )
}

fn is_complete(runs: &Runs) -> bool {
    let of = |title: &str| runs.keys().filter(|(.., level)| level == title).count();
    CHANGES
        .iter()
        .all(|(title, _)| of(title) == of(CHANGES[0].0))
}

/// A metric whose numerical spread is above half of the difference of the groups is a reference value, and no other is one.
#[test]
fn limits_decide_where_the_hand_counts_more_than_the_computation() {
    let folder = repository().join("tests/results/sensitivity");
    let mut complaints = Vec::new();
    let mut compared = 0;
    for entry in std::fs::read_dir(&folder).expect("the tables") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            // Of the physics of before.
            continue;
        }
        let stem = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let (module, level) = stem.rsplit_once('-').expect("MODULE-LEVEL.csv");
        let (_, runs) = read(&path).expect("a table").expect("a file");
        if !is_complete(&runs) {
            continue;
        }
        compared += 1;
        let name = format!("modules/{module}/levels/level{level}.toml");
        let (all, deciding) = limits(&text(&repository().join(&name)));
        for metric in all {
            let ratio = Dependence::of(&runs, &metric).map(|found| found.ratio());
            let holds = ratio.is_none_or(|ratio| ratio <= MOST_SPREAD);
            if holds != deciding.contains(&metric) {
                complaints.push(format!(
                    "{name}: {metric} has a numerical spread of {ratio:.2?} of the difference; expected `decides = {holds}`"
                ));
            }
        }
    }
    assert!(compared > 0, "no table is complete");
    assert_none(&complaints);
}
