//! Flow of internal variables: plasticity, breaking, sliding, once per step.

use crate::model::TissueModel;
use crate::state::State;

/// Lets the internal variables of all elements flow for `h` \[s\] at the state's positions; returns whether a stiffness has
/// grown. Then the step must be checked again with [`stable_step_at`](crate::stability::stable_step_at).
///
/// Where elements may slide the model is [relocated](TissueModel::relocate) before the next step.
///
/// Solvers integrate motion alone. Whoever drives them calls this after each step, once the step is accepted.
pub fn flow(model: &TissueModel, state: &mut State, h: f64) -> bool {
    let mut stiffer = false;
    for (set, elements) in model.sets().iter().enumerate() {
        let internal = &mut state.internal[model.internal_range(set)];
        if !internal.is_empty() {
            stiffer |= elements.flow(&state.positions, internal, h);
        }
    }
    stiffer
}
