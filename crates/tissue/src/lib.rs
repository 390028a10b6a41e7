//! Deformable tissue: elements, material laws, models, solvers.
//!
//! Four things are kept apart: the constant [`TissueModel`], the evolving [`State`], the [`Control`] and the
//! [`Contacts`] of a step; a [`Solver`] is `step(model, state, control, contacts, h)`. A model is held together by sets of
//! [`elements`](Elements): springs, triangles, volumes, continua of a material [`law`], couplings. What is not here: finding contacts (crate
//! `contact`), coupling of bodies (crate `scene`), linear algebra of large systems (crate `sparse`), files, clocks, threads of
//! its own – parallel loops run on an [`Executor`] that the caller brings, and give the same bits on any. SI units, world
//! frame.

pub mod elements;
mod executor;
mod forces;
pub mod law;
mod material;
mod method;
mod model;
mod solver;
mod solver_verlet;
pub mod stability;
mod state;

pub use elements::Elements;
pub use executor::{Executor, Serial};
pub use forces::Forces;
pub use material::{
    Behaviour, BuildError, ContinuumConstants, Discretisation, Material, MaterialError,
    SpringConstants, build_model,
};
pub use method::{Method, MethodError};
pub use model::{ModelError, TissueModel};
pub use solver::{Solver, StepFailure, StepReport};
pub use solver_verlet::SolverVerlet;
pub use state::{Contacts, Control, Energies, NodeTarget, Pressure, State};

#[cfg(test)]
mod testing;
