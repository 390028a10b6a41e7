//! What evolves in a level besides its [`microsim_sdk::LevelRun`].

use crate::dilator::Spreads;
use crate::site::{ADVENTITIA, Keys, MEDIA};
use microsim_sdk::Fault;
use microsim_sdk::message::Colour;
use microsim_sdk::tissue::{Contacts, LayerGrips, WallInjury, colour};
use microsim_training::Dwell;
use serde::{Deserialize, Serialize};

/// What evolves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Whether any tool of the level was tracked so far.
    pub(crate) seen: bool,
    pub(crate) contacts: Contacts,
    pub(crate) grips: LayerGrips,
    pub(crate) injury: WallInjury,
    pub(crate) spreads: Spreads,
    /// Time in which the dilator was in the lumen, and the part of it in which the adventitia was held \[s\].
    pub(crate) inside: f64,
    /// See [`State::inside`].
    pub(crate) steadied: f64,
    /// Largest sustained force of the dilator on the vessel as a whole \[N\].
    pub(crate) peak_force: f64,
    /// The same while it was closed.
    pub(crate) push: f64,
    /// Whether the dilator has been deep enough in the lumen.
    pub(crate) entered: bool,
    /// Whether something touches the vessel now, and whether neither that is so nor the dilator is in the lumen.
    pub(crate) touched: bool,
    /// See [`State::touched`].
    pub(crate) free: bool,
    /// The opening when nothing touched the vessel last, after the dilator had been in it.
    pub(crate) left: Option<Left>,
    pub(crate) dwell: Dwell,
    /// Of the gauge.
    pub(crate) colour: Colour,
}

/// What is left of the widening once nothing touches the vessel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Left {
    /// Diameter of the circle of the opening's area \[m\].
    pub diameter: f64,
    /// Area of the opening over that of a circle of its circumference.
    pub roundness: f64,
}

impl State {
    /// Before the first tick.
    pub(crate) fn new(keys: &Keys) -> Result<Self, Fault> {
        Ok(Self {
            seen: false,
            contacts: Contacts::default(),
            grips: LayerGrips::of(&[MEDIA, ADVENTITIA]),
            injury: WallInjury::of(&[(MEDIA, keys.injury_stretch)]),
            spreads: Spreads::default(),
            inside: 0.0,
            steadied: 0.0,
            peak_force: 0.0,
            push: 0.0,
            entered: false,
            touched: false,
            free: false,
            left: None,
            dwell: Dwell::new(keys.dwell)?,
            colour: colour::CURRENT,
        })
    }

    /// Whether the media has torn.
    pub(crate) fn is_torn(&self) -> bool {
        let media = self.injury.layer(MEDIA);
        media.is_some_and(|media| media.torn > 0.0)
    }
}
