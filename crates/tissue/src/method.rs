//! The methods by name: one list for files, reports and comparisons.

use crate::model::TissueModel;
use crate::solver::Solver;
use crate::solver_verlet::SolverVerlet;

/// A method with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Störmer–Verlet in the joint form, drag by the exact factor.
    StoermerVerlet,
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
        }
    }

    /// Whether its step is bounded by [`stability::stable_step`](crate::stability::stable_step).
    pub fn is_explicit(&self) -> bool {
        match self {
            Self::StoermerVerlet => true,
        }
    }

    /// Whether a node can be led to a target within one step ([`Contacts`](crate::Contacts)).
    pub fn leads_nodes(&self) -> bool {
        match self {
            Self::StoermerVerlet => true,
        }
    }

    /// A solver for `model`.
    pub fn solver(&self, model: &TissueModel) -> Result<Box<dyn Solver>, MethodError> {
        Ok(match self {
            Self::StoermerVerlet => Box::new(SolverVerlet::new(model)),
        })
    }
}
