//! What the host gives a plugin at the start, and the small services that travel as messages.

use crate::wire::{DecodeError, Message};
use microsim_vocabulary::{LocalText, Overflow};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// A file of the plugin's own, by the name in its manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetupFile {
    /// Name in the manifest (or in the run, for an input file).
    pub name: String,
    /// Content.
    #[serde(with = "serde_bytes")]
    pub bytes: Vec<u8>,
}

/// All that a plugin is given before it starts. Equal set-ups and equal messages give equal runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// Name of the plugin.
    pub name: String,
    /// Seed of the run; named random streams derive from it.
    pub seed: u64,
    /// Length of a tick \[ns\].
    pub tick_ns: u64,
    /// Solver steps per tick.
    pub steps: u32,
    /// Number of the level, from 1.
    pub level: u32,
    /// The configuration of this kind of plugin, checked and in SI units; [`Setup::configuration`] reads it as the type whose fields are
    /// its keys, all in the crate `settings`:
    ///
    /// | kind | type |
    /// |---|---|
    /// | source of scripts, of recordings | `ScriptConfig`, `RecordingConfig` |
    /// | another source | what its own `plugin.toml` declares, or null |
    /// | translator | `TranslatorConfig` |
    /// | physics | `PhysicsConfig` |
    /// | module | `ModuleConfig` |
    /// | objects | `ObjectsConfig` |
    /// | renderer | `RendererConfig` |
    /// | recorder | `RecorderConfig` |
    pub config: serde_json::Value,
    /// Files of its own.
    pub files: Vec<SetupFile>,
}

impl Setup {
    /// The configuration as the type that host and plugin have in common.
    pub fn configuration<T: DeserializeOwned>(&self) -> Result<T, DecodeError> {
        let read = T::deserialize(&self.config);
        read.map_err(|e| DecodeError(format!("the configuration of \"{}\": {e}", self.name)))
    }
}

/// A configuration as the value of a set-up.
pub fn config_value<T: Serialize>(config: &T) -> serde_json::Value {
    serde_json::to_value(config).expect("plain data")
}

/// Severity of a log line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LogLevel {
    /// The operator must know.
    Error,
    /// The operator should know.
    Warn,
    /// Worth a line.
    Info,
    /// For developers.
    Debug,
}

/// A line for the host's log. Every plugin may publish it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Log {
    /// Severity.
    pub level: LogLevel,
    /// One sentence.
    pub text: String,
}

impl Message for Log {
    const KIND: &'static str = "host.log";
    const OVERFLOW: Overflow = Overflow::DropOldest;
}

/// Progress of long work. Every plugin may publish it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// What is being done.
    pub what: LocalText,
    /// 0…1.
    pub fraction: f64,
}

impl Message for Progress {
    const KIND: &'static str = "host.progress";
    const VERSION: u16 = 2;
    const OVERFLOW: Overflow = Overflow::DropOldest;
}

/// The host asks the renderer for a picture of what it receives in the same call.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureRequest {
    /// File to write, PNG.
    pub file: String,
}

impl Message for PictureRequest {
    const KIND: &'static str = "picture.request";
}

/// One record for the session file, from the host to the recorder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionRecord {
    /// Kind of the record, as the host numbers them.
    pub kind: u8,
    /// Tick it belongs to.
    pub tick: u64,
    /// Content.
    #[serde(with = "serde_bytes")]
    pub bytes: Vec<u8>,
}

impl Message for SessionRecord {
    const KIND: &'static str = "session.record";
}
