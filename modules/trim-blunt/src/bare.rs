//! How far the media of the end is bare, and what a level asks of that.

use crate::layers::{ADVENTITIA, MEDIA};
use microsim_sdk::tissue::{FreeLength, VesselWall};
use serde::{Deserialize, Serialize};

/// Directions around the vessel in which it is measured: as many as its section has corners or more.
const DIRECTIONS: usize = 16;

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Keys {
    /// \[m\]
    pub free_length: f64,
    pub evenness: f64,
    /// \[s\]
    pub stay: f64,
    pub injuring_stretch: f64,
}

/// What is bare in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bare {
    /// Mean around the vessel \[m\].
    pub mean: f64,
    /// The least length over the mean, 0 to 1.
    pub evenness: f64,
}

impl Bare {
    /// Of a vessel as it lies; `None` where its media does not reach all round.
    pub fn of(wall: &VesselWall<'_>) -> Option<Self> {
        let lengths = FreeLength::of(wall, MEDIA, ADVENTITIA, DIRECTIONS)?;
        Some(Self {
            mean: lengths.mean(),
            evenness: lengths.evenness(),
        })
    }

    /// Whether it is what the level asks for.
    pub fn suffices(&self, keys: &Keys) -> bool {
        self.mean >= keys.free_length && self.evenness >= keys.evenness
    }

    /// Why the end was not bare for long enough; `reached` is whether it was at any time.
    pub fn reason(&self, keys: &Keys, reached: bool) -> &'static str {
        if reached {
            "not-left"
        } else if self.mean < keys.free_length {
            "not-bare"
        } else {
            "uneven"
        }
    }
}
