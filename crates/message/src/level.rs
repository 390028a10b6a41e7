//! The state of a level and its result.

use crate::wire::Message;
use microsim_vocabulary::{LocalText, Overflow};
use serde::{Deserialize, Serialize};

/// What the operator (or the host) asks of the running module. An external input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LevelControl {
    /// Leave the introduction and begin.
    Start,
    /// Stop the level's clock.
    Pause,
    /// Go on after a pause.
    Resume,
    /// All sources have ended: evaluate what there is.
    InputEnded,
    /// End without a verdict on the trainee.
    Abort,
}

impl Message for LevelControl {
    const KIND: &'static str = "level.control";
}

/// Phase of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LevelPhase {
    /// The task is shown.
    #[default]
    Introduction,
    /// The trainee works.
    Running,
    /// The level's clock stands.
    Paused,
    /// Ended, passed.
    Passed,
    /// Ended, failed.
    Failed,
    /// Ended without a verdict.
    NotJudged,
}

/// State of the level; published whenever it changes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LevelState {
    /// Phase.
    pub phase: LevelPhase,
    /// Running time, pauses not counted \[s\].
    pub running: f64,
    /// Targets reached.
    pub targets_done: u32,
    /// Targets of the level.
    pub targets: u32,
}

impl Message for LevelState {
    const KIND: &'static str = "level.state";
    const OVERFLOW: Overflow = Overflow::DropOldest;
}

/// Something worth a line in the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelEvent {
    /// Id, for example `target-done`.
    pub id: String,
    /// Running time of the level \[s\].
    pub time: f64,
    /// One sentence.
    pub text: LocalText,
}

impl Message for LevelEvent {
    const KIND: &'static str = "level.event";
}

/// The limit of a metric in this level, in the metric's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LimitRecord {
    /// Smallest value that passes.
    pub min: Option<f64>,
    /// Largest value that passes.
    pub max: Option<f64>,
    /// Where the limit comes from.
    pub source: String,
    /// Whether it is not backed by a source yet.
    pub provisional: bool,
    /// Whether a value beyond it stands against a pass; otherwise it is a reference value. Sessions of before 2026-11-24 have none but limits that decide.
    #[serde(default = "decides")]
    pub decides: bool,
}

fn decides() -> bool {
    true
}

/// One metric of a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MetricRecord {
    /// Id, for example `path-length`.
    pub id: String,
    /// Name for people.
    pub title: LocalText,
    /// SI unit of `value` and the limits.
    pub unit: String,
    /// Unit to show.
    pub display_unit: String,
    /// Shown value = `value` × this.
    pub display_factor: f64,
    /// `lower-is-better`, `higher-is-better` or `informative`.
    pub direction: String,
    /// Id of the score category.
    pub category: String,
    /// Id of the formula, for example `path-length/1`.
    pub formula: String,
    /// Where the definition comes from.
    pub source: String,
    /// What to do better.
    pub advice: LocalText,
    /// The value; `None`: not applicable, see `not_applicable`.
    pub value: Option<f64>,
    /// Why there is no value.
    pub not_applicable: Option<LocalText>,
    /// The limit, if the level sets one.
    pub limit: Option<LimitRecord>,
    /// Whether the value is within the limit; `None` without limit or value.
    pub within: Option<bool>,
    /// Score 0…100; `None` without limit or value.
    pub score: Option<f64>,
}

/// Score of one category.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CategoryScore {
    /// Id.
    pub id: String,
    /// Name for people.
    pub title: LocalText,
    /// 0…100.
    pub score: f64,
}

/// The result of a level: the module's last word.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainingResult {
    /// Passed: every target reached, every metric within its limit.
    pub passed: bool,
    /// Ended by the operator.
    pub aborted: bool,
    /// Why there is no verdict; empty where there is one. Then it is not passed, no reason is named, and nothing has points.
    #[serde(default)]
    pub not_judged: Vec<LocalText>,
    /// Ids of the reasons why it failed, exactly those.
    pub failed: Vec<String>,
    /// The reasons in words, in the same order.
    pub reasons: Vec<LocalText>,
    /// Running time \[s\].
    pub duration: f64,
    /// Targets reached.
    pub targets_done: u32,
    /// Targets of the level.
    pub targets: u32,
    /// All metrics.
    pub metrics: Vec<MetricRecord>,
    /// Scores by category.
    pub categories: Vec<CategoryScore>,
    /// Mean of the categories, 0…100; never what a verdict rests on.
    pub score: f64,
}

impl Message for TrainingResult {
    const KIND: &'static str = "training.result";
}
