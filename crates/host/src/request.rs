//! What an operator asks for, and why there may be no plan for it.

use microsim_settings::{ConfigErrors, DominantHand};
use std::fmt;
use std::path::PathBuf;

/// Why there is no plan: one or several sentences, each with its file and line where it has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssembleError(pub String);

impl fmt::Display for AssembleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for AssembleError {}

impl From<ConfigErrors> for AssembleError {
    fn from(errors: ConfigErrors) -> Self {
        Self(errors.to_string())
    }
}

pub(crate) fn refuse<T>(text: impl Into<String>) -> Result<T, AssembleError> {
    Err(AssembleError(text.into()))
}

/// Where the motion comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A scripted trainee.
    Script(PathBuf),
    /// A CSV file with its TOML, or a session.
    Recording(PathBuf),
    /// A source plugin by its name, without a file.
    Plugin(String),
    /// A tracker that speaks OpenIGTLink, at HOST:PORT.
    OpenIgtLink(String),
    /// Mouse and keyboard of the window that the run has.
    Desktop,
}

/// The source that speaks OpenIGTLink.
pub(crate) const OPENIGTLINK: &str = "openigtlink";

impl Input {
    /// Whether the motion comes from a tracker, or from mouse and keyboard, while it is made: ticks then have to follow the wall clock.
    pub fn is_tracked_live(&self) -> bool {
        matches!(self, Self::OpenIgtLink(_) | Self::Desktop)
            || matches!(self, Self::Plugin(name) if name == OPENIGTLINK)
    }
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Script(path) => write!(f, "script:{}", path.display()),
            Self::Recording(path) => write!(f, "recording:{}", path.display()),
            Self::Plugin(name) => write!(f, "plugin:{name}"),
            Self::OpenIgtLink(address) => write!(f, "openigtlink://{address}"),
            Self::Desktop => f.write_str("desktop"),
        }
    }
}

/// What an operator asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Module.
    pub module: String,
    /// Level, from 1.
    pub level: u32,
    /// Variant of the level; `None` for the level itself.
    pub variant: Option<String>,
    /// Motion.
    pub input: Input,
    /// The trainee's dominant hand; `None` for that of `translator.toml`.
    pub hand: Option<DominantHand>,
    /// Seed.
    pub seed: u64,
    /// What to leave out: kinds of plugins (`physics`), `friction`, or `lonor`, all cutting; such a run is no result.
    pub without: Vec<String>,
    /// Whether pictures are wanted.
    pub pictures: bool,
    /// The session file to write.
    pub session: PathBuf,
}

impl Request {
    /// Whether something is to be left out.
    pub(crate) fn leaves_out(&self, what: &str) -> bool {
        self.without.iter().any(|without| without == what)
    }
}
