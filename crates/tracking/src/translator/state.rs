//! What the translator stores of each tool, and what it reports of it.

use std::error::Error;
use std::fmt;

use microsim_message::ToolPose;
use microsim_vocabulary::ToolStatus;
use serde::{Deserialize, Serialize};

use super::Mapping;

/// All that a translator remembers, to be saved and restored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TranslatorState {
    pub(super) tools: Vec<TrackedTool>,
}

/// A saved state does not belong to this translator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateMismatch {
    /// The tools of the translator.
    pub expected: Vec<String>,
    /// The tools of the saved state.
    pub found: Vec<String>,
}

/// A tool, as its samples up to now leave it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackedTool {
    tool: String,
    pose: Option<ToolPose>,
    /// When the last sample of any sort arrived, in the session's time `[s]`.
    last_arrival_s: Option<f64>,
    /// Whether that sample was valid.
    seen: bool,
    /// Since when the status that `seen` stands for has held, in the session's time `[s]`.
    since_s: f64,
    refused: u64,
}

impl TranslatorState {
    pub(super) fn new(mappings: &[Mapping]) -> Self {
        let tools = mappings
            .iter()
            .map(|mapping| TrackedTool {
                tool: mapping.tool.clone(),
                pose: None,
                last_arrival_s: None,
                seen: false,
                since_s: 0.0,
                refused: 0,
            })
            .collect();
        Self { tools }
    }

    pub(super) fn check(&self, mappings: &[Mapping]) -> Result<(), StateMismatch> {
        let expected: Vec<String> = mappings
            .iter()
            .map(|mapping| mapping.tool.clone())
            .collect();
        let found: Vec<String> = self
            .tools
            .iter()
            .map(|memory| memory.tool.clone())
            .collect();
        if expected == found {
            Ok(())
        } else {
            Err(StateMismatch { expected, found })
        }
    }
}

impl TrackedTool {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.tool
    }

    /// Its last valid pose; `None` exactly if it was never seen.
    pub fn pose(&self) -> Option<ToolPose> {
        self.pose
    }

    /// Number of samples refused so far.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// The last opening; open before any.
    pub(super) fn opening(&self) -> f64 {
        self.pose.map_or(1.0, |pose| pose.opening)
    }

    /// Records the arrival of a sample, and by `change` its contents.
    pub(super) fn arrived(
        &mut self,
        now_s: f64,
        stale_after_s: f64,
        change: impl FnOnce(&mut Self),
    ) {
        let before = self.status(now_s, stale_after_s);
        self.last_arrival_s = Some(now_s);
        change(self);
        if self.status(now_s, stale_after_s) != before {
            self.since_s = now_s;
        }
    }

    pub(super) fn see(&mut self, pose: ToolPose) {
        self.seen = true;
        self.pose = Some(pose);
    }

    pub(super) fn lose(&mut self) {
        self.seen = false;
    }

    pub(super) fn refuse(&mut self) {
        self.seen = false;
        self.refused += 1;
    }

    /// When the status that it has at `now_s` began.
    pub(super) fn since(&self, now_s: f64, stale_after_s: f64) -> f64 {
        match (self.status(now_s, stale_after_s), self.last_arrival_s) {
            (ToolStatus::Stale, Some(arrival_s)) => arrival_s + stale_after_s,
            _ => self.since_s,
        }
    }

    pub(super) fn status(&self, now_s: f64, stale_after_s: f64) -> ToolStatus {
        let is_stale = self
            .last_arrival_s
            .is_some_and(|arrival_s| now_s - arrival_s > stale_after_s);
        match (self.pose, is_stale, self.seen) {
            (None, _, _) => ToolStatus::NeverSeen,
            (Some(_), true, _) => ToolStatus::Stale,
            (Some(_), false, true) => ToolStatus::Tracked,
            (Some(_), false, false) => ToolStatus::Occluded,
        }
    }
}

impl fmt::Display for StateMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the saved state has the tools [{}], expected [{}]",
            self.found.join(", "),
            self.expected.join(", ")
        )
    }
}

impl Error for StateMismatch {}
