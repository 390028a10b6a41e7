//! How far the solver of the tissue came.

use crate::wire::Message;
use serde::{Deserialize, Serialize};

/// How far the solver of the tissue came in a tick, of all bodies; published in every tick, before the forces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverTick {
    /// Steps, each counted once per group of bodies that are solved together; 0 of a tick in which the bodies were held.
    pub steps: u32,
    /// Steps that ended above the tolerance of the method.
    pub unconverged: u32,
    /// Iterations of all steps.
    pub iterations: u32,
    /// Largest residual of a step, relative to the forces in it; 0 for a method that solves no equation.
    pub residual: f64,
    /// Largest residual itself, a norm over all free nodes \[N\].
    pub force_residual: f64,
    /// Largest multiplier residual of contacts, relative to the mean edge length.
    pub contact_residual: f64,
    /// Halvings of iterations after which surfaces had turned too far.
    pub backtracks: u32,
    /// Iterations in which contact forces could not be found and remained those of before.
    pub contact_failures: u32,
    /// How often the tick was computed again, because a body diverged or its forces meant nothing.
    pub repetitions: u32,
    /// Shreds of cut tissue that were taken away so that the forces of the tick mean anything.
    #[serde(default)]
    pub ruptured: u32,
    /// Whether the tick could only be computed with the tools where they were before it, or touching nothing.
    #[serde(default)]
    pub tools_stood: bool,
    /// Whether the work of the tick was bounded by its budget.
    #[serde(default)]
    pub over_budget: bool,
    /// Pairs of tools that touched each other.
    #[serde(default)]
    pub tool_contacts: u32,
    /// Whether the forces of the tick mean anything: the residuals are within their bounds (`microsim_scene::SolverBounds`), no force has jumped in a step above the tolerance,
    /// and the bodies were neither held nor computed with tools that touch nothing. From any other tick no metric takes a force or a cut.
    pub valid: bool,
}

impl Message for SolverTick {
    const KIND: &'static str = "tissue.solver";
}
