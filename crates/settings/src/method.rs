//! How bodies are advanced: the method and its parameters, and what accuracy is stated of the result. Levels and scenes
//! share them.

use crate::document::Reading;
use crate::error::KeyPath;
use crate::schema::{Key, Kind};
use microsim_vocabulary::{MethodName, Unit};
use serde::{Deserialize, Serialize};

/// A method with the parameters that a file gives; the rest is the method's own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Method {
    /// Which.
    pub name: MethodName,
    /// Largest number of iterations in a step, or in a sub-step.
    pub iterations: Option<u32>,
    /// Share of the forces at which an iteration ends.
    pub tolerance: Option<f64>,
    /// Whether a step that ends above the tolerance fails.
    pub must_converge: Option<bool>,
    /// Sub-steps in a step.
    pub substeps: Option<u32>,
}

/// The parameters that a method has.
fn parameters(method: MethodName) -> &'static [&'static str] {
    match method {
        MethodName::ImplicitEuler
        | MethodName::ImplicitMidpoint
        | MethodName::GuardedMidpoint
        | MethodName::Sdirk2
        | MethodName::QuasiStatic => &["iterations", "tolerance", "must_converge"],
        MethodName::Xpbd => &["iterations", "substeps"],
        MethodName::StoermerVerlet
        | MethodName::ExplicitEuler
        | MethodName::SymplecticEuler
        | MethodName::VelocityVerlet
        | MethodName::VelocityVerletLagged => &[],
    }
}

/// What is stated of the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Accuracy {
    /// Largest relative error.
    pub error: f64,
    /// Factor between the step and the largest stable one.
    pub stability_margin: f64,
    /// Largest CPU time per simulated time; any if `None`.
    pub cost: Option<f64>,
}

/// What `microsim tune` chose, and what it measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuned {
    /// Command line that chose it.
    pub command: Option<String>,
    /// Method.
    pub method: Option<String>,
    /// Step \[s\].
    pub step: Option<f64>,
    /// Number of tetrahedra.
    pub elements: Option<u32>,
    /// Largest relative error that was measured.
    pub error: Option<f64>,
    /// Factor between the step and the largest stable one that was measured.
    pub margin: Option<f64>,
    /// CPU time per simulated time.
    pub cost: Option<f64>,
    /// Values of what was compared, in SI, from the exact solution on a fine mesh: the measure where nothing is known from
    /// outside.
    pub measure: Vec<f64>,
    /// How far that measure may be off itself: the largest relative difference to a mesh of two thirds of its cells.
    pub doubt: Option<f64>,
    /// Relative error of plain linear tetrahedra, which lock, on the chosen mesh.
    pub locking: Option<f64>,
    /// What was rejected, and why: a sentence each.
    pub rejected: Vec<String>,
}

/// The keys of a method.
pub(crate) fn method_keys() -> Vec<Key> {
    vec![
        Key::required(
            "name",
            Kind::choice(&MethodName::NAMES),
            "Integrator or solver of the equations of motion.",
        ),
        Key::optional(
            "iterations",
            Kind::Integer {
                min: 1,
                max: 10_000,
            },
            "Of implicit methods: largest number in a step. Of xpbd: number in a sub-step. The method's own if left out.",
        ),
        Key::optional(
            "tolerance",
            Kind::quantity(Unit::Ratio, 1e-15, 1.0),
            "Of implicit methods: share of the forces at which iterations end; linear systems are solved to a tenth of it, so 0.01 is enough for a single iteration. The method's own if left out.",
        ),
        Key::optional(
            "must_converge",
            Kind::Bool,
            "Of implicit methods: whether a step that ends above the tolerance fails; it does if left out.",
        ),
        Key::optional(
            "substeps",
            Kind::Integer {
                min: 1,
                max: 10_000,
            },
            "Of xpbd: sub-steps in a step; 10 if left out.",
        ),
    ]
}

/// The keys of a statement of accuracy.
pub(crate) fn accuracy_keys() -> Vec<Key> {
    vec![
        Key::required(
            "error",
            Kind::quantity(Unit::Ratio, 1e-6, 1.0),
            "Largest relative error that the file states.",
        ),
        Key::with_default(
            "stability_margin",
            Kind::quantity(Unit::Ratio, 1.0, 100.0),
            "Factor that must lie between the step and the largest stable one.",
            1.5,
        ),
        Key::optional(
            "cost",
            Kind::quantity(Unit::Ratio, 1e-6, 1e6),
            "Largest CPU time per simulated time, contact and cutting not counted; any if left out.",
        ),
    ]
}

/// The keys of what `microsim tune` writes.
pub(crate) fn tuned_keys() -> Vec<Key> {
    let share = || Kind::quantity(Unit::Ratio, 0.0, f64::INFINITY);
    vec![
        Key::optional("command", Kind::Text, "Command line that chose it."),
        Key::optional("method", Kind::Text, "Method."),
        Key::optional(
            "step",
            Kind::quantity(Unit::Time, 1e-9, 1.0),
            "Step of the solver.",
        ),
        Key::optional(
            "elements",
            Kind::Integer {
                min: 1,
                max: 100_000_000,
            },
            "Number of tetrahedra.",
        ),
        Key::optional(
            "error",
            share(),
            "Largest relative error that was measured.",
        ),
        Key::optional(
            "margin",
            share(),
            "Factor between the step and the largest stable one that was measured.",
        ),
        Key::optional("cost", share(), "CPU time per simulated time."),
        Key::list(
            "measure",
            Kind::quantity(Unit::Ratio, f64::NEG_INFINITY, f64::INFINITY),
            64,
            "Values of what was compared, in SI, from the exact solution on a fine mesh: the measure where nothing is known from outside.",
        ),
        Key::optional(
            "doubt",
            share(),
            "How far that measure may be off itself: the largest relative difference to a mesh of two thirds of its cells.",
        ),
        Key::optional(
            "locking",
            share(),
            "Relative error of plain linear tetrahedra, which lock, on the chosen mesh.",
        ),
        Key::list(
            "rejected",
            Kind::Text,
            256,
            "What was rejected, and why: a sentence each.",
        ),
    ]
}

/// Complains about parameters that the method at `key` does not have.
pub(crate) fn check_method(reading: &mut Reading, key: &KeyPath) {
    let name = reading
        .value()
        .pointer("/method/name")
        .and_then(|name| MethodName::from_name(name.as_str()?));
    let Some(method) = name else { return };
    let own = parameters(method);
    for parameter in ["iterations", "tolerance", "must_converge", "substeps"] {
        let key = key.key(parameter);
        if reading.is_written(&key) && !own.contains(&parameter) {
            let expected = format!("no `{parameter}`, which {} does not have", method.name());
            reading.complain(&key, &format!("`{parameter}`"), &expected);
        }
    }
}
