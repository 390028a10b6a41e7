//! What evolves in a run.

use crate::bare::{Bare, Keys};
use crate::layers::{ADVENTITIA, MEDIA};
use microsim_sdk::message::Colour;
use microsim_sdk::tissue::{Contacts, LayerGrips, VesselAxis, WallInjury, colour};
use microsim_sdk::{BlockView, Fault};
use microsim_training::Dwell;
use serde::{Deserialize, Serialize};

/// Where the vessel lies before anything touches it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Found {
    pub axis: VesselAxis,
    /// The middle of its free end \[m\].
    pub end: [f64; 3],
    /// Largest distance of a node from the axis \[m\].
    pub radius: f64,
}

impl Found {
    /// Of a snapshot, from a point on the axis beside the held end on; `None` where the vessel has no length.
    pub fn of(block: &BlockView<'_>, held: [f64; 3]) -> Option<Self> {
        let places: Vec<[f64; 3]> = block.f64s("position")?.as_chunks().0.to_vec();
        let count = places.len() as f64;
        let mean = [0, 1, 2].map(|k| places.iter().map(|p| p[k]).sum::<f64>() / count);
        let axis = VesselAxis::new(held, [0, 1, 2].map(|k| mean[k] - held[k]))?;
        let far = |of: &dyn Fn([f64; 3]) -> f64| {
            places
                .iter()
                .map(|p| of(*p))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let length = far(&|p| axis.along(p));
        let direction = axis.direction();
        Some(Self {
            axis,
            end: [0, 1, 2].map(|k| held[k] + length * direction[k]),
            radius: far(&|p| axis.radial(p).iter().map(|c| c * c).sum::<f64>()).sqrt(),
        })
    }
}

/// What evolves here besides the run of the level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub(crate) found: Option<Found>,
    /// Whether a tool has been tracked while the level ran.
    pub(crate) started: bool,
    pub(crate) contacts: Contacts,
    pub(crate) grips: LayerGrips,
    pub(crate) injury: WallInjury,
    pub(crate) bare: Option<Bare>,
    /// Whether the end was as bare as asked for at any time.
    pub(crate) reached: bool,
    pub(crate) stay: Dwell,
    pub(crate) colour: Colour,
}

impl State {
    pub(crate) fn new(keys: &Keys) -> Result<Self, Fault> {
        // Of the adventitia only what tears counts: it may be stretched.
        let layers = [(MEDIA, keys.injuring_stretch), (ADVENTITIA, f64::MAX)];
        Ok(Self {
            found: None,
            started: false,
            contacts: Contacts::default(),
            grips: LayerGrips::of(&[MEDIA]),
            injury: WallInjury::of(&layers),
            bare: None,
            reached: false,
            stay: Dwell::new(keys.stay)?,
            colour: colour::CURRENT,
        })
    }
}
