//! `config/host.toml`: how the host runs sessions, whatever is trained.

use crate::document::{Loaded, Reading, load_text};
use crate::error::ConfigErrors;
use crate::files::schema_of;
use crate::kinds::{own_defaults, quantity, time};
use crate::table::table;
use microsim_vocabulary::{Language, Unit};
use std::path::Path;

table! {
    /// How the host runs sessions.
    pub struct Host {
        /// What is written of a session.
        session: SessionSettings => own_defaults(),
        /// What is drawn of a session.
        picture: PictureSettings => own_defaults(),
        /// The page that is written of a session.
        report: ReportSettings => own_defaults(),
        /// What happens in real time when ticks come late.
        late: LateSettings => own_defaults(),
        /// The queues of the bus.
        queue: QueueSettings => own_defaults(),
        /// Plugins in a process of their own.
        guest: GuestSettings => own_defaults(),
    }
}

table! {
    /// What is written of a session.
    #[derive(Copy)]
    pub struct SessionSettings {
        /// Simulated time between two hashes of the whole state \[s\].
        state_hash_every: f64 = time(0.001, 60.0) => 0.25,
    }
}

table! {
    /// What is drawn of a session.
    #[derive(Copy)]
    pub struct PictureSettings {
        /// Pictures per simulated second \[Hz\].
        rate: f64 = quantity(Unit::Frequency, 0.1, 240.0) => 1.0,
        /// Width in pixels.
        width: u32 [16, 8192] => 800,
        /// Height in pixels.
        height: u32 [16, 8192] => 800,
    }
}

table! {
    /// The page that is written of a session.
    #[derive(Copy, Eq)]
    pub struct ReportSettings {
        /// Language in which the page opens; the reader may switch.
        language: Language => "en",
        /// Whether `microsim run` draws the key moments into the page, where there is a graphics driver.
        pictures: bool => true,
    }
}

table! {
    /// What happens in real time when ticks come late.
    #[derive(Copy)]
    pub struct LateSettings {
        /// A tick that begins later than this is counted as late \[s\].
        tolerance: f64 = time(0.0001, 1.0) => 0.002,
        /// Behind by more than this, the schedule moves instead of catching up \[s\].
        give_up: f64 = time(0.01, 60.0) => 0.25,
    }
}

table! {
    /// The queues of the bus.
    #[derive(Copy)]
    pub struct QueueSettings {
        /// Messages that the queue of one plugin holds.
        messages: u32 [16, 1_000_000] => 4096,
        /// Bytes that the queue of one plugin holds.
        bytes: u32 [65_536, 1 << 30] => 4 << 20,
    }
}

table! {
    /// Plugins in a process of their own.
    #[derive(Copy)]
    pub struct GuestSettings {
        /// A guest that does not answer a call for longer is killed \[s\].
        deadline: f64 = time(0.01, 60.0) => 0.8,
        /// Most memory that a guest may map \[MiB\].
        memory: u32 [64, 1 << 20] => 512,
    }
}

/// Reads the host's file from a text; `file` is the name that complaints use.
pub fn read_host(text: &str, file: &str) -> Result<Loaded<Host>, ConfigErrors> {
    Reading::new(text, file, &schema_of::<Host>("host"))?.finish()
}

/// Reads the host's file at `path`.
pub fn load_host(path: &Path) -> Result<Loaded<Host>, ConfigErrors> {
    let text = load_text(path, "the settings of the host (config/host.toml)")?;
    read_host(&text, &path.display().to_string())
}
