//! What evolves in a level besides its course.

use microsim_sdk::Fault;
use microsim_sdk::message::Colour;
use microsim_sdk::tissue::{Contacts, CutLog, Drops, Patch, Probes, colour};
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
    pub(crate) cuts: CutLog,
    pub(crate) drops: Drops,
    /// Whether tissue counts as gripped, and what says when it no longer does.
    pub(crate) gripped: bool,
    pub(crate) release: Drops,
    /// Whether all tools that hold have had the tissue since it was last lost.
    pub(crate) had: bool,
    /// Whether the mark has counted as held at any time.
    pub(crate) reached: bool,
    /// Whether the mark has been in the ring without being held.
    pub(crate) loose: bool,
    /// Number of ticks and sum of distances from the middle of the ring \[m\], over all holding that counted.
    pub(crate) counted: (u64, f64),
    /// Whether the piece between the marks is off.
    pub(crate) off: bool,
    /// Whether forceps have had it since.
    pub(crate) carried: bool,
    pub(crate) dwell: Dwell,
    /// Of the mark in the ring, or of the tray.
    pub(crate) colour: Colour,
}

impl State {
    /// Before the first tick; what is held must be held for `dwell` \[s\].
    pub(crate) fn new(dwell: f64) -> Result<Self, Fault> {
        Ok(Self {
            starts: Vec::new(),
            patches: Vec::new(),
            probes: Probes::default(),
            contacts: Contacts::default(),
            cuts: CutLog::default(),
            drops: Drops::default(),
            gripped: false,
            release: Drops::default(),
            had: false,
            reached: false,
            loose: false,
            counted: (0, 0.0),
            off: false,
            carried: false,
            dwell: Dwell::new(dwell).map_err(|e| Fault::new(e.to_string()))?,
            colour: colour::WAITING,
        })
    }
}
