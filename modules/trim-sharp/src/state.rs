//! What evolves in a run.

use crate::draw::DrawSpeed;
use crate::layers::{ADVENTITIA, MEDIA};
use crate::tilt::Tilt;
use crate::trimmed::{Keys, Trimmed};
use microsim_sdk::Fault;
use microsim_sdk::message::Colour;
use microsim_sdk::tissue::{Bites, Contacts, LayerGrips, WallInjury, colour};
use microsim_training::Dwell;
use serde::{Deserialize, Serialize};

/// What evolves here besides the run of the level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Whether a tool has touched the vessel while the level ran.
    pub(crate) started: bool,
    pub(crate) contacts: Contacts,
    pub(crate) grips: LayerGrips,
    pub(crate) injury: WallInjury,
    pub(crate) draw: DrawSpeed,
    pub(crate) bites: Bites,
    pub(crate) tilt: Tilt,
    /// Areas that scissors opened in the adventitia, and of these while forceps held the vessel \[m²\].
    pub(crate) cut: f64,
    pub(crate) held_cut: f64,
    /// When forceps held it last \[s\].
    pub(crate) held_at: Option<f64>,
    /// Whether a tool touched what is held in the clamp, in the last tick that means something.
    pub(crate) touched: bool,
    /// For each holder, whether its jaws gripped what is held in the clamp then, be it that it slid through them.
    pub(crate) gripped: Vec<bool>,
    pub(crate) trimmed: Option<Trimmed>,
    pub(crate) stay: Dwell,
    /// Of the mark.
    pub(crate) colour: Colour,
}

impl State {
    pub(crate) fn new(keys: &Keys) -> Result<Self, Fault> {
        // Of the adventitia only what is cut counts: it may be stretched.
        let layers = [(MEDIA, keys.injuring_stretch), (ADVENTITIA, f64::MAX)];
        Ok(Self {
            started: false,
            contacts: Contacts::default(),
            grips: LayerGrips::of(&[MEDIA, ADVENTITIA]),
            injury: WallInjury::of(&layers),
            draw: DrawSpeed::default(),
            bites: Bites::default(),
            tilt: Tilt::default(),
            cut: 0.0,
            held_cut: 0.0,
            held_at: None,
            touched: false,
            gripped: Vec::new(),
            trimmed: None,
            stay: Dwell::new(keys.stay)?,
            colour: colour::CURRENT,
        })
    }
}
