//! Synthetic trainees: made by the program from the passing script of a level, run, and their reports.

use crate::{microsim, tree};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Writes the script of one trainee into `folder`; gives its path.
#[track_caller]
pub fn make(module: &str, level: u32, profile: &str, seed: u64, folder: &Path) -> PathBuf {
    let plan = tree().join(format!("modules/{module}/scripts/level{level}-pass.toml"));
    let out = folder.join(format!("{profile}-{seed}.toml"));
    let seed = seed.to_string();
    let args = [
        "trainee",
        text(&plan),
        "--profile",
        profile,
        "--seed",
        &seed,
        "--out",
        text(&out),
    ];
    microsim(args).expect(0);
    out
}

/// Runs a script beside which the session and its report are written; gives the session, the output, and the report.
#[track_caller]
pub fn run(module: &str, level: u32, script: &Path) -> (PathBuf, Value, Value) {
    let session = script.with_extension("session");
    let input = format!("script:{}", script.display());
    let level = level.to_string();
    let args = [
        "run",
        module,
        "--level",
        &level,
        "--input",
        &input,
        "--session",
        text(&session),
        "--json",
    ];
    let printed = microsim(args).expect(0).json();
    let report = std::fs::read_to_string(script.with_extension("json"))
        .expect("a report beside the session");
    (
        session,
        printed,
        serde_json::from_str(&report).expect("JSON"),
    )
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// No hand presses microsurgical instruments on tissue so hard \[N\]: 25 times the mean of ophthalmic surgery (Golahmadi 2021). A run
/// that shows more shows a fault of the computation.
pub const ABSURD_FORCE: f64 = 1.0;

/// The largest force of a tool on a body in a report \[N\].
pub fn largest_force(report: &Value) -> f64 {
    let forces = report["forces"].as_array().into_iter().flatten();
    let peaks = forces.flat_map(|series| series["peak"].as_array().into_iter().flatten());
    peaks.filter_map(Value::as_f64).fold(0.0, f64::max)
}

/// Forces and grips from this on may be jumps \[N\]: what the levels call excess.
const JUMP: f64 = 0.03;

/// Ticks with a force or grip of a tool of at least 30 mN that is three times that of the tick before and of the one after: no hand is
/// so fast within 8 ms, the computation is at fault. Before and after a contact there is no force; what the last tick of a session
/// is followed by is not known.
pub fn jumps(report: &Value) -> usize {
    let tick = report["session"]["tick_s"].as_f64().unwrap_or(f64::NAN);
    let last = report["simulated"].as_f64().unwrap_or(f64::NAN) - 1.5 * tick;
    let forces = report["forces"].as_array().into_iter().flatten();
    let count = |series: &Value| {
        let [time, contact, force, grip] =
            ["time", "contact", "force", "grip"].map(|list| numbers(&series[list]));
        let jumps = |values: &[f64]| {
            let beside = |at: usize, other: usize| match contact.get(other) {
                Some(number) if *number == contact[at] => values[other],
                _ => 0.0,
            };
            let is_jump = |at: &usize| {
                let before = at.checked_sub(1).map_or(0.0, |other| beside(*at, other));
                let neighbour = before.max(beside(*at, at + 1));
                time[*at] < last && values[*at] >= JUMP && values[*at] >= 3.0 * neighbour
            };
            (0..values.len()).filter(is_jump).count()
        };
        jumps(&force) + jumps(&grip)
    };
    forces.map(count).sum()
}

/// A list of a report; what is no number there is none here.
fn numbers(list: &Value) -> Vec<f64> {
    let values = list.as_array().into_iter().flatten();
    values.map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
}

/// Ids of the metrics that measure time: score points for them are points for haste.
pub const TIME_METRICS: [&str; 2] = ["time", "idle-fraction"];

/// Scores of a report by category, and their mean at the end, formed again from the points of its metrics without those of `left_out`:
/// a category is the mean of its points times the fraction of the targets, and absent without points. Target achievement is never absent.
pub fn scores(report: &Value, left_out: &[&str]) -> Vec<(String, f64)> {
    let share = report["targets_done"].as_f64().unwrap_or(f64::NAN)
        / report["targets"].as_f64().unwrap_or(f64::NAN);
    let metrics = report["metrics"].as_array().into_iter().flatten();
    let counted = metrics.filter(|m| !left_out.iter().any(|id| m["id"] == *id));
    let points: Vec<(&Value, f64)> = counted
        .filter_map(|m| Some((&m["category"], m["score"].as_f64()?)))
        .collect();
    let categories = report["categories"].as_array().into_iter().flatten();
    let mut scores: Vec<(String, f64)> = categories
        .filter_map(|category| {
            let of_it = points.iter().filter(|(id, _)| **id == category["id"]);
            let of_it: Vec<f64> = of_it.map(|(_, points)| *points).collect();
            let points = match of_it.len() {
                0 if category["id"] == "target" => 100.0,
                0 => return None,
                count => of_it.iter().sum::<f64>() / count as f64,
            };
            let title = category["title"]["en"].as_str().unwrap_or_default();
            Some((title.to_owned(), points * share))
        })
        .collect();
    let total = scores.iter().map(|(_, score)| score).sum::<f64>() / scores.len() as f64;
    scores.push(("total".to_owned(), total));
    scores
}

#[cfg(test)]
mod tests {
    use super::{jumps, scores};

    /// In ticks of 8 ms, of which the session has 12: one of 118 mN among ticks of 4 mN is a jump; what rises over two ticks is none, and
    /// neither is what is small. Between tick 4 and tick 8 there is no contact: the 40 mN of tick 8 are a jump though 38 mN stand before
    /// them in the list, and so are the 36 mN of tick 10 alone; what comes after tick 11 is not known.
    #[test]
    fn a_force_of_one_tick_is_a_jump() {
        let ticks = [0, 1, 2, 3, 4, 8, 10, 11];
        let report = |force: [f64; 8], contact: [u32; 8]| {
            let time = ticks.map(|tick| f64::from(tick) * 0.008);
            serde_json::json!({
                "session": { "tick_s": 0.008 }, "simulated": 12.0 * 0.008,
                "forces": [{ "time": time, "contact": contact, "force": force, "grip": force.map(|f| 0.2 * f) }],
            })
        };
        let forces = [0.004, 0.118, 0.005, 0.02, 0.038, 0.04, 0.036, 0.2];
        let separate = [0, 0, 0, 0, 0, 1, 2, 2];
        assert_eq!(jumps(&report(forces, separate)), 2);
        let alone = [0, 0, 0, 0, 0, 1, 2, 3];
        assert_eq!(jumps(&report(forces, alone)), 3);
        let squeezed = forces.map(|f| 5.0 * f);
        assert_eq!(jumps(&report(squeezed, separate)), 4, "grips as well");
    }

    /// By hand: half of the targets; target without points 50; handling (80 + 40)/2 · ½ = 30, without the first 20; efficiency 10,
    /// and absent when its one metric is left out.
    #[test]
    fn scores_with_and_without_a_metric() {
        let metric = |id: &str, category: &str, score: Option<f64>| serde_json::json!({ "id": id, "category": category, "score": score });
        let category = |id: &str| serde_json::json!({ "id": id, "title": { "en": id, "de": id } });
        let report = serde_json::json!({
            "targets_done": 1, "targets": 2,
            "categories": [category("target"), category("handling"), category("efficiency")],
            "metrics": [
                metric("drops", "handling", Some(80.0)),
                metric("steadied", "handling", Some(40.0)),
                metric("tremor", "handling", None),
                metric("time", "efficiency", Some(20.0)),
            ],
        });
        let named = |names: &[(&str, f64)]| -> Vec<(String, f64)> {
            names.iter().map(|(n, s)| ((*n).to_owned(), *s)).collect()
        };
        assert_eq!(
            scores(&report, &[]),
            named(&[
                ("target", 50.0),
                ("handling", 30.0),
                ("efficiency", 10.0),
                ("total", 30.0)
            ])
        );
        assert_eq!(
            scores(&report, &["drops", "time"]),
            named(&[("target", 50.0), ("handling", 20.0), ("total", 35.0)])
        );
    }
}
