//! Tables of the same trainees at different computations, and how much their metrics depend on them.

mod table;

pub use table::Table;

use crate::changed_levels::CHANGES;
use crate::statistics::Group;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Metrics whose numerical spread is above this fraction of the difference of the groups measure the solver as much as the hand.
pub const MOST_SPREAD: f64 = 0.5;

/// Profiles of the two groups.
pub const KINDS: [&str; 2] = ["expert", "novice"];

/// Columns before those of the metrics.
const FIRST: &str = "kind,seed,level,verdict,failed";

/// A run by kind and seed of the trainee and what was changed in the level.
pub type Key = (String, u64, String);

/// What came of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// As in a report.
    pub verdict: String,
    /// Reasons, with blanks between.
    pub failed: String,
    /// By the ids of metrics, in display units.
    pub values: BTreeMap<String, f64>,
}

impl Outcome {
    /// From the report of a run.
    pub fn of(report: &Value) -> Self {
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let metrics = report["metrics"].as_array().into_iter().flatten();
        let values = metrics.filter_map(|metric| {
            let value = metric["display_value"].as_f64()?;
            Some((text(&metric["id"]), value))
        });
        let failed = report["failed"].as_array().into_iter().flatten();
        Self {
            verdict: text(&report["verdict"]),
            failed: failed.map(text).collect::<Vec<_>>().join(" "),
            values: values.collect(),
        }
    }
}

/// All runs of a table.
pub type Runs = BTreeMap<Key, Outcome>;

/// The first line of a table with these metrics.
pub fn header(metrics: &[String]) -> String {
    format!("{FIRST},{}", metrics.join(","))
}

/// The line of a run.
pub fn line((kind, seed, level): &Key, outcome: &Outcome, metrics: &[String]) -> String {
    let mut line = format!(
        "{kind},{seed},{level},{},{}",
        outcome.verdict, outcome.failed
    );
    for id in metrics {
        line.push(',');
        if let Some(value) = outcome.values.get(id) {
            let _ = write!(line, "{value:.5}");
        }
    }
    line
}

/// The run in a line; `None` if it is none with these metrics.
pub fn run(line: &str, metrics: &[String]) -> Option<(Key, Outcome)> {
    let mut cells = line.split(',');
    let mut next = || cells.next().map(str::to_owned);
    let key = (next()?, next()?.parse().ok()?, next()?);
    let (verdict, failed) = (next()?, next()?);
    let mut values = BTreeMap::new();
    for id in metrics {
        let cell = next()?;
        if !cell.is_empty() {
            values.insert(id.clone(), cell.parse().ok()?);
        }
    }
    let outcome = Outcome {
        verdict,
        failed,
        values,
    };
    cells.next().is_none().then_some((key, outcome))
}

/// The metrics and runs of a table; none where there is no file. An error where a line is none of it.
pub fn read(path: &Path) -> Result<Option<(Vec<String>, Runs)>, String> {
    let Ok(text) = fs::read_to_string(path) else {
        return Ok(None);
    };
    let mut lines = text.lines();
    let first = lines.next().and_then(|line| line.strip_prefix(FIRST));
    let metrics = first.and_then(|rest| rest.strip_prefix(','));
    let metrics =
        metrics.ok_or_else(|| format!("{}, line 1: no columns {FIRST},…", path.display()))?;
    let metrics: Vec<String> = metrics.split(',').map(str::to_owned).collect();
    let runs = lines.enumerate().map(|(number, line)| {
        let number = number + 2;
        run(line, &metrics)
            .ok_or_else(|| format!("{}, line {number}: no run of {FIRST},…", path.display()))
    });
    let runs = runs.collect::<Result<_, _>>()?;
    Ok(Some((metrics, runs)))
}

/// A metric of the groups, and how much it depends on the computation. Runs that are not judged are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependence {
    /// Mean of each group of [`KINDS`], the level as shipped.
    pub means: [f64; 2],
    /// Root mean square of the change from the level as shipped, over all trainees, at each of [`CHANGES`] but the first; `None` where no run is there.
    pub spreads: [Option<f64>; CHANGES.len() - 1],
}

impl Dependence {
    /// Of a metric; `None` where a group has fewer than two values.
    pub fn of(runs: &Runs, metric: &str) -> Option<Self> {
        let value = |(kind, seed, _): &Key, change: usize| {
            let key = (kind.clone(), *seed, CHANGES[change].0.to_owned());
            let run = runs.get(&key).filter(|run| run.verdict != "not-judged")?;
            run.values.get(metric).copied()
        };
        let shipped = || runs.keys().filter(|(.., level)| level == CHANGES[0].0);
        let mean = |kind: &str| {
            let group = shipped().filter(|(of, ..)| of == kind);
            let values: Vec<f64> = group.filter_map(|key| value(key, 0)).collect();
            Group::of(&values).map(|group| group.mean)
        };
        let spreads = std::array::from_fn(|at| {
            let pairs = shipped().filter_map(|key| Some(value(key, at + 1)? - value(key, 0)?));
            root_mean_square(&pairs.collect::<Vec<_>>())
        });
        Some(Self {
            means: [mean(KINDS[0])?, mean(KINDS[1])?],
            spreads,
        })
    }

    /// By how much the groups differ.
    pub fn difference(&self) -> f64 {
        (self.means[1] - self.means[0]).abs()
    }

    /// The largest spread over the difference; 0 where nothing depends on the computation.
    pub fn ratio(&self) -> f64 {
        let largest = self.spreads.iter().flatten().fold(0.0f64, |a, b| a.max(*b));
        match largest {
            0.0 => 0.0,
            _ => largest / self.difference(),
        }
    }
}

/// `None` without any.
fn root_mean_square(differences: &[f64]) -> Option<f64> {
    let squares: f64 = differences.iter().map(|d| d * d).sum();
    (!differences.is_empty()).then(|| (squares / differences.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: experts 1 and 3, novices 6 and 8 differ by 5; changes of 3 and −4, the others without the run, have a root mean square of √12.5.
    #[test]
    fn spreads_are_root_mean_squares_of_judged_pairs() {
        let mut runs = Runs::new();
        let mut add = |kind: &str, seed: u64, change: usize, verdict: &str, value: f64| {
            let outcome = Outcome {
                verdict: verdict.to_owned(),
                failed: String::new(),
                values: [("torn".to_owned(), value)].into(),
            };
            let key = (kind.to_owned(), seed, CHANGES[change].0.to_owned());
            runs.insert(key, outcome);
        };
        for (kind, seed, value) in [
            ("expert", 1, 1.0),
            ("expert", 2, 3.0),
            ("novice", 1, 6.0),
            ("novice", 2, 8.0),
        ] {
            add(kind, seed, 0, "passed", value);
        }
        add("expert", 1, 2, "failed", 4.0);
        add("novice", 2, 2, "passed", 4.0);
        add("novice", 1, 2, "not-judged", 1000.0);
        let found = Dependence::of(&runs, "torn").expect("two groups");
        assert_eq!(found.means, [2.0, 7.0]);
        assert_eq!(found.spreads, [None, Some(12.5f64.sqrt()), None]);
        assert_eq!(found.ratio(), 12.5f64.sqrt() / 5.0);
        assert_eq!(Dependence::of(&runs, "drops"), None);
    }
}
