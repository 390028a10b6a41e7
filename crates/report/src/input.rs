//! What a report needs besides the messages of the session.

use crate::arrival::TimeSpread;
use crate::text::in_both;
use microsim_message::LocalText;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// What is known of a session besides its messages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReportInput {
    /// Version of MicroSim that ran the session.
    pub version: String,
    /// Wall clock at the start, seconds since 1970.
    pub started: u64,
    /// Who trained.
    pub trainee: Option<String>,
    /// Id of the module.
    pub module: String,
    /// Name of the module.
    pub module_title: LocalText,
    /// Number of the level, from 1.
    pub level: u32,
    /// Name of the level.
    pub level_title: LocalText,
    /// The task in a sentence.
    pub level_summary: LocalText,
    /// Seed of the run.
    pub seed: u64,
    /// Length of a tick \[s\].
    pub tick_s: f64,
    /// Where the input came from, as it was given.
    pub input: String,
    /// What the tools are called, by their slots.
    pub tools: BTreeMap<String, LocalText>,
    /// Slots of the tools with sharp jaws: what they close on is cut, not gripped.
    pub sharp: BTreeSet<String>,
    /// The bodies of the level.
    pub bodies: Vec<String>,
    /// By what a synthetic trainee was made; `None` for all others.
    pub synthetic: Option<String>,
    /// Whether the level was mirrored for a left-handed trainee: where texts have left, it was right.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mirrored: bool,
    /// Relative error of the tissue that the level states as measured; `None` if it states none.
    #[serde(default)]
    pub model_error: Option<f64>,
    /// Files of the level that are not as the installation brought them.
    #[serde(default)]
    pub changed_files: Vec<String>,
    /// Whether ticks were paced by the wall clock.
    pub realtime: bool,
    /// What was left out of the computation; if anything, the run is no result.
    pub without: Vec<String>,
    /// State hash at the end; `None` if there was no clean end.
    pub state_hash: Option<String>,
    /// What is wrong with the session file (cut, damaged), if anything.
    pub complaint: Option<String>,
    /// Plugins that failed, a sentence each.
    pub failures: Vec<String>,
    /// Ticks that began late (paced runs).
    pub late_ticks: u64,
    /// From the begin of a tick to its snapshot (paced runs).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tick_times: Option<TimeSpread>,
    /// Name of the session file.
    pub session_file: String,
    /// The command that replays it.
    pub replay_command: String,
}

impl ReportInput {
    /// That a recorded hand did not try the task, where that is so: a recording that is no session was made elsewhere.
    pub fn foreign_hand(&self) -> Option<LocalText> {
        let recording = self.input.strip_prefix("recording:")?;
        (!recording.contains(".session")).then(|| {
            in_both(
                "Die Bewegung stammt aus einer Aufzeichnung: Wer sie gemacht hat, kannte diese Aufgabe nicht. Das Urteil sagt nichts über diese Hand.",
                "The motion is a recording: whoever made it did not know this task. The verdict says nothing about that hand.",
            )
        })
    }

    /// What the tool of a slot is called: the slot itself if nothing else is known.
    pub fn tool_name(&self, slot: &str) -> LocalText {
        let unnamed = || LocalText::new(slot.to_owned(), slot.to_owned());
        self.tools.get(slot).cloned().unwrap_or_else(unnamed)
    }

    /// What a body is called: tissue, with its name where there are several.
    pub fn body_name(&self, body: &str) -> LocalText {
        match self.bodies.len() {
            0 | 1 => in_both("Gewebe", "tissue"),
            _ => in_both(&format!("Gewebe „{body}“"), &format!("tissue “{body}”")),
        }
    }
}
