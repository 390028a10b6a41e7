//! Deformable tissue: elements, material laws, models, solvers.
//!
//! # Where to begin
//! A mesh and a material make a [`TissueModel`], which does not change; positions and velocities are in a [`State`], gravity and loads in a
//! [`Control`]; a [`Method`] makes the [`Solver`] that advances the state:
//!
//! ```
//! use microsim_mesh::{Block, CellSplit};
//! use microsim_tissue::law::LawName;
//! use microsim_tissue::*;
//!
//! // A column of 2 × 2 × 20 mm that hangs from its upper face.
//! let (length, young, density, gravity) = (20e-3, 20e3, 1e3, 9.81);
//! let block = Block {
//!     center: [0.0, 0.0, -0.5 * length],
//!     size: [2e-3, 2e-3, length],
//!     cells: [2, 2, 20],
//!     split: CellSplit::Kuhn,
//! };
//! let mesh = block.mesh()?;
//! let behaviour = Behaviour::Continuum(ContinuumConstants {
//!     law: LawName::StableNeoHookean.into(),
//!     young,
//!     poisson: 0.0,
//!     discretisation: Discretisation::Tetrahedra,
//!     plasticity: None,
//! });
//! let material = Material { density, relaxation_time: 0.0, behaviour };
//! let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > -1e-9).collect();
//! let model = build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new())?;
//!
//! let control = Control { gravity: [0.0, 0.0, -gravity].into(), ..Control::default() };
//! let mut state = State::at_rest(&model);
//! let mut solver = Method::QuasiStatic(Newton::default()).solver(&model)?;
//! solver.step(&model, &mut state, &control, &[], 1.0, &Serial)?;
//!
//! // Its end goes down by ρ g L²/(2 E), up to terms of second order.
//! let lowest = state.positions.iter().map(|p| p.z).fold(0.0, f64::min);
//! let expected = density * gravity * length * length / (2.0 * young);
//! assert!(((-length - lowest) / expected - 1.0).abs() < 0.03);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what for | see |
//! |---|---|
//! | a beam against beam theory | `cargo run --release --example beam -p microsim-tissue` |
//! | material laws, and how to add one | module [`law`] |
//! | springs, or a continuum, and its discretisation | [`Behaviour`], [`Discretisation`] |
//! | integrators and solvers | [`Method`], and its parameters [`Newton`] |
//! | how long a step may be | module [`stability`] |
//! | contact within a step | [`Solver::advance`], [`ContactSource`], [`Contact`] |
//! | prescribed positions of nodes | [`NodeTarget`]; for clamps [`Control::clamped_positions`] |
//! | plasticity | [`flow`](flow()), [`PlasticSet`](elements::PlasticSet), [`ContinuumPlasticity`](elements::ContinuumPlasticity) |
//! | the model after a cut | [`TissueModel::edit`], [`ModelEdit`] |
//! | another kind of element | module [`elements`] |
//!
//! # What is not here
//! Finding contacts (crate `contact`), contact forces (crate `contact-solver`), coupling of bodies (crate `scene`), linear algebra of large
//! systems (crate `sparse`), files, clocks, threads of its own: parallel loops run on an [`Executor`] that the caller brings, and give the
//! same bits on any. Quantities are in SI units, positions in the world frame.

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
mod number;
mod plastic_states;
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
pub mod vessel_wall;
mod work;

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
pub use microsim_contact_solver::{Contact, ContactSource, ContactStep, Response};
pub use microsim_vocabulary::{Discretisation, MethodName};
pub use model::{ModelError, TissueModel};
pub use newton::{
    LineSearchOptions, Newton, NewtonContactOptions, NewtonOptions, SecondOrderOptions,
};
pub use range::MaterialError;
pub use solver::{Effort, ResidualBounds, SolutionBounds, Solver, StepFailure, StepReport};
pub use solver_explicit::{Scheme, SolverExplicit};
pub use solver_implicit::{DistortionOptions, ImplicitScheme, SolverImplicit};
pub use solver_quasi_static::{QuasiStaticOptions, SolverQuasiStatic};
pub use solver_verlet::SolverVerlet;
pub use solver_xpbd::SolverXpbd;
pub use state::{Control, Energies, NodeTarget, PressedTriangle, Pressure, State};

#[cfg(test)]
mod testing;
