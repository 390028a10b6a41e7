//! The report as data.

use crate::arrival::ArrivalRecord;
use crate::implausible::ImplausibleRecord;
use crate::input::ReportInput;
use crate::marker::MarkerRecord;
use crate::solver::SolverRecord;
use crate::text::in_both;
use crate::{DeviceRecord, ForceSeries, Moment, ToolPresence, ToolSeries};
use microsim_message::{CategoryScore, LevelPhase, LocalText, LogLevel, MetricRecord};
use serde::{Deserialize, Serialize};

/// How a session ended for the trainee.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// By the verdict of the module.
    Passed,
    /// By the verdict of the module, with reasons.
    Failed,
    /// Without a verdict: what was computed or measured is no ground for one.
    NotJudged,
    /// Ended by the operator.
    Aborted,
    /// The module gave no result: the run was killed or a plugin failed.
    Incomplete,
}

/// All that a report shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of these fields: 1.
    pub format: u32,
    /// What is known of the session.
    pub session: ReportInput,
    /// How it ended.
    pub verdict: Verdict,
    /// Whether the verdict counts: it is passed or failed, and nothing was left out of the computation.
    pub counts: bool,
    /// Ids of the reasons why it failed, exactly those of the module's result.
    pub failed: Vec<String>,
    /// The reasons in words, in the order of `failed`; of a run that was not judged, why.
    pub reasons: Vec<LocalText>,
    /// Running time of the level, pauses not counted \[s\]; without a result as far as is known.
    pub duration: f64,
    /// Simulated time of all ticks \[s\].
    pub simulated: f64,
    /// Last known phase of the level.
    pub phase: LevelPhase,
    /// Targets reached.
    pub targets_done: u32,
    /// Targets of the level.
    pub targets: u32,
    /// Mean of the categories, 0…100; `None` without a result.
    pub score: Option<f64>,
    /// Scores by category.
    pub categories: Vec<CategoryScore>,
    /// All metrics of the result.
    pub metrics: Vec<MetricEntry>,
    /// The raw input, device by device.
    pub input: Vec<DeviceRecord>,
    /// How samples of live trackers came; `None` where none was live.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrivals: Option<ArrivalRecord>,
    /// What the markers of instruments have shown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub markers: Vec<MarkerRecord>,
    /// Samples that no hand makes, of each tool that had any; they were left out.
    #[serde(default)]
    pub implausible: Vec<ImplausibleRecord>,
    /// How long each tool was tracked.
    pub presence: Vec<ToolPresence>,
    /// Motion of each tool in the field.
    pub series: Vec<ToolSeries>,
    /// Contact force of each tool on each body that it touched.
    pub forces: Vec<ForceSeries>,
    /// Events of the module.
    pub events: Vec<EventRecord>,
    /// What happened, in the order of time: the module's events, and what the messages of tissue and contact show.
    pub moments: Vec<Moment>,
    /// How far the solver of the tissue came; `None` where it published nothing.
    #[serde(default)]
    pub solver: Option<SolverRecord>,
    /// Bodies that diverged and were computed again.
    pub recoveries: Vec<RecoveryRecord>,
    /// Warnings and errors of the plugins, and messages that could not be read.
    pub warnings: Vec<Warning>,
}

impl Report {
    /// A sentence for beside the verdict, if there were samples that no hand makes.
    pub fn left_out(&self) -> Option<LocalText> {
        let samples: u64 = self.implausible.iter().map(|record| record.samples).sum();
        if samples == 0 {
            return None;
        }
        let records = self.implausible.iter();
        let words = records.map(|record| record.words(&self.session));
        let (de, en): (Vec<_>, Vec<_>) = words.map(|words| (words.de, words.en)).unzip();
        let (de, en) = (de.join("; "), en.join("; "));
        Some(match samples {
            1 => in_both(
                &format!(
                    "Der Tracker meldete einen Messwert, den keine Hand macht; er wurde weggelassen ({de})."
                ),
                &format!(
                    "The tracker reported 1 sample that no hand makes; it was left out ({en})."
                ),
            ),
            n => in_both(
                &format!(
                    "Der Tracker meldete {n} Messwerte, die keine Hand macht; sie wurden weggelassen ({de})."
                ),
                &format!(
                    "The tracker reported {n} samples that no hand makes; they were left out ({en})."
                ),
            ),
        })
    }
}

/// A metric of the result, with its numbers in the unit that people read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MetricEntry {
    /// As the module gave it; value and limit in the SI unit.
    #[serde(flatten)]
    pub record: MetricRecord,
    /// Value in `display_unit`.
    pub display_value: Option<f64>,
    /// Smallest value that passes, in `display_unit`.
    pub display_min: Option<f64>,
    /// Largest value that passes, in `display_unit`.
    pub display_max: Option<f64>,
}

impl From<MetricRecord> for MetricEntry {
    fn from(record: MetricRecord) -> Self {
        let shown = |value: Option<f64>| value.map(|value| value * record.display_factor);
        let limit = record.limit.as_ref();
        Self {
            display_value: shown(record.value),
            display_min: shown(limit.and_then(|limit| limit.min)),
            display_max: shown(limit.and_then(|limit| limit.max)),
            record,
        }
    }
}

/// An event of the level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EventRecord {
    /// Id, for example `target-done`.
    pub id: String,
    /// Running time of the level \[s\].
    pub time: f64,
    /// Simulated time since the session began \[s\].
    pub session_time: f64,
    /// One sentence.
    pub text: LocalText,
}

/// A body diverged, was rolled back and computed again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecoveryRecord {
    /// Simulated time since the session began \[s\].
    pub session_time: f64,
    /// Body.
    pub body: String,
    /// What was wrong.
    pub cause: String,
    /// Sub-steps of the tick that worked.
    pub substeps: u32,
}

/// A line that the operator should know; equal lines are one with a count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Warning {
    /// Simulated time since the session began, of the first one \[s\].
    pub session_time: f64,
    /// `error` or `warn`.
    pub level: LogLevel,
    /// One sentence.
    pub text: String,
    /// How often.
    pub count: u64,
}
