//! The equilibrium in which a body with residual stress begins.
//!
//! Prestretches come from an exact solution, never from a file; elements that are as coarse as those of a level are in equilibrium a little
//! beside the places of their mesh. There they are put before the first tick, with clamps and loads as at time 0, without weight and contact: what
//! moves from then on is moved by what happens.

use crate::drive::Drive;
use crate::error::{PrestretchError, SceneError};
use microsim_tissue::{Newton, Serial, Solver, SolverQuasiStatic, State, StepFailure, TissueModel};
use nalgebra::Vector3;

/// How far the nodes of a body may be from their mesh in the equilibrium, over its mean edge: beyond, its shape is not the one that was
/// described. Layers of one linear element each are off by 0.05 to 0.1.
const LARGEST_SHIFT: f64 = 0.5;

/// Residual of the equilibrium over the forces in it.
const TOLERANCE: f64 = 1e-9;

/// The equilibrium in which a body with prestretches begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialEquilibrium {
    /// Largest distance of a node from its place in the mesh \[m\].
    pub shift: f64,
    /// What is left of the forces, relative to all forces.
    pub residual: f64,
}

/// Puts a body of prestretched elements into equilibrium.
pub(crate) fn find(
    name: &str,
    model: &TissueModel,
    drive: &Drive,
    state: &mut State,
) -> Result<InitialEquilibrium, SceneError> {
    let newton = Newton {
        iterations: 100,
        tolerance: TOLERANCE,
        must_converge: true,
    };
    let mut solver = SolverQuasiStatic::new(model, newton);
    let control = drive.control(&Vector3::zeros(), 0.0);
    let targets = drive.targets(0.0);
    let refused = |reason| SceneError::Prestretch {
        body: name.to_owned(),
        reason,
    };
    let report = solver
        .step(model, state, &control, &targets, 1.0, &Serial)
        .map_err(|failure| {
            refused(match failure {
                StepFailure::Singular { .. } => PrestretchError::Loose,
                _ => PrestretchError::NotFound,
            })
        })?;
    // No time has passed: a leapfrog would take the step of the search for one that it has made, and kick by its length.
    state.step = 0.0;
    let places = state.positions.iter().zip(model.rest_positions());
    let shift = places
        .map(|(now, mesh)| (now - mesh).norm())
        .fold(0.0, f64::max);
    let edge = model.mean_edge_length();
    if shift > LARGEST_SHIFT * edge {
        return Err(refused(PrestretchError::Shift { shift, edge }));
    }
    Ok(InitialEquilibrium {
        shift,
        residual: report.residual,
    })
}
