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

/// One cell a layer and 20 around, as levels have them, and finer ones.
fn cells(through: usize) -> Cells {
    Cells {
        through,
        around: 20 * through,
    }
}

/// The error of linear elements is of the second order in the size of the cells. It comes near from below: fibres stiffen exponentially, and the wall
/// is stretched most inside, so that the coarsest mesh is not in the range where it falls so. Measured on the inner radius, from the second to
/// the third mesh: 1.65 to 2.0. Orders and the decrease from mesh to mesh are the checks; `recorded` is no derived bound, but a little above the largest
/// error on the cells of a level that was recorded, so that a change of it is seen, as are those of radius and force on the last mesh.
fn assert_second_order(discretisation: Discretisation, recorded: f64) {
    let [coarse, middle, fine] = [1, 2, 4].map(|through| errors(discretisation, cells(through)));
    for load in 0..coarse.len() {
        let [coarse, middle, fine] = [&coarse, &middle, &fine].map(|of| of[load][0].abs());
        let order = libm::log2(middle / fine);
        println!("{}: order {order:.2}", discretisation.name());
        assert!((1.5..2.5).contains(&order), "{load}: {middle} {fine}");
        assert!(
            coarse < recorded && coarse > 2.0 * middle,
            "{load}: {coarse}"
        );
    }
    // Radii of the last mesh, and its force, whose error is two to three times as large.
    let last = fine[fine.len() - 1];
    assert!(last[1].abs() < 0.01 && last[2].abs() < 0.02, "{last:?}");
}

/// Errors of the inner radius at 16 kPa and a stretch of 1.7 with the cells of a level, as recorded: 5.8 %; of the axial force 10.5 %.
#[test]
fn tetrahedra_converge() {
    assert_second_order(Discretisation::Tetrahedra, 0.06);
}

/// Recorded: 3.2 %; of the axial force 7.3 %.
#[test]
fn selective_tetrahedra_converge() {
    assert_second_order(Discretisation::Selective, 0.035);
}

/// Recorded: 5.9 %; of the axial force 11.6 %.
#[test]
fn tetrahedra_with_pressures_of_patches_converge() {
    assert_second_order(Discretisation::PatchPressure, 0.06);
}

/// Recorded: 1.0 %, the wall too wide, and 2.7 % of the axial force; twice as fine 0.3 % and 0.8 %. The decrease is the check.
#[test]
fn quadratic_tetrahedra_converge() {
    let [coarse, fine] =
        [1, 2].map(|through| errors(Discretisation::QuadraticPressure, cells(through)));
    for (coarse, fine) in coarse.iter().zip(&fine) {
        assert!(
            coarse[0].abs() < 0.012 && coarse[2].abs() < 0.03,
            "{coarse:?}"
        );
        assert!(fine[0].abs() < 0.5 * coarse[0].abs(), "{coarse:?} {fine:?}");
    }
}
