//! `config/host.toml`: how the host runs sessions, whatever is trained.

use crate::document::{Loaded, Reading, load_text};
use crate::error::ConfigErrors;
use crate::schema::{Key, Kind, Schema};
use microsim_vocabulary::{Language, Unit};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// How the host runs sessions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Host {
    /// What is written of a session.
    pub session: SessionSettings,
    /// What is drawn of a session.
    pub picture: PictureSettings,
    /// The page of a session.
    pub report: ReportSettings,
    /// What happens when the machine is too slow.
    pub late: LateSettings,
    /// The queues of the bus.
    pub queue: QueueSettings,
}

/// What is written of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionSettings {
    /// Folder of the session files, seen from the root of the installation.
    pub directory: String,
    /// Simulated time between two hashes of the whole state \[s\].
    pub state_hash_every: f64,
}

/// What is drawn of a session.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureSettings {
    /// Pictures per simulated second \[Hz\].
    pub rate: f64,
    /// Width \[px\].
    pub width: u32,
    /// Height \[px\].
    pub height: u32,
}

/// The page that is written of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportSettings {
    /// The language in which it opens.
    pub language: Language,
    /// Whether a run draws the key moments into it, where there is a graphics driver.
    pub pictures: bool,
}

/// What happens in real time when ticks come late.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LateSettings {
    /// A tick that begins later than this is counted as late \[s\].
    pub tolerance: f64,
    /// Behind by more than this, the schedule moves instead of catching up \[s\].
    pub give_up: f64,
}

/// The queues of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QueueSettings {
    /// Messages that a queue holds.
    pub messages: u32,
    /// Bytes that a queue holds.
    pub bytes: u32,
}

/// The schema of the host's file.
pub fn host_schema() -> Schema {
    let time = |min, max| Kind::quantity(Unit::Time, min, max);
    let pixels = || Kind::Integer { min: 16, max: 8192 };
    let session = vec![
        Key::with_default(
            "directory",
            Kind::Text,
            "Folder of the session files, seen from the root of the installation.",
            "sessions",
        ),
        Key::with_default(
            "state_hash_every",
            time(0.001, 60.0),
            "Simulated time between two hashes of the whole state.",
            0.25,
        ),
    ];
    let picture = vec![
        Key::with_default(
            "rate",
            Kind::quantity(Unit::Frequency, 0.1, 240.0),
            "Pictures per simulated second.",
            1.0,
        ),
        Key::with_default("width", pixels(), "Width in pixels.", 800),
        Key::with_default("height", pixels(), "Height in pixels.", 800),
    ];
    let report = vec![
        Key::with_default(
            "language",
            Kind::choice(&Language::NAMES),
            "Language in which the page opens; the reader may switch.",
            "en",
        ),
        Key::with_default(
            "pictures",
            Kind::Bool,
            "Whether `microsim run` draws the key moments into the page, where there is a graphics driver.",
            true,
        ),
    ];
    let late = vec![
        Key::with_default(
            "tolerance",
            time(0.0001, 1.0),
            "A tick that begins later than this is counted as late.",
            0.002,
        ),
        Key::with_default(
            "give_up",
            time(0.01, 60.0),
            "Behind by more than this, the schedule moves instead of catching up.",
            0.25,
        ),
    ];
    let queue = vec![
        Key::with_default(
            "messages",
            Kind::Integer {
                min: 16,
                max: 1_000_000,
            },
            "Messages that the queue of one plugin holds.",
            4096,
        ),
        Key::with_default(
            "bytes",
            Kind::Integer {
                min: 65_536,
                max: 1 << 30,
            },
            "Bytes that the queue of one plugin holds.",
            4 << 20,
        ),
    ];
    Schema {
        name: "host".to_owned(),
        doc: "config/host.toml: how the host runs sessions, whatever is trained.".to_owned(),
        keys: vec![
            Key::table("session", session, "What is written of a session."),
            Key::table("picture", picture, "What is drawn of a session."),
            Key::table("report", report, "The page that is written of a session."),
            Key::table(
                "late",
                late,
                "What happens in real time when ticks come late.",
            ),
            Key::table("queue", queue, "The queues of the bus."),
        ],
    }
}

/// Reads the host's file from a text; `file` is the name that complaints use.
pub fn read_host(text: &str, file: &str) -> Result<Loaded<Host>, ConfigErrors> {
    Reading::new(text, file, &host_schema())?.finish()
}

/// Reads the host's file at `path`.
pub fn load_host(path: &Path) -> Result<Loaded<Host>, ConfigErrors> {
    let text = load_text(path, "the settings of the host (config/host.toml)")?;
    read_host(&text, &path.display().to_string())
}
