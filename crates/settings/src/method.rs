//! How bodies are advanced: the method and its parameters, and what accuracy is stated of the result. Levels and scenes
//! have them in common.

use crate::document::Reading;
use crate::error::KeyPath;
use crate::kinds::{list, number, quantity, ratio, time};
use crate::table::table;
use microsim_vocabulary::{MethodName, Unit};

table! {
    /// A method with the parameters that a file gives; the rest is the method's own.
    #[derive(Copy)]
    pub struct Method {
        /// Integrator or solver of the equations of motion.
        name: MethodName,
        /// Of implicit methods: largest number in a step. Of xpbd: number in a sub-step. The method's own if left
        /// out.
        iterations: Option<u32> [1, 10_000],
        /// Of implicit methods: fraction of the forces at which iterations end; linear systems are solved to a tenth of
        /// it, so 0.01 is enough for a single iteration. The method's own if left out.
        tolerance: Option<f64> = quantity(Unit::Ratio, 1e-15, 1.0),
        /// Of implicit methods: whether a step that ends above the tolerance fails; it does if left out.
        must_converge: Option<bool>,
        /// Of implicit methods, in levels and in scenes with containment: whether a tick whose forces mean nothing is computed again; it is
        /// if left out.
        repeat_invalid: Option<bool>,
        /// Of xpbd: sub-steps in a step; 10 if left out.
        substeps: Option<u32> [1, 10_000],
    }
}

table! {
    /// What is stated of the result.
    #[derive(Copy)]
    pub struct Accuracy {
        /// Largest relative error that the file states.
        error: f64 = quantity(Unit::Ratio, 1e-6, 1.0),
        /// Factor that must lie between the step and the largest stable one.
        stability_margin: f64 = quantity(Unit::Ratio, 1.0, 100.0) => 1.5,
        /// Largest CPU time per simulated time, contact and cutting not counted; any if left out.
        cost: Option<f64> = quantity(Unit::Ratio, 1e-6, 1e6),
    }
}

table! {
    /// What `microsim tune` chose, and what it measured.
    pub struct Tuned {
        /// Command line that chose it.
        command: Option<String>,
        /// Method.
        method: Option<String>,
        /// Step of the solver \[s\].
        step: Option<f64> = time(1e-9, 1.0),
        /// Number of tetrahedra.
        elements: Option<u32> [1, 100_000_000],
        /// Largest relative error that was measured.
        error: Option<f64> = ratio(f64::INFINITY),
        /// Factor between the step and the largest stable one that was measured.
        margin: Option<f64> = ratio(f64::INFINITY),
        /// CPU time per simulated time.
        cost: Option<f64> = ratio(f64::INFINITY),
        /// Values of what was compared, in SI, from the exact solution on a fine mesh: the measure where nothing is
        /// known from outside.
        measure: Vec<f64> = list(number(), 0, 64),
        /// How far that measure may be off itself: the largest relative difference to a mesh of two thirds of its
        /// cells.
        doubt: Option<f64> = ratio(f64::INFINITY),
        /// Relative error of plain linear tetrahedra, which lock, on the chosen mesh.
        locking: Option<f64> = ratio(f64::INFINITY),
        /// What was rejected, and why: a sentence each.
        rejected: Vec<String> [0, 256],
    }
}

/// Complains about parameters that the method at `key` does not have.
pub(crate) fn check_method(reading: &mut Reading, key: &KeyPath) {
    let name = reading
        .value()
        .pointer("/method/name")
        .and_then(|name| MethodName::from_name(name.as_str()?));
    let Some(method) = name else { return };
    let own = method.parameters();
    for parameter in [
        "iterations",
        "tolerance",
        "must_converge",
        "repeat_invalid",
        "substeps",
    ] {
        let key = key.key(parameter);
        if reading.is_written(&key) && !own.contains(&parameter) {
            let expected = format!("no `{parameter}`, which {} does not have", method.name());
            reading.complain(&key, &format!("`{parameter}`"), &expected);
        }
    }
}
