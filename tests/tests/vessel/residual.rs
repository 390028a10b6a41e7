//! The residual state: where the natural state of a wall is found from, that it is in equilibrium, how it opens and how it retracts.

use crate::law::{directions, law_of};
use crate::slice::{Cells, LEVEL, Part, Slice};
use microsim_mesh::CellSplit;
use microsim_tests::vessel::carotid::{OPENED_RADIUS, OPENING, PRESSURE, STRETCH, layers};
use microsim_tests::vessel::layers::Layer;
use microsim_tests::vessel::radial::Profile;
use microsim_tests::vessel::tube::Tube;
use microsim_tissue::vessel_wall::{VesselWall, WallLayer};
use microsim_tissue::{ContinuumConstants, Discretisation};
use std::f64::consts::TAU;

/// The natural radius of the outer layer at which both have one stretch around where they meet, with opening angles of their own \[rad\].
fn grown(poisson: f64, openings: [f64; 2]) -> [Layer; 2] {
    let mut layers = layers(poisson, OPENED_RADIUS, 0.0);
    for (layer, opening) in layers.iter_mut().zip(openings) {
        layer.sector = TAU - opening;
    }
    layers[1].inner_radius = layers[0].outer_radius() * layers[0].sector / layers[1].sector;
    layers
}

/// The wall in the place of a profile, as `VesselWall` takes it.
fn wall(layers: &[Layer], place: &Profile) -> VesselWall {
    let of = |(index, layer): (usize, &Layer)| WallLayer {
        radii: place.radii(index),
        constants: ContinuumConstants {
            law: law_of(&layer.wall),
            young: layer.wall.young(),
            poisson: layer.wall.poisson(),
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        },
        directions: directions(&layer.wall),
        opening_angle: TAU - layer.sector,
    };
    VesselWall {
        layers: layers.iter().enumerate().map(of).collect(),
        axial_stretch: place.inside.along,
        pressure: place.inside.pressure,
    }
}

/// From the natural state to the place and back: tubes are loaded here from natural states that are given, and `VesselWall` finds the stretches from
/// the places alone. Both have errors of 1e-8 by their steps; it is linear between 128 of them, which adds 1e-4 of the change of a
/// stretch through the layer at most (1/8 of the square of a step times the second derivative): 1e-5 of stretches that change by tenths.
#[test]
fn stretches_are_found_from_the_place() {
    for (poisson, openings) in [
        (0.49, [0.0, 0.0]),
        (0.49, [OPENING, OPENING]),
        (0.49, [OPENING, 1.0]),
        (0.49, [0.8, OPENING]),
        (0.45, [OPENING, OPENING]),
    ] {
        let layers = grown(poisson, openings);
        for (pressure, along) in [(0.0, 1.0), (0.0, 1.5), (PRESSURE, 1.0), (PRESSURE, STRETCH)] {
            let place = Tube::new(&layers).at_stretch(pressure, along);
            let found = wall(&layers, &place).stretches();
            let found = found.unwrap_or_else(|e| panic!("{openings:?} {pressure} {along}: {e}"));
            let mut largest = 0.0_f64;
            for point in &place.points {
                // Within the layer: where layers meet, both have a stretch through the wall of their own.
                let [inner, outer] = place.radii(point.layer);
                let radius = point
                    .radius
                    .clamp(inner * (1.0 + 1e-9), outer * (1.0 - 1e-9));
                let stretches = found.at(radius);
                for i in 0..3 {
                    largest = largest.max((stretches[i] / point.stretches[i] - 1.0).abs());
                }
            }
            println!("{poisson} {openings:?} {pressure} {along}: {largest:.1e}");
            assert!(
                largest < 1e-5,
                "{poisson} {openings:?} {pressure} {along}: {largest}"
            );
        }
    }
}

/// What a slice of the carotid with its opening angle, at its mean pressure and stretch, comes to: relative errors of the inner radius there, without
/// pressure, and with the axial stretch that leaves no force; and of that stretch.
fn errors(discretisation: Discretisation, cells: Cells) -> [f64; 4] {
    let layers = grown(0.49, [OPENING; 2]);
    let tube = Tube::new(&layers);
    let place = tube.at_stretch(PRESSURE, STRETCH);
    let mut slice = Slice::new(&layers, &place, Part::Quarter, cells, discretisation);
    let inner = |slice: &Slice, exact: &Profile| slice.radii()[0] / exact.inside.radius - 1.0;
    slice.load(PRESSURE, 1.0);
    let at_rest = inner(&slice, &place);
    for pressure in [10e3, 6e3, 3e3, 1e3, 0.0] {
        slice.load(pressure, 1.0);
    }
    let empty = inner(&slice, &tube.at_stretch(0.0, STRETCH));
    let free = tube.at_force(0.0, 0.0);
    let drawn_back = free.inside.along / STRETCH;
    for k in 1..=5 {
        slice.load(0.0, 1.0 + 0.2 * f64::from(k) * (drawn_back - 1.0));
    }
    let divided = inner(&slice, &free);
    // The stretch without force, by the slope between two near it.
    let force = slice.force();
    slice.load(0.0, 1.01 * drawn_back);
    let stretch = -0.01 * force / (slice.force() - force);
    let errors = [at_rest, empty, divided, stretch];
    println!(
        "{} {cells:?}: {:?} %",
        discretisation.name(),
        errors.map(|e| 100.0 * e)
    );
    errors
}

/// In the place that its prestretches were computed for the wall is in equilibrium up to the size of the cells; emptied it narrows, and divided
/// it shortens and widens, as the tube does. All errors fall from mesh to mesh, at least by half: that is the check. `recorded` are no derived bounds,
/// but a little above the errors on the first mesh that were recorded, so that a change of them is seen.
fn assert_residual_state(discretisation: Discretisation, meshes: &[usize], recorded: [f64; 4]) {
    let errors: Vec<[f64; 4]> = meshes
        .iter()
        .map(|through| errors(discretisation, mirrored(*through)))
        .collect();
    for (i, recorded) in recorded.into_iter().enumerate() {
        assert!(errors[0][i].abs() < recorded, "{i}: {:?}", errors[0]);
        for pair in errors.windows(2) {
            assert!(pair[1][i].abs() < 0.5 * pair[0][i].abs(), "{i}: {errors:?}");
        }
    }
}

#[test]
fn the_residual_state_of_selective_tetrahedra_is_that_of_the_tube() {
    let recorded = [0.013, 0.05, 0.03, 0.03];
    assert_residual_state(Discretisation::Selective, &[1, 2, 4], recorded);
}

#[test]
fn the_residual_state_of_tetrahedra_with_pressures_of_patches_is_that_of_the_tube() {
    let recorded = [0.006, 0.05, 0.02, 0.03];
    assert_residual_state(Discretisation::PatchPressure, &[1, 2, 4], recorded);
}

#[test]
fn the_residual_state_of_quadratic_tetrahedra_is_that_of_the_tube() {
    let recorded = [0.002, 0.003, 0.002, 0.002];
    assert_residual_state(Discretisation::QuadraticPressure, &[1], recorded);
}

/// A vessel of a level, as those of `config/vessels` are: it lies without pressure, stretched between clamps, with its opening angle. The largest errors of
/// radius and axial force from there to 16 kPa.
fn level_errors(split: CellSplit) -> [f64; 2] {
    let layers = grown(0.49, [OPENING; 2]);
    let tube = Tube::new(&layers);
    let place = tube.at_stretch(0.0, STRETCH);
    let cells = Cells { split, ..LEVEL };
    let mut slice = Slice::new(
        &layers,
        &place,
        Part::Ring,
        cells,
        Discretisation::Selective,
    );
    let mut largest = [0.0_f64; 2];
    for k in 0..=16 {
        let pressure = 1e3 * f64::from(k);
        slice.load(pressure, 1.0);
        let exact = tube.at_stretch(pressure, STRETCH);
        largest[0] = largest[0].max((slice.radii()[0] / exact.inside.radius - 1.0).abs());
        largest[1] = largest[1].max((slice.force() / exact.force - 1.0).abs());
    }
    println!(
        "level in place, {split:?}: {:?} %",
        largest.map(|e| 100.0 * e)
    );
    largest
}

/// Of the radius 1 %, which is what is asked of the mesh of a level. Recorded: 0.8 %, and 3.2 % of the force; mirrored cells miss it with 1.9 % and 6.8 %.
#[test]
fn the_vessel_of_a_level_is_within_one_per_cent_of_its_place() {
    let [five, mirrored] = [CellSplit::Five, CellSplit::Mirrored].map(level_errors);
    assert!(five[0] < 0.01, "{five:?}");
    assert!(
        mirrored[0] > 2.0 * five[0] && mirrored[1] > 2.0 * five[1],
        "{five:?} {mirrored:?}"
    );
}

/// A wall that is stated in place under its pressure lies less well: domains around edges average prestretches whose axes turn around the wall. `recorded`
/// are no derived bounds, as above.
#[test]
fn the_wall_of_a_level_under_pressure_is_near_its_place() {
    let found = errors(Discretisation::Selective, Cells { along: 4, ..LEVEL });
    for (error, recorded) in found.iter().zip([0.008, 0.022, 0.018, 0.004]) {
        assert!(error.abs() < recorded, "{found:?}");
    }
}

fn mirrored(through: usize) -> Cells {
    Cells::equal(through, CellSplit::Mirrored)
}

/// How far a slit ring of the unloaded carotid opens, over what it should.
fn opening(discretisation: Discretisation, cells: Cells, openings: [f64; 2]) -> f64 {
    let layers = grown(0.49, openings);
    let tube = Tube::new(&layers);
    let (place, slit) = (tube.at_force(0.0, 0.0), tube.slit());
    let mut slice = Slice::new(&layers, &place, Part::Slit, cells, discretisation);
    slice.load(0.0, slit.inside.along / place.inside.along);
    let ratio = (TAU - slice.angle()) / (TAU - slit.inside.angle);
    println!(
        "{} {cells:?} {openings:?}: {:.1} %",
        discretisation.name(),
        100.0 * ratio
    );
    ratio
}

/// By 160° if both layers are of sectors of 200°, by 154° if the outer one is of 303°. Quadratic tetrahedra, one a layer, open by 103 % of it.
#[test]
fn a_slit_ring_opens_by_its_opening_angle() {
    for openings in [[OPENING; 2], [OPENING, 1.0]] {
        let [coarse, fine] = [1, 2]
            .map(mirrored)
            .map(|cells| opening(Discretisation::QuadraticPressure, cells, openings) - 1.0);
        assert!(coarse.abs() < 0.035, "{coarse}");
        assert!(fine.abs() < 0.5 * coarse.abs(), "{coarse} {fine}");
    }
}

/// Two cells through the media and five tetrahedra in each, as levels have them, open it to 80 %, twice as far as one cell a layer; recorded, within 0.02.
#[test]
fn a_slit_ring_of_the_cells_of_a_level_opens_less() {
    let cells = Cells { along: 4, ..LEVEL };
    let found = opening(Discretisation::Selective, cells, [OPENING; 2]);
    assert!((found - 0.80).abs() < 0.02, "{found}");
}

/// Linear tetrahedra are too stiff in bending, which is all that opens a ring: with one or two cells a layer it opens by much less. As the
/// lack is of the second order in the size it falls to between a quarter and a half, where it is below 30 % to less than 0.35 of it: that is the check. The lack on the cells of a level is
/// a recorded value, within 0.02.
#[test]
fn a_slit_ring_of_linear_tetrahedra_opens_less() {
    for (discretisation, recorded) in [
        (Discretisation::Tetrahedra, 0.36),
        (Discretisation::Selective, 0.42),
        (Discretisation::PatchPressure, 0.36),
    ] {
        let [coarse, middle, fine] = [1, 2, 4]
            .map(mirrored)
            .map(|cells| 1.0 - opening(discretisation, cells, [OPENING; 2]));
        assert!((coarse - 1.0 + recorded).abs() < 0.02, "{coarse}");
        assert!(
            middle < 0.5 * coarse && fine < 0.35 * middle,
            "{coarse} {middle} {fine}"
        );
        assert!(fine > 0.0, "{fine}");
    }
}
