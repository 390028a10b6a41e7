//! What evolves in a level besides its [`microsim_sdk::LevelRun`].

use microsim_sdk::Fault;
use microsim_sdk::message::Colour;
use microsim_sdk::tissue::{Contacts, CutLog, Delivery, Grasp, Patch, Probes, Releases, colour};
use microsim_training::Dwell;
use serde::{Deserialize, Serialize};

/// What evolves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Where each tool of the level was first tracked \[m\].
    pub(crate) starts: Vec<Option<[f64; 3]>>,
    /// The tissue at both ends of each mark; empty before there is tissue.
    pub(crate) patches: Vec<[Patch; 2]>,
    pub(crate) probes: Probes,
    pub(crate) contacts: Contacts,
    pub(crate) grasp: Grasp,
    pub(crate) cuts: CutLog,
    /// Whether the event of a grip that goes on has been published, and what detects its end.
    pub(crate) grip_told: bool,
    pub(crate) grip_ends: Releases,
    pub(crate) hold: Hold,
    /// Whether the piece between the marks is off, and how far it has come to the tray.
    pub(crate) off: bool,
    pub(crate) delivery: Delivery,
    /// Of the mark in the ring, or of the tray.
    pub(crate) colour: Colour,
}

/// What evolves in the task `hold`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Hold {
    /// Whether all tools that hold have had the tissue since it was last lost, and how often it was.
    pub had: bool,
    pub drops: Releases,
    /// Whether the mark has counted as held at any time.
    pub reached: bool,
    /// Whether the mark has been in the ring without being held.
    pub loose: bool,
    /// Number of ticks and sum of distances from the middle of the ring \[m\], over all holding that counted.
    pub counted: (u64, f64),
    pub dwell: Dwell,
}

impl State {
    /// Before the first tick; what is held must be held for `dwell` \[s\].
    pub(crate) fn new(dwell: f64) -> Result<Self, Fault> {
        Ok(Self {
            starts: Vec::new(),
            patches: Vec::new(),
            probes: Probes::default(),
            contacts: Contacts::default(),
            grasp: Grasp::default(),
            cuts: CutLog::default(),
            grip_told: false,
            grip_ends: Releases::default(),
            hold: Hold {
                had: false,
                drops: Releases::default(),
                reached: false,
                loose: false,
                counted: (0, 0.0),
                dwell: Dwell::new(dwell)?,
            },
            off: false,
            delivery: Delivery::new(dwell)?,
            colour: colour::WAITING,
        })
    }
}
