//! The equilibrium in which a body with residual stress begins.
//!
//! Prestretches come from an exact solution, never from a file; elements that are as coarse as those of a level are in equilibrium a little
//! beside the places of their mesh. There they are put before the first tick, with clamps and loads as at time 0, without weight and contact: what
//! moves from then on is moved by what happens.

use crate::drive::Drive;
use crate::error::SceneError;
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

/// Why a body with prestretches has no equilibrium to begin in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrestretchError {
    /// Nothing holds a part of it.
    Loose,
    /// None was found.
    NotFound,
    /// Its nodes are far from their places in the mesh.
    Shift {
        /// The largest distance \[m\].
        shift: f64,
        /// Mean edge of the mesh \[m\].
        edge: f64,
    },
}

impl std::fmt::Display for PrestretchError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Loose => write!(
                f,
                "nothing holds a part of it at the start; expected are clamps that hold the ends of what is prestretched"
            ),
            Self::NotFound => write!(
                f,
                "no equilibrium was found with its clamps and loads at the start; expected is a pressure on the lumen that is its \
                 `transmural_pressure`, and clamps that bear the axial stretch"
            ),
            Self::Shift { shift, edge } => write!(
                f,
                "in equilibrium with its clamps and loads at the start nodes are up to {:.4} mm beside their places, edges are {:.4} mm long; \
                 expected is at most half an edge: clamps that hold both ends, and a load on the lumen with the `transmural_pressure` and no ramp",
                1e3 * shift,
                1e3 * edge
            ),
        }
    }
}

impl std::error::Error for PrestretchError {}
