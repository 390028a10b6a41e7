//! Inflation and extension of the two-layer carotid: elements against the balance along the radius.

use crate::slice::{Cells, LEVEL, Part, Slice};
use microsim_mesh::CellSplit;
use microsim_tests::vessel::carotid::{INNER_RADIUS, layers};
use microsim_tests::vessel::tube::Tube;
use microsim_tissue::Discretisation;
use std::f64::consts::TAU;

/// Axial stretches without pressure, then pressures \[Pa\] at the last of them.
const STRETCHES: [f64; 7] = [1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7];
const STEP: f64 = 1e3;
const PRESSURES: [f64; 4] = [4e3, 8e3, 12e3, 16e3];

/// Relative errors of inner radius, outer radius and axial force: at the last stretch without pressure, and at each pressure.
fn errors(discretisation: Discretisation, cells: Cells) -> Vec<[f64; 3]> {
    errors_of(0.49, Part::Quarter, discretisation, cells)
}

/// The same with another Poisson's ratio of the matrix, or of a whole ring.
fn errors_of(
    poisson: f64,
    part: Part,
    discretisation: Discretisation,
    cells: Cells,
) -> Vec<[f64; 3]> {
    let layers = layers(poisson, INNER_RADIUS, 0.0);
    let tube = Tube::new(&layers);
    let mut slice = Slice::new(
        &layers,
        &tube.at_stretch(0.0, 1.0),
        part,
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
            "{} {part:?} {cells:?}, ν {poisson}, {:.0} kPa, {along}: {inner:+.2} %, {outer:+.2} %, {force:+.2} %, inner nodes {:.2} % apart",
            discretisation.name(),
            pressure * 1e-3,
            100.0 * slice.spread()
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

/// The error of linear elements is of the second order in the size of the cells. It comes near from below: fibres stiffen exponentially, and the wall
/// is stretched most inside, so that the coarsest mesh is not in the range where it falls so. Measured on the inner radius, from the second to
/// the third mesh: 1.65 to 2.0. Orders and the decrease from mesh to mesh are the checks; `recorded` is no derived bound, but a little above the largest
/// error on the cells of a level that was recorded, so that a change of it is seen, as are those of radius and force on the last mesh.
fn assert_second_order(discretisation: Discretisation, recorded: f64) {
    let [coarse, middle, fine] =
        [1, 2, 4].map(|through| errors(discretisation, Cells::equal(through, CellSplit::Mirrored)));
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
    let [coarse, fine] = [1, 2].map(|through| {
        errors(
            Discretisation::QuadraticPressure,
            Cells::equal(through, CellSplit::Mirrored),
        )
    });
    for (coarse, fine) in coarse.iter().zip(&fine) {
        assert!(
            coarse[0].abs() < 0.012 && coarse[2].abs() < 0.03,
            "{coarse:?}"
        );
        assert!(fine[0].abs() < 0.5 * coarse[0].abs(), "{coarse:?} {fine:?}");
    }
}

/// With five elements a cell the radius under pressure converges faster than the second order on these meshes (recorded 1.6 %, 0.32 %, 0.04 %), so at least by four
/// from mesh to mesh, and the force, with what the section of the polygon lacks, with it.
#[test]
fn five_elements_a_cell_converge() {
    let [coarse, middle, fine] = [1, 2, 4].map(|through| {
        errors(
            Discretisation::Selective,
            Cells::equal(through, CellSplit::Five),
        )
    });
    // The first load is without pressure, where the radius is within 0.02 % on all of them.
    for load in 0..coarse.len() {
        let of = |index: usize| [&coarse, &middle, &fine].map(|of| of[load][index].abs());
        let [radius, force] = [of(0), of(2)];
        let order = libm::log2(force[1] / force[2]);
        assert!((1.5..2.5).contains(&order), "{load}: {force:?}");
        match load {
            0 => assert!(radius[0] < 0.001, "{radius:?}"),
            _ => assert!(
                radius[0] < 0.0165 && radius[0] > 4.0 * radius[1] && radius[1] > 4.0 * radius[2],
                "{load}: {radius:?}"
            ),
        }
    }
}

/// Where the error of linear elements comes from, by one change at a time: neither the chords, nor the outer layer, nor the length of cells, nor locking
/// (ν = 0.3, and no part around nodes) is it, but the stretch that changes through the media, and the diagonals. What is no cause leaves at
/// least nine tenths of the error, what is one takes more than half of it.
#[test]
fn the_error_comes_from_the_media_and_the_diagonals() {
    use Discretisation::{EdgeSmoothed, Selective};
    let base = Cells {
        along: 4,
        ..Cells::equal(1, CellSplit::Mirrored)
    };
    let radius = |poisson: f64, discretisation: Discretisation, cells: Cells| {
        let errors = errors_of(poisson, Part::Ring, discretisation, cells);
        errors[errors.len() - 1][0].abs()
    };
    let of_base = radius(0.49, Selective, base);
    let no_causes = [
        (0.49, Selective, Cells { around: 40, ..base }),
        (
            0.49,
            Selective,
            Cells {
                through: [1, 2],
                slender: 1.5,
                ..base
            },
        ),
        (
            0.49,
            Selective,
            Cells {
                slender: 4.0,
                ..base
            },
        ),
        (0.3, Selective, base),
        (0.49, EdgeSmoothed, base),
    ];
    for (poisson, discretisation, cells) in no_causes {
        let error = radius(poisson, discretisation, cells);
        assert!(error > 0.9 * of_base, "{cells:?}: {error} {of_base}");
    }
    let media = Cells {
        through: [2, 1],
        slender: 1.5,
        ..base
    };
    for cells in [
        media,
        Cells {
            split: CellSplit::Five,
            ..base
        },
        Cells {
            split: CellSplit::Kuhn,
            ..base
        },
        Cells {
            split: CellSplit::Five,
            ..media
        },
    ] {
        let error = radius(0.49, Selective, cells);
        assert!(error < 0.5 * of_base, "{cells:?}: {error} {of_base}");
    }
}

/// The cells of a level with mirrored ones, and with discretisations of tetrahedra themselves: the radius of none is as near.
#[test]
fn five_elements_and_their_edges_are_nearest_on_the_mesh_of_a_level() {
    let radius = |discretisation: Discretisation, split: CellSplit| {
        let errors = errors_of(0.49, Part::Ring, discretisation, Cells { split, ..LEVEL });
        errors.iter().map(|e| e[0].abs()).fold(0.0, f64::max)
    };
    let chosen = radius(Discretisation::Selective, CellSplit::Five);
    for (discretisation, split) in [
        (Discretisation::Selective, CellSplit::Mirrored),
        (Discretisation::Selective, CellSplit::Kuhn),
        (Discretisation::PatchPressure, CellSplit::Five),
        (Discretisation::Tetrahedra, CellSplit::Five),
    ] {
        let other = radius(discretisation, split);
        assert!(
            other > 2.0 * chosen,
            "{discretisation:?} {split:?}: {other}"
        );
    }
}

/// What is asked of the mesh of a level: 1 % of the radius. The axial force lacks at least what the section of the polygon lacks to that of the
/// ring, 1 − sin(2π/n)/(2π/n) = 1.6 %; 1 % more is allowed. Recorded on the whole vessel: 0.19 % and 1.6 %, with mirrored cells 0.89 % and 5.8 %.
fn assert_level(slice: &mut Slice, tube: &Tube, along: f64) {
    let side = TAU / LEVEL.around as f64;
    let of_force = 1.0 - libm::sin(side) / side + 0.01;
    let mut largest = [0.0_f64; 2];
    // Without any load there is no force to compare.
    for k in i32::from(along <= 1.0)..=16 {
        let pressure = f64::from(k) * STEP;
        slice.load(pressure, along);
        let exact = tube.at_stretch(pressure, along);
        let errors = [
            slice.radii()[0] / exact.inside.radius - 1.0,
            slice.force() / exact.force - 1.0,
        ];
        for (largest, error) in largest.iter_mut().zip(errors) {
            *largest = largest.max(error.abs());
        }
        assert!(errors[0].abs() < 0.01, "{pressure} Pa, {along}: {errors:?}");
        assert!(
            errors[1].abs() < of_force,
            "{pressure} Pa, {along}: {errors:?}"
        );
    }
    let [radius, force] = largest.map(|e| 100.0 * e);
    println!("level, {along}: radius {radius:.2} %, force {force:.2} %");
}

/// All of the vessel at the stretch that it has in the body. At less its axial force is below p π r², and it bends like a column.
#[test]
fn the_vessel_of_a_level_is_within_one_per_cent() {
    let layers = layers(0.49, INNER_RADIUS, 0.0);
    let tube = Tube::new(&layers);
    let place = tube.at_stretch(0.0, 1.0);
    let mut slice = Slice::new(
        &layers,
        &place,
        Part::Ring,
        LEVEL,
        Discretisation::Selective,
    );
    STRETCHES.iter().for_each(|along| slice.load(0.0, *along));
    assert_level(&mut slice, &tube, STRETCHES[STRETCHES.len() - 1]);
}

/// A quarter of it, which cannot bend, at all stretches. Recorded: 0.33 % and 1.8 %.
#[test]
fn the_cells_of_a_level_are_within_one_per_cent_at_all_stretches() {
    let layers = layers(0.49, INNER_RADIUS, 0.0);
    let tube = Tube::new(&layers);
    let cells = Cells { along: 4, ..LEVEL };
    for count in [0, 2, 4, 6, 7] {
        let place = tube.at_stretch(0.0, 1.0);
        let mut slice = Slice::new(
            &layers,
            &place,
            Part::Quarter,
            cells,
            Discretisation::Selective,
        );
        let stretches = &STRETCHES[..count];
        stretches.iter().for_each(|along| slice.load(0.0, *along));
        let along = stretches.last().copied().unwrap_or(1.0);
        assert_level(&mut slice, &tube, along);
    }
}
