//! What `tune` has found, for programs.

use super::{Figure, Target};
use microsim_study::{Goal, Trial, Tuning};
use serde_json::{Value, json};
use std::path::PathBuf;

/// A choice with all that was tried.
pub fn tuning(target: &Target, tuning: &Tuning, goal: &Goal, written: Option<&PathBuf>) -> Value {
    json!({
        "file": target.path,
        "demanded": demanded(goal),
        "chosen": tuning.choice().map(trial),
        "trials": tuning.trials.iter().map(trial).collect::<Vec<_>>(),
        "measure": tuning.measure,
        "doubt": tuning.doubt,
        "error_of_linear_tetrahedra": tuning.locking,
        "written": written,
    })
}

/// What was measured again.
pub fn verification(
    target: &Target,
    figures: &[Figure],
    (cost, stated): (Option<f64>, Option<f64>),
    goal: &Goal,
    confirmed: bool,
) -> Value {
    let figures = figures.iter().map(|figure| {
        json!({
            "figure": figure.name, "found": figure.found, "stated": figure.stated, "confirmed": figure.confirmed,
        })
    });
    json!({
        "file": target.path,
        "demanded": demanded(goal),
        "figures": figures.collect::<Vec<_>>(),
        "cost": { "found": cost, "stated": stated, "unit": goal.cost_unit() },
        "confirmed": confirmed,
    })
}

fn demanded(goal: &Goal) -> Value {
    let cost = goal.cost.is_finite().then_some(goal.cost);
    json!({ "error": goal.error, "margin": goal.margin, "cost": cost, "cost_unit": goal.cost_unit() })
}

fn trial(trial: &Trial) -> Value {
    json!({
        "description": trial.description,
        "kind": trial.kind,
        "overrides": trial.overrides,
        "method": trial.method,
        "step_s": trial.step.is_finite().then_some(trial.step),
        "elements": trial.elements,
        "error": trial.error,
        "cost": trial.cost,
        "margin": trial.margin,
        "rejected": trial.rejected,
    })
}
