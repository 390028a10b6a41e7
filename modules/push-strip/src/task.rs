//! What is to be done with the tissue at a mark, and how far from it the trainee is.

use crate::cut::Site;
use microsim_sdk::message::Colour;
use microsim_sdk::tissue::{PatchPlace, Ring, colour};
use serde::Deserialize;

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
    /// How tissue stands; `held`: whether every tool of the level has it. `None` for the task `cut`, which does not ask for a place
    /// of the mark.
    pub fn standing(
        &self,
        PatchPlace { depth, place }: PatchPlace,
        held: bool,
    ) -> Option<Standing> {
        match self {
            Self::Push {
                depth: wanted,
                tolerance,
            } => {
                let error = (depth - wanted).abs();
                let holds = error <= *tolerance;
                let colour = match (holds, depth > *wanted) {
                    (true, _) => colour::HOLDING,
                    (false, true) => colour::TOO_FAR,
                    (false, false) => colour::CURRENT,
                };
                Some(Standing {
                    error,
                    holds,
                    colour,
                })
            }
            Self::Hold(ring) => {
                let error = ring.away(place);
                let holds = held && error <= ring.opening;
                let colour = match holds {
                    true => colour::HOLDING,
                    false => colour::CURRENT,
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
