//! Deformable tissue: elements, material laws, models, solvers.
//!
//! Four types stay apart: the constant [`TissueModel`], the evolving [`State`], the [`Control`] and the
//! [node targets](NodeTarget) of a step; a [`Solver`] is `step(model, state, control, targets, h)`, or `advance` with a [`ContactStep`]. A model is held together by sets of
//! [`elements`](Elements): springs, triangles, volumes, continua of a material [`law`], couplings. What is not here: finding contacts (crate
//! `contact`), coupling of bodies (crate `scene`), linear algebra of large systems (crate `sparse`), files, clocks, threads of
//! its own – parallel loops run on an [`Executor`] that the caller brings, and give the same bits on any. SI units, world
//! frame.

#![forbid(unsafe_code)]

mod build;
mod components;
#[cfg(test)]
mod contact_tests;
mod edit;
mod element_index;
pub mod elements;
mod executor;
mod flow;
mod forces;
mod gershgorin;
pub mod homogenise;
mod lanes;
pub mod law;
mod material;
mod method;
mod model;
mod newton;
mod prescribed;
mod range;
mod solver;
mod solver_explicit;
mod solver_implicit;
mod solver_quasi_static;
mod solver_verlet;
mod solver_xpbd;
pub mod stability;
mod state;
mod system;

pub use build::{BuildError, build_model};
pub use edit::{EditError, ModelChange, ModelEdit};
pub use elements::Elements;
pub use executor::{Executor, Serial};
pub use flow::flow;
pub use forces::Forces;
pub use lanes::Lanes;
pub use material::{
    Behaviour, Coefficients, ContinuumConstants, Fit, KindConstants, Material, SpringConstants,
    SpringForm, SpringModuli, fit,
};
pub use method::{Method, MethodError};
pub use microsim_contact_solver::{Contact, ContactSource, ContactStep};
pub use microsim_vocabulary::{Discretisation, MethodName};
pub use model::{ModelError, TissueModel};
pub use newton::{
    LineSearchOptions, Newton, NewtonContactOptions, NewtonOptions, SecondOrderOptions,
};
pub use range::MaterialError;
pub use solver::{Solver, StepFailure, StepReport};
pub use solver_explicit::{Scheme, SolverExplicit};
pub use solver_implicit::{DistortionOptions, ImplicitScheme, SolverImplicit};
pub use solver_quasi_static::{QuasiStaticOptions, SolverQuasiStatic};
pub use solver_verlet::SolverVerlet;
pub use solver_xpbd::SolverXpbd;
pub use state::{Control, Energies, NodeTarget, Pressure, State};

#[cfg(test)]
mod testing;
