//! The methods by name: one list for files, reports and comparisons.

use crate::model::TissueModel;
use crate::solver::Solver;
use crate::solver_explicit::{Scheme, SolverExplicit};
use crate::solver_verlet::SolverVerlet;

/// A method with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Störmer–Verlet in the joint form, drag by the exact factor.
    StoermerVerlet,
    /// Explicit Euler (3.12, 3.13).
    ExplicitEuler,
    /// Symplectic Euler.
    SymplecticEuler,
    /// Velocity Verlet in its standard form, drag by the exact factor.
    VelocityVerlet,
    /// Velocity Verlet as a loop with stored values of the step before (3.19, 3.20 as printed), drag from the old velocity.
    VelocityVerletLagged,
}

/// Why a method cannot treat a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MethodError {
    /// Name of the method.
    pub method: &'static str,
    /// Why, with the remedy.
    pub reason: &'static str,
}

impl std::fmt::Display for MethodError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.method, self.reason)
    }
}

impl std::error::Error for MethodError {}

impl Method {
    /// Its name in files and reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::StoermerVerlet => "stoermer-verlet",
            Self::ExplicitEuler => "explicit-euler",
            Self::SymplecticEuler => "symplectic-euler",
            Self::VelocityVerlet => "velocity-verlet",
            Self::VelocityVerletLagged => "velocity-verlet-lagged",
        }
    }

    /// Whether its step is bounded by [`stability::stable_step`](crate::stability::stable_step); explicit Euler needs a shorter
    /// one, and drag ([`stability::limit`](crate::stability::limit)).
    pub fn is_explicit(&self) -> bool {
        match self {
            Self::StoermerVerlet
            | Self::ExplicitEuler
            | Self::SymplecticEuler
            | Self::VelocityVerlet
            | Self::VelocityVerletLagged => true,
        }
    }

    /// Whether a node can be led to a target within one step ([`Contacts`](crate::Contacts)).
    pub fn leads_nodes(&self) -> bool {
        match self {
            Self::StoermerVerlet
            | Self::SymplecticEuler
            | Self::VelocityVerlet
            | Self::VelocityVerletLagged => true,
            // Its force moves a node one step later only.
            Self::ExplicitEuler => false,
        }
    }

    /// A solver for `model`.
    pub fn solver(&self, model: &TissueModel) -> Result<Box<dyn Solver>, MethodError> {
        let explicit = |scheme| Box::new(SolverExplicit::new(model, scheme));
        Ok(match self {
            Self::StoermerVerlet => Box::new(SolverVerlet::new(model)),
            Self::ExplicitEuler => explicit(Scheme::ExplicitEuler),
            Self::SymplecticEuler => explicit(Scheme::SymplecticEuler),
            Self::VelocityVerlet => explicit(Scheme::VelocityVerlet),
            Self::VelocityVerletLagged => explicit(Scheme::VelocityVerletLagged),
        })
    }
}
