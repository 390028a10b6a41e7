//! The step of explicit methods on tissue that stiffens as it stretches.
//!
//! A step that is stable at rest is not when a wall of collagen is drawn out: its stiffness grows by orders of magnitude. Here is what
//! looks after it while a scene runs: whether bodies stiffen so far at all, when to look, and the longest step that their shape allows
//! now. What is not: repeating the tick that became too long (`tick`), and limits of a shape that is given (crate `tissue`, module
//! `stability`).

use crate::body::{limited_step, stable_step};
use microsim_tissue::stability::{
    Part, SAFETY, WORKING_STRETCH, gershgorin_bound, gershgorin_bound_at, stretched,
};
use microsim_tissue::{Method, State, TissueModel};

/// A step is too long from 0.8 of the stability limit on, that is this multiple of the recommended step. What is left is for what
/// stiffens until the next look: half as much again in stiffness.
pub const TOO_LONG: f64 = 0.8 / SAFETY;

/// A step that was shortened grows again where it is below this fraction of the recommended one: 0.4 of the limit, half of where
/// it is shortened, so that it does not go to and fro.
const TOO_SHORT: f64 = 0.4 / SAFETY;

/// Tissue is as soft as at rest again where its recommended step is this fraction of that at rest: closer than what swings can come.
const AT_REST: f64 = 0.95;

/// Steps between two looks. A look costs as much as some ten evaluations of the forces; a hand that draws at 0.1 m/s stretches a
/// piece of 10 mm by 1 % meanwhile, at steps of 30 µs.
const LOOK_EVERY: f64 = 32.0;

/// Stiffness may grow until steps are this much shorter than at rest; what needs shorter ones than that has diverged.
const SHORTEST: f64 = 1.0 / 64.0;

/// Looks after the step of bodies that are advanced together.
#[derive(Clone, Debug)]
pub(crate) struct StretchGuard {
    method: Method,
    /// Gershgorin's bound of λ_max at rest \[1/s²\].
    bound: f64,
    /// The longest step at rest \[s\].
    step: f64,
}

impl StretchGuard {
    /// For a model; `None` for a method without a limit, and where the working stretch, and the plastic flow that may come to it, do not make a
    /// stable step too long.
    pub fn new(method: &Method, model: &TissueModel) -> Option<Self> {
        if !method.is_explicit() {
            return None;
        }
        let bound = gershgorin_bound(model, Part::Stiffness);
        let grown = (0..3).map(|axis| {
            let state = stretched(model, WORKING_STRETCH, axis);
            gershgorin_bound_at(model, &state, Part::Stiffness)
        });
        let grown = grown.fold(bound, f64::max);
        let thinning = model.sets().iter().map(|set| set.most_thinning());
        let thinning = thinning.fold(1.0, f64::max);
        let is_covered = grown * thinning * thinning <= TOO_LONG * TOO_LONG * bound;
        (!is_covered).then(|| Self {
            method: *method,
            bound,
            step: stable_step(method, model, &State::at_rest(model)),
        })
    }

    /// Whether to look before the step from `time` that has the length `h`, while steps of `longest` are allowed \[s\]: at the first
    /// step in each stretch of time of so many of these, whatever the ticks.
    pub fn is_due(&self, time: f64, h: f64, longest: f64) -> bool {
        let period = LOOK_EVERY * longest;
        h >= period || (time / period).floor() != ((time - h) / period).floor()
    }

    /// The longest step in this state \[s\], from the bound alone where that is enough to see that `h` is not too long.
    pub fn longest_step(&self, model: &TissueModel, state: &State, h: f64) -> f64 {
        let bound = gershgorin_bound_at(model, state, Part::Stiffness);
        let about = self.step * (self.bound / bound).sqrt();
        match h <= about {
            true => about,
            false => limited_step(&self.method, model, state),
        }
    }

    /// Whether a step of `h` is too long where `longest` is the recommended one \[s\].
    pub fn is_too_long(h: f64, longest: f64) -> bool {
        h > TOO_LONG * longest
    }

    /// To what the step `now` of a body may grow again where `longest` is the recommended one of its group, and `at_rest` that at rest \[s\];
    /// infinite where stretch bounds it no longer.
    pub fn grown(now: f64, longest: f64, at_rest: f64) -> Option<f64> {
        if now >= at_rest {
            None
        } else if longest >= AT_REST * at_rest {
            Some(f64::INFINITY)
        } else {
            (now < TOO_SHORT * longest).then_some(longest)
        }
    }

    /// Whether steps of this length \[s\] are too short to go on with, where `at_rest` is that at rest.
    pub fn is_hopeless(longest: f64, at_rest: f64) -> bool {
        longest.is_nan() || longest < SHORTEST * at_rest
    }
}
