//! The residual state: where the natural state of a wall is found from, that it is in equilibrium, how it opens and how it retracts.

use crate::law::{directions, law_of};
use crate::slice::{Cells, Part, Slice};
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
        (0.45, [OPENING, OPENING]),
        (0.49, [OPENING, 1.0]),
        (0.49, [0.8, OPENING]),
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

#[test]
fn explore() {
    for (name, openings) in [("alike", [OPENING, OPENING]), ("unlike", [OPENING, 1.0])] {
        let layers = grown(0.49, openings);
        let tube = Tube::new(&layers);
        let place = tube.at_stretch(PRESSURE, STRETCH);
        let free = tube.at_force(0.0, 0.0);
        let slit = tube.slit();
        println!(
            "{name}: free {} {} {}; slit {} {} {}",
            free.inside.radius,
            free.outer_radius(),
            free.inside.along,
            slit.inside.angle,
            slit.inside.radius,
            slit.inside.along
        );
        for discretisation in [
            Discretisation::Tetrahedra,
            Discretisation::Selective,
            Discretisation::PatchPressure,
            Discretisation::QuadraticPressure,
        ] {
            for k in [1, 2, 4] {
                if k == 4 && discretisation.is_quadratic() {
                    continue;
                }
                let cells = Cells {
                    through: k,
                    around: 20 * k,
                };
                let mut slice = Slice::new(&layers, &place, Part::Quarter, cells, discretisation);
                let mut line = format!("{} {k}:", discretisation.name());
                let mut report = |slice: &Slice, exact: &Profile| {
                    let r = slice.radii();
                    line += &format!(
                        " | {:+.2} {:+.2} % F {:+.3} mN of {:.3}",
                        100.0 * (r[0] / exact.inside.radius - 1.0),
                        100.0 * (r[1] / exact.outer_radius() - 1.0),
                        1e3 * slice.force(),
                        1e3 * exact.force
                    );
                };
                slice.load(PRESSURE, 1.0);
                report(&slice, &place);
                for p in [10e3, 6e3, 3e3, 1e3, 0.0] {
                    slice.load(p, 1.0);
                }
                report(&slice, &tube.at_stretch(0.0, STRETCH));
                for i in 1..=5 {
                    slice.load(
                        0.0,
                        1.0 + 0.2 * i as f64 * (free.inside.along / STRETCH - 1.0),
                    );
                }
                report(&slice, &free);
                println!("{line}");
                let mut slice = Slice::new(&layers, &free, Part::Slit, cells, discretisation);
                let r = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                    slice.load(0.0, slit.inside.along / free.inside.along)
                }));
                println!(
                    "{} {k}: slit {:.3} of {:.3} deg F {:.4} mN {}",
                    discretisation.name(),
                    slice.angle().to_degrees(),
                    slit.inside.angle.to_degrees(),
                    1e3 * slice.force(),
                    r.is_ok()
                );
            }
        }
    }
}
