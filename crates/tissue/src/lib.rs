//! Deformable tissue: energies, materials, models, integrators.
//!
//! Four things are kept apart: the constant [`TissueModel`], the evolving [`State`], the [`Control`] and the
//! [`Contacts`] of a step; a solver is `step(model, state, control, contacts, h)`. What is here now: springs with length
//! energy (4.1), tetrahedra with volume energy (4.2), Störmer–Verlet in the joint form of NUMERICS 2.4. What is not:
//! finding contacts (crate `contact`), coupling (crate `scene`), files, clocks, threads of its own – parallel loops run on
//! an [`Executor`] that the caller brings, and give the same bits on any. SI units, world frame.

pub mod energies;
mod executor;
mod material;
mod model;
mod solver_verlet;
pub mod stability;
mod state;

pub use executor::{Executor, Serial};
pub use material::{MaterialError, SpringVolume, SpringVolumeSpec};
pub use model::{ModelError, Spring, TissueModel, VolumeElement};
pub use solver_verlet::SolverVerlet;
pub use state::{Contacts, Control, Energies, NodeTarget, State};
