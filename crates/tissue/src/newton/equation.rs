//! One equation for positions, and what stays the same while it is solved.

use crate::executor::Executor;
use crate::model::TissueModel;
use crate::state::Control;
use microsim_contact_solver::ContactSource;
use nalgebra::Vector3;

/// One equation.
#[derive(Clone, Debug)]
pub(crate) struct Equation {
    /// 1/η \[1/s\]; 0 in statics.
    pub rate: f64,
    /// x̃ \[m\].
    pub base: Vec<Vector3<f64>>,
    /// ṽ \[m/s\].
    pub base_velocities: Vec<Vector3<f64>>,
    /// A force that does not depend on anything \[N\], for the steps of a static load; empty for none.
    pub extra: Vec<Vector3<f64>>,
    /// Regularisation: springs from each node to its x̃ \[N/m\], in statics; empty for none.
    pub regularisation: Vec<f64>,
}

/// Contact in one equation.
pub(crate) struct EquationContact<'a> {
    pub source: &'a mut dyn ContactSource,
    /// Since when sliding counts.
    pub slip_since: SlipReference<'a>,
    /// Where in the step the equation is.
    pub step_fraction: f64,
    /// Contacts are found at most so often, however often the options allow.
    pub most_searches: u32,
}

/// A time in a step, since which sliding counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlipReference<'a> {
    /// Positions then \[m\].
    pub positions: &'a [Vector3<f64>],
    /// The part of the displacement of rigid obstacles up to the equation that comes after it.
    pub drift: f64,
}

impl<'a> SlipReference<'a> {
    /// The start of the step.
    pub fn start(positions: &'a [Vector3<f64>]) -> Self {
        Self {
            positions,
            drift: 1.0,
        }
    }
}

/// What stays the same while one equation is solved.
pub(super) struct Problem<'a> {
    pub model: &'a TissueModel,
    pub control: &'a Control,
    pub equation: &'a Equation,
    /// Marks of the prescribed nodes.
    pub fixed: &'a [bool],
    pub exec: &'a dyn Executor,
}
