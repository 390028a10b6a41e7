//! What evolves in a level besides its [`microsim_sdk::LevelRun`].

use microsim_sdk::Fault;
use microsim_sdk::tissue::{Bites, Contacts, LayerGrips, Probes, Rim, WallInjury};
use microsim_training::Dwell;
use serde::{Deserialize, Serialize};

/// The size of an opening.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Size {
    /// Length of a thread drawn tight around it \[m\].
    pub girth: f64,
    /// \[m²\]
    pub area: f64,
}

impl Size {
    pub fn of(rim: &Rim) -> Self {
        Self {
            girth: rim.girth,
            area: rim.area,
        }
    }
}

/// What is found of the vessels in the first tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Found {
    /// The openings of both vessels.
    pub smaller: Size,
    pub larger: Size,
    /// How far along its axis the smaller one reaches \[m\].
    pub reach: f64,
    /// Its two ends.
    pub ends: Probes,
    pub grips: LayerGrips,
    pub injury: WallInjury,
    /// Region of the media of the smaller one: the layer around the lumen.
    pub media: u32,
}

/// What evolves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// `None` before there is tissue.
    pub(crate) found: Option<Found>,
    pub(crate) contacts: Contacts,
    /// Whether a tool touched the held piece of the smaller vessel in the last tick that means something.
    pub(crate) touched: bool,
    /// When it was gripped last \[s\].
    pub(crate) gripped: Option<f64>,
    pub(crate) bites: Bites,
    /// Areas that tools opened in the smaller vessel, of these while it was gripped, and in the larger one \[m²\].
    pub(crate) cut: f64,
    pub(crate) steadied: f64,
    pub(crate) other: f64,
    /// Area of the smaller one that tore by itself \[m²\].
    pub(crate) torn: f64,
    /// Largest relative growth of the circumference of its opening before it was cut through.
    pub(crate) spread: f64,
    pub(crate) dwell: Dwell,
}

impl State {
    /// Before the first tick; a vessel counts as free, or matched, after `dwell` \[s\].
    pub(crate) fn new(dwell: f64) -> Result<Self, Fault> {
        Ok(Self {
            found: None,
            contacts: Contacts::default(),
            touched: false,
            gripped: None,
            bites: Bites::default(),
            cut: 0.0,
            steadied: 0.0,
            other: 0.0,
            torn: 0.0,
            spread: 0.0,
            dwell: Dwell::new(dwell)?,
        })
    }
}
