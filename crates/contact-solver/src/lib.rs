//! Contact forces of deformable bodies: unilateral contact (Signorini) with friction (Coulomb) in one linearised step.
//!
//! A [`Contact`] is a linearised constraint between nodes, or nodes and something rigid. A [`ContactSolver`] finds the forces that
//! satisfy them, given how nodes respond to forces; there are three:
//!
//! | solver | response | for |
//! |---|---|---|
//! | [`GaussSeidel`] | a compliance of each node | explicit and position-based methods |
//! | [`AugmentedLagrangian`] | a linear solver | implicit methods and statics, to any tolerance |
//! | [`InteriorPoint`] | a linear solver, whose Delassus (Schur complement) operator is formed | early-terminated steps of small bodies, unless they are repeated |
//!
//! The linear solver is a [`LinearSystem`]; the constants of the methods are [options](ContactOptions). The last two solvers work on a
//! [`ContactSet`], which gives Newton's method the energy and the forces of contacts too. [`Projection`] does a whole step of an explicit
//! method, and [`RigidComponents`] undo overlaps without strain.
//!
//! What is not here: finding contacts (crate `contact`), elements, nonlinear iterations. Pure; the same numbers give the same bits.

#![forbid(unsafe_code)]

mod augmented_lagrangian;
mod components;
mod cone_program;
mod contact;
mod directions;
mod energy_line;
mod gauss_seidel;
mod interior_point;
mod nodal;
mod options;
mod projection;
mod reduced;
mod rigid_components;
mod row;
mod set;
mod solver;
mod system_forces;
mod vectors;

pub use augmented_lagrangian::AugmentedLagrangian;
pub use components::{Components, Groups};
pub use contact::{Contact, ContactSource, ContactStep, Response};
pub use gauss_seidel::{GapConstraint, GaussSeidel, NodalResponse};
pub use interior_point::InteriorPoint;
pub use nodal::{NodalCompliance, NodalSystem};
pub use options::{
    AugmentedLagrangianOptions, ContactOptions, GaussSeidelOptions, InteriorPointOptions,
    OverlapOptions, ReducedOptions, RigidComponentOptions,
};
pub use projection::Projection;
pub use rigid_components::RigidComponents;
pub use set::ContactSet;
pub use solver::{AddProduct, ContactSolver, LinearSystem, SystemResponse, Tolerances};

#[cfg(test)]
mod tests;
