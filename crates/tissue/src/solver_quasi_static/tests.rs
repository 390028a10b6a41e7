//! Closed forms, dynamics that comes to rest, steps of a load, bodies that are not held.

use super::*;
use crate::build::build_model;
use crate::elements::{Constraint, Springs};
use crate::executor::Serial;
use crate::material::{Behaviour, ContinuumConstants, Material};
use crate::solver_implicit::{ImplicitScheme, SolverImplicit};
use crate::state::NodeTarget;
use crate::testing::{block_mesh, build, soft_block};
use microsim_vocabulary::Discretisation;
use std::sync::Arc;

const TIGHT: Newton = Newton {
    iterations: 60,
    tolerance: 1e-12,
    must_converge: true,
};

fn down(acceleration: f64) -> Control {
    Control {
        gravity: Vector3::new(0.0, 0.0, -acceleration),
        ..Control::default()
    }
}

/// `nodes` masses of 1 kg, 1 m apart in a line along z, with springs of 3 N/m that are half as long at rest.
fn chain(nodes: usize, clamped: &[usize]) -> TissueModel {
    let springs = (1..nodes as u32).map(|node| Constraint {
        nodes: [node - 1, node],
        rest: 0.5,
        stiffness: 3.0,
        damping: 0.0,
    });
    let clamped: Vec<bool> = (0..nodes).map(|node| clamped.contains(&node)).collect();
    TissueModel::assemble(
        (0..nodes).map(|node| Vector3::z() * node as f64).collect(),
        vec![1.0; nodes],
        &clamped,
        vec![],
        1.0,
        vec![Arc::new(Springs::new(springs))],
        0.0,
    )
}

#[test]
fn a_stretched_chain_hangs_as_the_closed_form_says() {
    // k (u_{i−1} − 2 u_i + u_{i+1}) = m g between two clamps: u_i = −m g i (n − i)/(2 k).
    let n = 8;
    let model = chain(n + 1, &[0, n]);
    let mut state = State::at_rest(&model);
    let mut solver = SolverQuasiStatic::new(&model, TIGHT);
    let report = solver
        .step(&model, &mut state, &down(0.3), &[], 1.0, &Serial)
        .unwrap();
    assert_eq!(report.iterations, 1, "linear along the chain");
    for (i, x) in state.positions.iter().enumerate() {
        let sag = 0.3 * (i * (n - i)) as f64 / 6.0;
        let expected = Vector3::new(0.0, 0.0, i as f64 - sag);
        // Rounding of positions of size 8, times the condition of the chain, n²/2.
        let bound = 8.0 * f64::EPSILON * (n * n) as f64 / 2.0;
        assert!((x - expected).norm() < bound, "{i}: {x} {expected}");
    }
    assert!(state.velocities.iter().all(|v| *v == Vector3::zeros()));
}

#[test]
fn dynamics_that_comes_to_rest_ends_in_the_same_place() {
    let model = build(&soft_block([4, 2, 2]), |p| p.x < -0.9e-3);
    let control = down(400.0);
    let mut state = State::at_rest(&model);
    SolverQuasiStatic::new(&model, TIGHT)
        .step(&model, &mut state, &control, &[], 1.0, &Serial)
        .unwrap();
    let mut swinging = State::at_rest(&model);
    let mut dynamic = SolverImplicit::new(&model, ImplicitScheme::BackwardEuler, TIGHT);
    // Backward Euler divides each mode by √(1 + h²ω²) per step, here by more than 10.
    for _ in 0..20 {
        dynamic
            .step(&model, &mut swinging, &control, &[], 0.1, &Serial)
            .unwrap();
    }
    let mut sag = 0.0f64;
    for ((x, y), rest) in state
        .positions
        .iter()
        .zip(&swinging.positions)
        .zip(model.rest_positions())
    {
        sag = sag.max((x - rest).norm());
        // 1e-12 of the forces, times the condition of a short beam, some 1e3.
        assert!((x - y).norm() < 1e-9 * 2e-3, "{x} {y}");
    }
    assert!(sag > 2e-4, "a tenth of the length: {sag}");
}

/// A slender continuum whose bending is far from linear.
fn beam() -> TissueModel {
    let mesh = block_mesh([0.1, 0.02, 0.02], [10, 2, 2]);
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: crate::law::LawName::StableNeoHookean.into(),
            young: 1e5,
            poisson: 0.3,
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        }),
    };
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < -0.0499).collect();
    build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new()).unwrap()
}

#[test]
fn a_load_that_is_too_much_at_once_is_cut() {
    let model = beam();
    let solve = |iterations| {
        let mut state = State::at_rest(&model);
        let newton = Newton {
            iterations,
            ..TIGHT
        };
        let report = SolverQuasiStatic::new(&model, newton)
            .step(&model, &mut state, &down(9.81), &[], 1.0, &Serial)
            .unwrap();
        (state.positions, report.iterations)
    };
    let (whole, needed) = solve(60);
    assert!(needed > 2, "{needed}");
    let (in_parts, cut) = solve(needed - 1);
    assert!(cut > needed, "the failed attempts count: {cut} {needed}");
    for (a, b) in whole.iter().zip(&in_parts) {
        assert!((a - b).norm() < 1e-9 * 0.1, "{a} {b}");
    }
}

#[test]
fn equilibrium_turns_with_the_clamp_and_targets_are_met() {
    let model = build(&soft_block([2, 2, 1]), |p| p.x < -0.9e-3);
    let mut state = State::at_rest(&model);
    // A quarter turn around x through the block's centre, and a step aside.
    let turn = |p: &Vector3<f64>| Vector3::new(p.x + 1e-3, -p.z, p.y);
    let control = Control {
        clamped_positions: model
            .clamped()
            .iter()
            .map(|&node| turn(&model.rest_positions()[node as usize]))
            .collect(),
        ..Control::default()
    };
    let mut solver = SolverQuasiStatic::new(&model, TIGHT);
    solver
        .step(&model, &mut state, &control, &[], 1.0, &Serial)
        .unwrap();
    for (x, rest) in state.positions.iter().zip(model.rest_positions()) {
        assert!((x - turn(rest)).norm() < 1e-9 * 2e-3, "{x}");
    }
    let node = model.node_count() - 1;
    let target = state.positions[node] + Vector3::new(2e-4, 0.0, 1e-4);
    let targets = [NodeTarget {
        node: node as u32,
        target,
        overlap: Vector3::zeros(),
    }];
    solver
        .step(&model, &mut state, &control, &targets, 1.0, &Serial)
        .unwrap();
    assert_eq!(state.positions[node], target);
}

#[test]
fn what_is_not_held_has_no_equilibrium() {
    let singular = |model: &TissueModel| {
        let mut state = State::at_rest(model);
        let start = state.clone();
        let result = SolverQuasiStatic::new(model, TIGHT).step(
            model,
            &mut state,
            &down(1.0),
            &[],
            1.0,
            &Serial,
        );
        assert_eq!(state, start);
        match result {
            Err(StepFailure::Singular { node }) => node,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(singular(&build(&soft_block([2, 2, 1]), |_| false)), 0);
    // A block held at one node can turn around it.
    let node = singular(&build(&soft_block([1, 1, 1]), |p| {
        p.x < -0.9e-3 && p.y < -0.9e-3 && p.z < -0.4e-3
    }));
    assert!(node < 8);
    // Two chains, one of them clamped: nodes 4 to 6 are loose.
    let springs = [0, 1, 2, 4, 5].map(|node| Constraint {
        nodes: [node, node + 1],
        rest: 0.5,
        stiffness: 3.0,
        damping: 0.0,
    });
    let clamped: Vec<bool> = (0..7).map(|node| node % 3 == 0 && node < 4).collect();
    let model = TissueModel::assemble(
        (0..7).map(|node| Vector3::z() * f64::from(node)).collect(),
        vec![1.0; 7],
        &clamped,
        vec![],
        1.0,
        vec![Arc::new(Springs::new(springs))],
        0.0,
    );
    assert_eq!(singular(&model), 4);
}

#[test]
fn failures_leave_the_state_as_it_was() {
    let model = beam();
    let mut state = State::at_rest(&model);
    let start = state.clone();
    let newton = Newton {
        iterations: 1,
        ..TIGHT
    };
    let result = SolverQuasiStatic::new(&model, newton).step(
        &model,
        &mut state,
        &down(9.81),
        &[],
        1.0,
        &Serial,
    );
    // 1, ½, … 1/64.
    assert!(
        matches!(result, Err(StepFailure::NotConverged { iterations: 7, .. })),
        "{result:?}"
    );
    assert_eq!(state, start);
    state.positions[20].x = f64::NAN;
    let result = SolverQuasiStatic::new(&model, TIGHT).step(
        &model,
        &mut state,
        &down(9.81),
        &[],
        1.0,
        &Serial,
    );
    assert_eq!(result, Err(StepFailure::NotFinite));
}

/// A tenth more weight bends a beam by a tenth more, whatever the tolerance of an iteration.
#[test]
fn a_change_of_load_moves_the_body_whatever_the_tolerance() {
    let model = crate::testing::beam(0.3);
    let newton = Newton {
        iterations: 1,
        tolerance: 1e-2,
        must_converge: false,
    };
    let mut solver = SolverQuasiStatic::new(&model, newton);
    let mut state = State::at_rest(&model);
    let mut sags = Vec::new();
    for weight in [1.0, 1.1] {
        let control = Control {
            gravity: Vector3::new(0.0, 0.0, -9.81 * weight),
            ..Control::default()
        };
        for _ in 0..10 {
            solver
                .step(&model, &mut state, &control, &[], 0.02, &Serial)
                .unwrap();
        }
        sags.push(state.positions.iter().map(|p| -p.z).fold(0.0, f64::max));
    }
    assert!(sags[1] > 1.05 * sags[0], "{sags:?}");
}
