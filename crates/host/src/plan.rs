//! What a run loads and computes, and why: decided before anything is loaded.

pub use microsim_vocabulary::PluginKind;

use crate::guest::GuestRules;
use microsim_bus::{KindInfo, Limits};
use microsim_message::{DecodeError, LocalText, Setup, config_value};
use microsim_settings::{DebugView, LevelPart, RendererConfig};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A message kind that a plugin brings, as plain data.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct OwnKind {
    /// Name.
    pub name: String,
    /// Version of the payload.
    pub version: u16,
    /// Whether a full queue drops the oldest (otherwise it refuses).
    pub drop_oldest: bool,
}

impl OwnKind {
    /// As the bus wants it.
    pub fn info(&self) -> KindInfo {
        KindInfo {
            name: self.name.clone(),
            version: self.version,
            overflow: if self.drop_oldest {
                microsim_bus::Overflow::DropOldest
            } else {
                microsim_bus::Overflow::Refuse
            },
        }
    }
}

/// In which process a plugin runs; the installation decides it, never a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Hosting {
    /// In the host's.
    #[default]
    Inside,
    /// In the host's, once a process of its own has opened the library: nobody has vouched for the file.
    TriedFirst(GuestRules),
    /// In a process of its own.
    Guest(GuestRules),
}

impl Hosting {
    /// Drops what a guest prints.
    pub fn silence(&mut self) {
        if let Self::TriedFirst(rules) | Self::Guest(rules) = self {
            rules.silent = true;
        }
    }

    /// Waits for a guest as long as it takes: whether it was too slow is decided in a run, and recorded.
    pub fn lift_deadline(&mut self) {
        if let Self::TriedFirst(rules) | Self::Guest(rules) = self {
            rules.deadline = None;
        }
    }

    /// Whether it has a process of its own.
    pub fn is_guest(&self) -> bool {
        matches!(self, Self::Guest(_))
    }
}

/// One plugin of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedPlugin {
    /// Unique name.
    pub name: String,
    /// Kind.
    pub kind: PluginKind,
    /// Version.
    pub version: String,
    /// Topics that it publishes.
    pub publishes: Vec<String>,
    /// Topics that it subscribes to.
    pub subscribes: Vec<String>,
    /// Message kinds that it brings.
    pub own_kinds: Vec<OwnKind>,
    /// The library file.
    pub library: PathBuf,
    /// The manifest's text beside the library.
    pub manifest: String,
    /// Digest of the library file, hexadecimal.
    pub library_hash: String,
    /// Why it is loaded, one sentence.
    pub why: String,
    /// What it is given.
    pub setup: Setup,
    /// In which process it runs.
    #[serde(skip)]
    pub hosting: Hosting,
}

/// A line of `--explain` that is not a plugin: a body, an object, a contact pair, a method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedPart {
    /// `body`, `object`, `rigid`, `contact`, `cut`, `method`, `step`, `tool`.
    pub what: String,
    /// Its name.
    pub name: String,
    /// Why, one sentence.
    pub why: String,
}

impl From<LevelPart> for PlannedPart {
    fn from(part: LevelPart) -> Self {
        Self {
            what: part.what.to_owned(),
            name: part.name,
            why: part.why,
        }
    }
}

/// All that a run loads and computes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunPlan {
    /// Module.
    pub module: String,
    /// Its title.
    pub module_title: LocalText,
    /// Number of the level, from 1.
    pub level: u32,
    /// Variant of the level that is run; `None` for the level itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variant: Option<String>,
    /// Its title.
    pub level_title: LocalText,
    /// What the level asks for.
    pub level_summary: LocalText,
    /// Seed of the run.
    pub seed: u64,
    /// Length of a tick \[ns\].
    pub tick_ns: u64,
    /// Solver steps per tick.
    pub steps: u32,
    /// Ticks between two state hashes.
    pub hash_every: u64,
    /// What the input is, as the operator gave it.
    pub input: String,
    /// By what a synthetic trainee was made; `None` for all other input.
    #[serde(default)]
    pub synthetic: Option<String>,
    /// Digest of what the source is given, hexadecimal: a checkpoint belongs to its input.
    pub input_digest: String,
    /// Messages that the queue of one plugin holds.
    pub queue_messages: u32,
    /// Bytes that the queue of one plugin holds.
    pub queue_bytes: u32,
    /// Relative error of the tissue that the level states as measured; `None` if it states none, or without physics.
    #[serde(default)]
    pub model_error: Option<f64>,
    /// Files of the level that are not as the installation brought them: the task is another one than that of this name.
    #[serde(default)]
    pub changed_files: Vec<String>,
    /// Kinds that were left out on purpose; such a run is no result.
    pub without: Vec<String>,
    /// Plugins in the order of a tick.
    pub plugins: Vec<PlannedPlugin>,
    /// Everything else.
    pub parts: Vec<PlannedPart>,
}

impl PlannedPlugin {
    /// Lays these over the pictures of a renderer, in the place of those that it was given.
    ///
    /// # Errors
    /// If it is none.
    pub fn show(&mut self, views: &[DebugView]) -> Result<(), DecodeError> {
        let mut config: RendererConfig = self.setup.configuration()?;
        config.views = views.to_vec();
        self.setup.config = config_value(&config);
        Ok(())
    }
}

impl RunPlan {
    /// Bounds of the bus queues: part of the plan, because they decide what is lost.
    pub fn limits(&self) -> Limits {
        Limits {
            messages: self.queue_messages as usize,
            bytes: self.queue_bytes as usize,
        }
    }

    /// Whether ticks wait for a peer whose clock decides (`clock` of config/openigtlink.toml), and not for that of this machine.
    pub fn waits_for_peer(&self) -> bool {
        let mut sources = self.plugins.iter().filter(|p| p.kind == PluginKind::Source);
        sources.any(|p| p.setup.config["clock"] == "device")
    }

    /// Whether the run counts as a result of the trainee.
    pub fn counts(&self) -> bool {
        self.without.is_empty()
    }
}
