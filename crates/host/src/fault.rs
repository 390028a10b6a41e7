//! A plugin that failed: who, in which call, when, why.

use microsim_abi::{Fault, FaultKind};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A failed call into a plugin. The plugin is not called again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Name of the plugin.
    pub plugin: String,
    /// The call, for example `process`.
    pub call: String,
    /// Tick in which it happened.
    pub tick: u64,
    /// Whether it panicked.
    pub panicked: bool,
    /// Whether something that it needs is missing on this machine.
    pub unavailable: bool,
    /// Whether it ran in a process of its own, which has ended: an input of the run, which a replay reads.
    #[serde(default)]
    pub ended: bool,
    /// Why, one sentence.
    pub text: String,
}

impl Failure {
    /// From what came over the boundary.
    pub fn from_abi(plugin: &str, call: &str, tick: u64, fault: Fault) -> Self {
        Self {
            plugin: plugin.into(),
            call: call.into(),
            tick,
            panicked: fault.kind == FaultKind::Panic,
            unavailable: fault.kind == FaultKind::Unavailable,
            ended: false,
            text: fault.text.into_string(),
        }
    }

    /// A failure that the host itself found.
    pub fn found(plugin: &str, call: &str, tick: u64, text: impl Into<String>) -> Self {
        Self {
            plugin: plugin.into(),
            call: call.into(),
            tick,
            panicked: false,
            unavailable: false,
            ended: false,
            text: text.into(),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let how = match (self.ended, self.panicked) {
            (true, _) => "ended",
            (false, true) => "panicked",
            (false, false) => "failed",
        };
        write!(
            f,
            "plugin \"{}\" {how} in `{}` at tick {}: {}",
            self.plugin, self.call, self.tick, self.text
        )
    }
}

impl std::error::Error for Failure {}
