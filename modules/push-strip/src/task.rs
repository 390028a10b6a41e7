//! What is to be done with the tissue at a mark, and how far from it the trainee is.

use crate::cut::Site;
use microsim_sdk::message::Colour;
use serde::Deserialize;

pub(crate) const WAITING: Colour = [0.55, 0.58, 0.60];
pub(crate) const CURRENT: Colour = [0.95, 0.50, 0.10];
pub(crate) const HOLDING: Colour = [0.98, 0.85, 0.15];
pub(crate) const TOO_FAR: Colour = [0.85, 0.12, 0.12];
pub(crate) const DONE: Colour = [0.20, 0.70, 0.25];

/// The level's keys of this module.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Keys {
    pub task: TaskName,
    /// \[m\]
    pub depth: f64,
    /// \[m\]
    pub depth_tolerance: f64,
    /// \[s\]
    pub dwell: f64,
    /// \[m\]
    pub mark_radius: f64,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum TaskName {
    /// Push every mark in turn to a depth and hold it there.
    Push,
    /// Bring the marked tissue into the ring, with every tool of the level on it, and hold it there.
    Hold,
    /// Cut the strip at the mark and put what comes off into the tray.
    Cut,
}

/// The ring of the level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ring {
    /// \[m\]
    pub centre: [f64; 3],
    /// Of its opening \[m\].
    pub opening: f64,
}

/// The task of a level.
#[derive(Clone, Debug)]
pub(crate) enum Task {
    /// See [`TaskName::Push`].
    Push {
        /// \[m\]
        depth: f64,
        /// \[m\]
        tolerance: f64,
    },
    /// See [`TaskName::Hold`].
    Hold(Ring),
    /// See [`TaskName::Cut`].
    Cut(Site),
}

/// How the marked tissue stands to its task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Standing {
    /// Distance from what is asked for \[m\].
    pub error: f64,
    /// Whether it counts.
    pub holds: bool,
    /// What the mark shows.
    pub colour: Colour,
}

impl Task {
    /// How tissue stands whose deepest node is `depth` \[m\] below where it lay and whose middle is `place` \[m\]; `held` tells whether
    /// every tool of the level has it. `None` for the task `cut`, which does not ask for a place of the mark.
    pub fn standing(&self, depth: f64, place: [f64; 3], held: bool) -> Option<Standing> {
        match self {
            Self::Push {
                depth: wanted,
                tolerance,
            } => {
                let error = (depth - wanted).abs();
                let holds = error <= *tolerance;
                let colour = match (holds, depth > *wanted) {
                    (true, _) => HOLDING,
                    (false, true) => TOO_FAR,
                    (false, false) => CURRENT,
                };
                Some(Standing {
                    error,
                    holds,
                    colour,
                })
            }
            Self::Hold(ring) => {
                let error = distance(place, ring.centre);
                let holds = held && error <= ring.opening;
                let colour = match holds {
                    true => HOLDING,
                    false => CURRENT,
                };
                Some(Standing {
                    error,
                    holds,
                    colour,
                })
            }
            Self::Cut(_) => None,
        }
    }
}

/// Between two places \[m\].
pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    (x * x + y * y + z * z).sqrt()
}
