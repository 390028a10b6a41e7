//! Inflation and extension of the two-layer carotid: elements against the balance along the radius.

use crate::slice::{Cells, Part, Slice};
use microsim_tests::vessel::carotid::{INNER_RADIUS, layers};
use microsim_tests::vessel::tube::Tube;
use microsim_tissue::Discretisation;

/// Axial stretches without pressure, then pressures \[Pa\] at the last of them.
const STRETCHES: [f64; 7] = [1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7];
const STEP: f64 = 1e3;
const PRESSURES: [f64; 4] = [4e3, 8e3, 12e3, 16e3];

/// Relative errors of inner radius, outer radius and axial force: at the last stretch without pressure, and at each pressure.
fn errors(discretisation: Discretisation, cells: Cells) -> Vec<[f64; 3]> {
    let layers = layers(0.49, INNER_RADIUS, 0.0);
    let tube = Tube::new(&layers);
    let mut slice = Slice::new(
        &layers,
        &tube.at_stretch(0.0, 1.0),
        Part::Quarter,
        cells,
        discretisation,
    );
    let mut errors = Vec::new();
    let mut compare = |slice: &Slice, pressure: f64, along: f64| {
        let exact = tube.at_stretch(pressure, along);
        let [inner, outer] = slice.radii();
        let error = [
            inner / exact.inside.radius - 1.0,
            outer / exact.outer_radius() - 1.0,
            slice.force() / exact.force - 1.0,
        ];
        let [inner, outer, force] = error.map(|e| 100.0 * e);
        println!(
            "{} {cells:?}, {:.0} kPa, {along}: {inner:+.2} %, {outer:+.2} %, {force:+.2} %",
            discretisation.name(),
            pressure * 1e-3
        );
        errors.push(error);
    };
    STRETCHES.iter().for_each(|along| slice.load(0.0, *along));
    let along = STRETCHES[STRETCHES.len() - 1];
    compare(&slice, 0.0, along);
    for k in 1..=16 {
        let pressure = f64::from(k) * STEP;
        slice.load(pressure, along);
        if PRESSURES.contains(&pressure) {
            compare(&slice, pressure, along);
        }
    }
    errors
}

/// The mesh of a level and two finer ones.
fn meshes() -> [Cells; 3] {
    [1, 2, 4].map(|through| Cells {
        through,
        around: 20 * through,
    })
}

#[test]
fn explore() {
    let list = std::env::var("D").unwrap_or_default();
    for discretisation in Discretisation::ALL {
        if list.contains(discretisation.name()) {
            meshes().map(|cells| errors(discretisation, cells));
        }
    }
}
