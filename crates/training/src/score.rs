//! From measurements to the verdict and to the score.
//!
//! **Verdict.** Passed: all targets achieved, no reason against it, and *every* metric within its limit, as Mimic's MScore
//! and LapMentor do. There is no sum in which a good time makes up for bad handling: such a sum failed to separate surgeons
//! from students on Eyesi (Selvander & Åsman 2013, PMC3794851).
//!
//! A limited metric that is *not applicable* does not fail the level, but is stated as such: it could not be formed because of
//! the device or the length of the run (one hand, 50 samples a second), and a trainee is not failed for what was not seen.
//! Doing nothing gains nothing by it, for without targets there is no pass.
//!
//! **Score**, beside the verdict: 0–100 in each category, for the trainee to see progress. Each limited metric runs linearly
//! from 0 at its `zero` to 100 at its `full`; a category is the mean of its applicable limited metrics times the achieved
//! fraction of the targets, so that doing nothing scores 0. Target achievement always exists; with no metric of its own it is
//! that fraction. Another category without an applicable limited metric is absent, not 0. The total is the mean of the
//! categories and decides nothing.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::level::sorted_reasons;
use crate::measure::Measurement;
use crate::metric::{MetricDefinition, MetricValue, NotApplicable};
use microsim_vocabulary::{Category, Direction};

/// The limit of a metric in a level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// Id of the metric.
    pub metric: String,
    /// Smallest value that passes, in the SI unit of the metric.
    pub min: Option<f64>,
    /// Largest value that passes, in the SI unit of the metric.
    pub max: Option<f64>,
    /// Value at which the score reaches 0.
    pub zero: f64,
    /// Value at which the score reaches 100. For a metric of direction `Range` the score falls to both sides of it.
    pub full: f64,
    /// Id of the reason when it is violated; the metric's id if `None`.
    pub reason: Option<String>,
    /// Where the numbers come from.
    pub source: String,
    /// Set by judgement, not yet by measured experts.
    pub provisional: bool,
    /// Whether a value beyond it, or none at all, stands against a pass; otherwise it is a reference value.
    pub decides: bool,
}

/// Why limits and definitions do not fit together.
#[derive(Debug, Clone, PartialEq)]
pub enum LimitError {
    /// Two definitions have this id.
    DuplicateDefinition(String),
    /// Two limits are set on this metric.
    DuplicateLimit(String),
    /// No definition has this id.
    UnknownMetric(String),
    /// The metric is informative: it has no better side.
    Informative(String),
    /// A number of the limit is NaN or infinite.
    NotFinite(String),
    /// Neither `min` nor `max` is given.
    Unlimited(String),
    /// `min` is larger than `max`.
    Empty(String),
    /// `zero` and `full` are equal, or in the wrong order for the metric's direction.
    Ramp(String),
}

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LimitError::DuplicateDefinition(id) => write!(f, "metric {id:?} is defined twice"),
            LimitError::DuplicateLimit(id) => write!(f, "metric {id:?} is limited twice"),
            LimitError::UnknownMetric(id) => write!(f, "limit: no metric is called {id:?}"),
            LimitError::Informative(id) => write!(
                f,
                "limit of {id:?}: the metric is informative and cannot be limited"
            ),
            LimitError::NotFinite(id) => write!(f, "limit of {id:?}: a number is not finite"),
            LimitError::Unlimited(id) => write!(f, "limit of {id:?}: neither min nor max is given"),
            LimitError::Empty(id) => write!(f, "limit of {id:?}: min is larger than max"),
            LimitError::Ramp(id) => {
                write!(
                    f,
                    "limit of {id:?}: the score must rise from zero to full in the metric's better direction"
                )
            }
        }
    }
}

impl std::error::Error for LimitError {}

/// How many targets were achieved, of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TargetCount {
    /// Achieved.
    pub done: usize,
    /// All of the level.
    pub total: usize,
}

impl TargetCount {
    /// Achieved fraction, 0..1; 0 for a level without targets.
    pub fn fraction(self) -> f64 {
        if self.total == 0 {
            0.0
        } else {
            self.done.min(self.total) as f64 / self.total as f64
        }
    }

    fn all_done(self) -> bool {
        self.total > 0 && self.done >= self.total
    }
}

/// One limited metric of a run, with all that its score stands on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScoreRecord {
    /// The limit, with the metric's id, thresholds and source.
    pub limit: Limit,
    /// SI unit of the value.
    pub unit: String,
    /// Name and version of the formula.
    pub formula: String,
    /// Category that the points count for.
    pub category: Category,
    /// What was measured.
    pub value: MetricValue,
    /// Whether the limit was met; `None` if the metric has no value, or one that is not finite.
    pub within: Option<bool>,
    /// 0..100; `None` if the metric has no value, or one that is not finite.
    pub points: Option<f64>,
}

/// Score of one category.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CategoryScore {
    /// Which.
    pub category: Category,
    /// 0..100.
    pub score: f64,
}

/// Verdict and score of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Assessment {
    /// The verdict: true exactly if `failed` and `unmeasured` are empty.
    pub passed: bool,
    /// Ids of the metrics without a finite value whose limits decide, in the order of the limits. Without any other reason against a pass there is no
    /// verdict then: a limit that nobody measured is not met.
    pub unmeasured: Vec<String>,
    /// Ids of all reasons against a pass, sorted, each once.
    pub failed: Vec<String>,
    /// Targets achieved.
    pub targets: TargetCount,
    /// Each limited metric, in the order of the limits.
    pub records: Vec<ScoreRecord>,
    /// The categories that exist in this run, in the order of [`Category::ALL`].
    pub categories: Vec<CategoryScore>,
    /// Mean of the categories, 0..100. Decides nothing.
    pub total: f64,
}

/// The metrics and limits of a level, checked against each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Rules {
    limits: Vec<(Limit, MetricDefinition)>,
}

impl Rules {
    /// Joins definitions (the catalogue's and the module's own) with a level's limits.
    pub fn new<'a>(
        definitions: impl IntoIterator<Item = &'a MetricDefinition>,
        limits: Vec<Limit>,
    ) -> Result<Self, LimitError> {
        let definitions: Vec<&MetricDefinition> = definitions.into_iter().collect();
        for (index, definition) in definitions.iter().enumerate() {
            if definitions[..index]
                .iter()
                .any(|other| other.id == definition.id)
            {
                return Err(LimitError::DuplicateDefinition(definition.id.to_string()));
            }
        }
        let mut checked: Vec<(Limit, MetricDefinition)> = Vec::with_capacity(limits.len());
        for limit in limits {
            if checked
                .iter()
                .any(|(other, _)| other.metric == limit.metric)
            {
                return Err(LimitError::DuplicateLimit(limit.metric));
            }
            let Some(definition) = definitions
                .iter()
                .find(|definition| definition.id == limit.metric)
            else {
                return Err(LimitError::UnknownMetric(limit.metric));
            };
            check(&limit, definition.direction)?;
            checked.push((limit, (*definition).clone()));
        }
        Ok(Rules { limits: checked })
    }

    /// Judges a run by its targets, its measurements (those of the run as a whole) and the reasons that the module itself
    /// saw against a pass. A limited metric that nobody measured is neither met nor broken.
    pub fn assess<S: Into<String>>(
        &self,
        targets: TargetCount,
        measurements: &[Measurement],
        reasons: impl IntoIterator<Item = S>,
    ) -> Assessment {
        let mut failed = sorted_reasons(
            reasons.into_iter().map(Into::into).collect(),
            targets.all_done(),
        );
        let records: Vec<ScoreRecord> = self
            .limits
            .iter()
            .map(|(limit, definition)| record(limit, definition, measurements))
            .collect();
        let deciding = || records.iter().filter(|record| record.limit.decides);
        for record in deciding().filter(|record| record.within == Some(false)) {
            failed.push(
                record
                    .limit
                    .reason
                    .clone()
                    .unwrap_or_else(|| record.limit.metric.clone()),
            );
        }
        failed.sort_unstable();
        failed.dedup();
        let without = deciding().filter(|record| record.within.is_none());
        let unmeasured: Vec<String> = without.map(|r| r.limit.metric.clone()).collect();

        let categories: Vec<CategoryScore> = Category::ALL
            .into_iter()
            .filter_map(|category| {
                let points: Vec<f64> = records
                    .iter()
                    .filter(|record| record.category == category)
                    .filter_map(|record| record.points)
                    .collect();
                let handling = match (points.as_slice(), category) {
                    ([], Category::Target) => 100.0,
                    ([], _) => return None,
                    (points, _) => mean(points),
                };
                Some(CategoryScore {
                    category,
                    score: handling * targets.fraction(),
                })
            })
            .collect();
        let scores: Vec<f64> = categories.iter().map(|category| category.score).collect();
        Assessment {
            passed: failed.is_empty() && unmeasured.is_empty(),
            unmeasured,
            failed,
            targets,
            records,
            categories,
            total: mean(&scores),
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn record(
    limit: &Limit,
    definition: &MetricDefinition,
    measurements: &[Measurement],
) -> ScoreRecord {
    let of_run = |measurement: &&Measurement| {
        measurement.tool.is_none() && measurement.metric == limit.metric
    };
    let value = measurements.iter().find(of_run).map_or(
        MetricValue::NotApplicable(NotApplicable::NotMeasured),
        |measurement| measurement.value.clone(),
    );
    let number = value.number().filter(|value| value.is_finite());
    ScoreRecord {
        limit: limit.clone(),
        unit: definition.unit.to_string(),
        formula: definition.formula.to_string(),
        category: definition.category,
        within: number.map(|value| within(limit, value)),
        points: number.map(|value| points(limit, definition.direction, value)),
        value,
    }
}

/// Whether a finite value keeps a limit.
fn within(limit: &Limit, value: f64) -> bool {
    limit.min.is_none_or(|min| value >= min) && limit.max.is_none_or(|max| value <= max)
}

/// Points of a finite value, 0..100.
fn points(limit: &Limit, direction: Direction, value: f64) -> f64 {
    let fraction = match direction {
        Direction::Range => 1.0 - (value - limit.full).abs() / (limit.zero - limit.full).abs(),
        _ => (value - limit.zero) / (limit.full - limit.zero),
    };
    100.0 * fraction.clamp(0.0, 1.0)
}

fn check(limit: &Limit, direction: Direction) -> Result<(), LimitError> {
    let id = || limit.metric.clone();
    let numbers = [Some(limit.zero), Some(limit.full), limit.min, limit.max];
    if !numbers.into_iter().flatten().all(f64::is_finite) {
        return Err(LimitError::NotFinite(id()));
    }
    match (limit.min, limit.max) {
        (None, None) => return Err(LimitError::Unlimited(id())),
        (Some(min), Some(max)) if min > max => return Err(LimitError::Empty(id())),
        _ => {}
    }
    let rising = match direction {
        Direction::Lower => limit.full < limit.zero,
        Direction::Higher => limit.full > limit.zero,
        Direction::Range => limit.full != limit.zero,
        Direction::Inform => return Err(LimitError::Informative(id())),
    };
    if rising {
        Ok(())
    } else {
        Err(LimitError::Ramp(id()))
    }
}

#[cfg(test)]
mod tests;
