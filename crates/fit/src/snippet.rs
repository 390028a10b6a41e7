//! A fit as a `[[body.material]]` of a scene or level.

use crate::constant::{ANGLE, rounded};
use crate::estimate::{Determination, Estimate, Fit};
use microsim_settings::Discretisation;
use std::fmt::Write;

/// Density of soft tissue \[kg/m³\]: stresses do not determine it.
const DENSITY: f64 = 1060.0;

/// Poisson's ratio from which on tetrahedra of one F each lock: they are too stiff wherever the volume hardly changes.
const LOCKS: f64 = 0.4;

/// The material, as TOML with a remark behind each value. Every number comes back to the last bit.
pub fn material_toml(fit: &Fit) -> String {
    let mut text = format!(
        "[[body.material]]\nlaw = \"{}\"\ndensity = {DENSITY:?} # kg/m^3, not fitted: that of soft tissue\n",
        fit.law.name()
    );
    for estimate in &fit.estimates {
        let value = estimate.value;
        let assignment = match estimate.constant.key {
            // Written by `ANGLE`, a path: the table holds one key.
            ANGLE => format!("fibres = {{ angle = {value:?} }}"),
            key => format!("{key} = {value:?}"),
        };
        // Writing to a text never fails.
        let _ = writeln!(text, "{assignment} # {}", remark(estimate));
    }
    let locks =
        |estimate: &Estimate| estimate.constant.key == "poisson_ratio" && estimate.value >= LOCKS;
    if fit.estimates.iter().any(locks) {
        let name = Discretisation::Selective.name();
        let _ = writeln!(
            text,
            "discretisation = \"{name}\" # tetrahedra alone lock where the volume hardly changes"
        );
    }
    text
}

/// The value for people, and how well it is known.
fn remark(estimate: &Estimate) -> String {
    let unit = estimate.constant.unit;
    let known = match estimate.determination {
        Determination::Within(half) => format!("+- {} (95 %)", rounded(unit, half)),
        other => other.name().to_owned(),
    };
    format!("{}, {known}", rounded(unit, estimate.value))
}
