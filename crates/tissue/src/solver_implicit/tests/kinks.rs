//! Steps in which forces have kinks: ties that slide, turn round and stick.

use super::*;
use crate::build_model;
use crate::elements::{SlidingConstants, couple_sliding};
use crate::newton::NewtonOptions;
use crate::testing::{block_mesh, neo_hookean};
use std::sync::Arc;

/// A soft block of 1.5 × 1.5 × 0.5 mm that is joined to a clamped one below it.
fn joined() -> (TissueModel, usize) {
    let mut mesh = block_mesh([3e-3, 3e-3, 0.5e-3], [6, 6, 1]);
    let lower = mesh.positions.len();
    mesh.positions.iter_mut().for_each(|p| p.z -= 0.25e-3);
    let mut upper = block_mesh([1.5e-3, 1.5e-3, 0.5e-3], [4, 4, 1]);
    upper.positions.iter_mut().for_each(|p| p.z += 0.25e-3);
    mesh.append(&upper, 1);
    let material = neo_hookean(1060.0, 5e3, 0.3);
    // They slide from 0.6 um on.
    let ties = SlidingConstants {
        stiffness_per_area: 1e8,
        friction: 0.2,
        shear_strength: 60.0,
    };
    let ties = couple_sliding(&mesh, 1, 0, &ties).unwrap();
    let clamped: Vec<bool> = (0..mesh.positions.len()).map(|node| node < lower).collect();
    let materials = [(0, material), (1, material)];
    let model = build_model(&mesh, &materials, &clamped, 0.0, vec![Arc::new(ties)]);
    (model.unwrap(), lower)
}

/// Nodes of the soft block start up to 10 um from where they are at rest along each axis, each in a direction of its own, so that ties slide, and turn round one by one. With
/// every full step that descends the same place is found in at least a quarter more iterations: the potential is convex and has one minimum.
#[test]
fn steps_that_overshoot_are_shortened() {
    let (model, lower) = joined();
    let newton = Newton {
        iterations: 100,
        tolerance: 1e-6,
        must_converge: false,
    };
    let usual = NewtonOptions::default();
    let mut next = numbers();
    let mut iterations = [0, 0];
    for _ in 0..20 {
        let mut start = State::at_rest(&model);
        for position in &mut start.positions[lower..] {
            *position += Vector3::from_fn(|_, _| 10e-6 * next());
        }
        let ends = [usual.line_search.overshoot, f64::INFINITY].map(|overshoot| {
            let mut options = usual;
            options.line_search.overshoot = overshoot;
            options.stagnation = 100;
            // However small all forces are.
            options.least_scale = 0.0;
            let mut solver = SolverImplicit::with_options(
                &model,
                SCHEMES[0],
                newton,
                &options,
                DistortionOptions::default(),
            );
            let mut state = start.clone();
            let report = solver.step(&model, &mut state, &Control::default(), &[], 16e-3, &Serial);
            (report.unwrap(), state.positions)
        });
        for (sum, (report, _)) in iterations.iter_mut().zip(&ends) {
            *sum += report.iterations;
        }
        for (report, _) in &ends {
            assert!(report.converged, "{report:?}");
        }
        let apart = ends[0]
            .1
            .iter()
            .zip(&ends[1].1)
            .map(|(a, b)| (a - b).norm());
        // A millionth of the forces is a millionth of ten micrometres.
        assert!(apart.fold(0.0, f64::max) < 1e-11);
    }
    assert!(5 * iterations[0] < 4 * iterations[1], "{iterations:?}");
}

/// Nodes start up to 1 µm from rest. Where 1 N times the tolerance of 1e-3 is a force that does not matter one iteration solves the step; more are made where the residual has to fall relative to
/// what forces there are.
#[test]
fn a_body_nearly_at_rest_takes_one_iteration() {
    let (model, lower) = joined();
    let newton = Newton {
        iterations: 10,
        tolerance: 1e-3,
        must_converge: false,
    };
    let mut next = numbers();
    let mut start = State::at_rest(&model);
    for position in &mut start.positions[lower..] {
        *position += Vector3::from_fn(|_, _| 1e-6 * next());
    }
    let iterations = |least_scale: f64| {
        let options = NewtonOptions {
            least_scale,
            ..NewtonOptions::default()
        };
        let none = DistortionOptions::default();
        let mut solver = SolverImplicit::with_options(&model, SCHEMES[0], newton, &options, none);
        let mut state = start.clone();
        let report = solver.step(&model, &mut state, &Control::default(), &[], 16e-3, &Serial);
        report.unwrap().iterations
    };
    assert_eq!(iterations(1.0), 1);
    assert!(iterations(0.0) > 1, "{}", iterations(0.0));
}
