//! What evolves in a scene.

use crate::force_window::ForceWindow;
use crate::group_contact::ContactState;
use crate::lonor::BladeState;
use crate::placement::Placements;
use microsim_tissue::State;

/// All that evolves. A copy of it is all that is needed to go back.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SceneState {
    /// One per body.
    pub bodies: Vec<State>,
    /// One per group of bodies.
    pub contacts: Vec<ContactState>,
    /// Longest step of each body as it is now \[s\]: plastic flow and stretch make it shorter.
    pub stable_steps: Vec<f64>,
    /// One per cut.
    pub blades: Vec<BladeState>,
    /// One per contact pair.
    pub windows: Vec<ForceWindow>,
    /// Of the tools.
    pub placements: Placements,
    /// Whether the last tick was not valid.
    pub doubtful: bool,
    /// The work of the ticks so far beyond their mean budget that the next ones have to make up for \[s\].
    pub overspent: f64,
    /// Simulated time \[s\].
    pub time: f64,
}
