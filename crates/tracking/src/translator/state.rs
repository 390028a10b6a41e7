//! What the translator stores of each tool, and what it reports of it.

use std::error::Error;
use std::fmt;

use microsim_message::ToolPose;
use microsim_vocabulary::ToolStatus;
use serde::{Deserialize, Serialize};

use super::hand::{Excess, HandLimits};
use super::mapping::Mapping;
use super::plausible::{Assessment, Plausible};
use super::track::Point;

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
    /// When the last sample arrived that counts, so `[s]`.
    last_valid_s: Option<f64>,
    /// Whether the tool is at its last valid pose as far as is known: no sample since then has denied it.
    seen: bool,
    /// Since when the status that `seen` stands for has held, in the session's time `[s]`.
    since_s: f64,
    refused: u64,
    implausible: u64,
    plausible: Plausible,
}

impl TranslatorState {
    pub(super) fn new(mappings: &[Mapping]) -> Self {
        let tools = mappings
            .iter()
            .map(|mapping| TrackedTool {
                tool: mapping.tool.clone(),
                pose: None,
                last_arrival_s: None,
                last_valid_s: None,
                seen: false,
                since_s: 0.0,
                refused: 0,
                implausible: 0,
                plausible: Plausible::default(),
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

    /// Number of samples refused so far, as their values are no pose.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Number of samples left out so far, as no hand makes them.
    pub fn implausible(&self) -> u64 {
        self.implausible
    }

    /// The last opening; open before any.
    pub(super) fn opening(&self) -> f64 {
        self.pose.map_or(1.0, |pose| pose.opening)
    }

    /// Records the arrival of a sample, and by `change` its contents.
    pub(super) fn arrived<T>(
        &mut self,
        now_s: f64,
        stale_after_s: f64,
        change: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let before = self.status(now_s, stale_after_s);
        let since_s = self.since(now_s, stale_after_s);
        self.last_arrival_s = Some(now_s);
        let changed = change(self);
        let is_same = self.status(now_s, stale_after_s) == before;
        self.since_s = if is_same { since_s } else { now_s };
        changed
    }

    /// A visible sample: it counts, and the tool has the pose of it, or by how much it is beyond the limits of a hand.
    pub(super) fn see(
        &mut self,
        point: Point,
        now_s: f64,
        hand: &HandLimits,
        pose: impl FnOnce() -> ToolPose,
    ) -> Option<Excess> {
        match self.plausible.assess(point, now_s, hand) {
            Assessment::Counts => {
                self.seen = true;
                self.last_valid_s = Some(now_s);
                self.pose = Some(pose());
                None
            }
            Assessment::LeftOut(excess) => {
                self.implausible += 1;
                Some(excess)
            }
            Assessment::Lost(excess) => {
                self.seen = false;
                self.implausible += 1;
                Some(excess)
            }
        }
    }

    /// Whether it is at its last pose as far as is known.
    pub(super) fn is_seen(&self) -> bool {
        self.seen
    }

    pub(super) fn lose(&mut self) {
        self.seen = false;
        self.plausible.interrupt();
    }

    pub(super) fn refuse(&mut self) {
        self.lose();
        self.refused += 1;
    }

    /// When the status that it has at `now_s` began.
    pub(super) fn since(&self, now_s: f64, stale_after_s: f64) -> f64 {
        let too_long = |since_s: Option<f64>| since_s.map(|since_s| since_s + stale_after_s);
        let since_s = match self.status(now_s, stale_after_s) {
            ToolStatus::Stale => too_long(self.last_arrival_s),
            // No sample has denied the last pose, but none has confirmed it for too long.
            ToolStatus::Occluded if self.seen => too_long(self.last_valid_s),
            _ => None,
        };
        since_s.unwrap_or(self.since_s)
    }

    pub(super) fn status(&self, now_s: f64, stale_after_s: f64) -> ToolStatus {
        let is_old = |arrival_s: Option<f64>| {
            arrival_s.is_some_and(|arrival_s| now_s - arrival_s > stale_after_s)
        };
        match self.pose {
            None => ToolStatus::NeverSeen,
            Some(_) if is_old(self.last_arrival_s) => ToolStatus::Stale,
            Some(_) if self.seen && !is_old(self.last_valid_s) => ToolStatus::Tracked,
            Some(_) => ToolStatus::Occluded,
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
