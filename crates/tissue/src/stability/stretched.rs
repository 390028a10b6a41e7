//! A body drawn out: the shape of which the step at work is that of.

use crate::model::TissueModel;
use crate::state::State;

/// A stretch at work: about that along vessels in the body (Weizsäcker, Lambert and Pascale 1983 have 1.6 to 1.7 for the carotid
/// artery of rats; those of humans are drawn out less), and what hands that pull may reach.
pub const WORKING_STRETCH: f64 = 1.5;

/// The body at rest, its whole shape stretched by the factor `stretch` along x, y or z (`axis` 0, 1 or 2) and so much thinner
/// across that its volume is that at rest, clamped nodes too. Of a round wall it draws out some parts along their fibres whatever
/// these are, which is what bounds a step.
pub fn stretched(model: &TissueModel, stretch: f64, axis: usize) -> State {
    let mut state = State::at_rest(model);
    let across = 1.0 / stretch.sqrt();
    for position in &mut state.positions {
        for (k, coordinate) in position.iter_mut().enumerate() {
            *coordinate *= if k == axis { stretch } else { across };
        }
    }
    state
}
