//! How far the end is trimmed, and what a level asks of that.

use crate::layers::{ADVENTITIA, MEDIA};
use microsim_sdk::tissue::{FreeLength, VesselWall};
use serde::{Deserialize, Serialize};

/// Directions around the vessel in which it is measured: more than its section has corners.
const DIRECTIONS: usize = 16;

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Keys {
    /// Least bare length of the media that is asked for, in every direction; negative where so much may hang over \[m\].
    pub free_length: f64,
    /// \[s\]
    pub stay: f64,
    pub injuring_stretch: f64,
}

/// The end of the vessel in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trimmed {
    /// Least bare length of all directions; negative where adventitia hangs over the end \[m\].
    pub least: f64,
}

impl Trimmed {
    /// Of a vessel as it lies; `None` where its media does not reach all round.
    pub fn of(wall: &VesselWall<'_>) -> Option<Self> {
        let lengths = FreeLength::of(wall, MEDIA, ADVENTITIA, DIRECTIONS)?;
        Some(Self {
            least: lengths.least(),
        })
    }

    /// How far adventitia hangs over the end, where it does so farthest \[m\].
    pub fn overhang(&self) -> f64 {
        (-self.least).max(0.0)
    }

    /// Whether it is what the level asks for.
    pub fn suffices(&self, keys: &Keys) -> bool {
        self.least >= keys.free_length
    }

    /// Why the level is not done with the end as it is.
    pub fn reason(&self, keys: &Keys) -> &'static str {
        if self.suffices(keys) {
            "not-left"
        } else if self.least < keys.free_length.min(0.0) {
            "overhang-left"
        } else {
            "drawn-too-little"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level that lets 0.1 mm hang over, and one that asks for 0.1 mm of bare media.
    #[test]
    fn what_hangs_over_and_what_is_not_bare_are_different_reasons() {
        let end = |least: f64| Trimmed { least };
        let keys = |free_length: f64| Keys {
            free_length,
            stay: 1.0,
            injuring_stretch: 1.3,
        };
        let lenient = keys(-1e-4);
        assert_eq!(end(-2e-4).reason(&lenient), "overhang-left");
        assert_eq!(end(-1e-4).reason(&lenient), "not-left");
        let strict = keys(1e-4);
        assert_eq!(end(-1e-5).reason(&strict), "overhang-left");
        assert_eq!(end(0.5e-4).reason(&strict), "drawn-too-little");
        assert_eq!(end(1e-4).reason(&strict), "not-left");
        assert_eq!((end(-2e-4).overhang(), end(2e-4).overhang()), (2e-4, 0.0));
    }
}
