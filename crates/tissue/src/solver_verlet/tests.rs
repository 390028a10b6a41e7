//! Closed forms, conservation, landing, same bits.

use super::*;
use crate::build::build_model;
use crate::elements::{Constraint, Springs};
use crate::executor::Serial;
use crate::stability::{Part, gershgorin_bound, power_iteration};
use crate::state::NodeTarget;
use crate::testing::{block_mesh, numbers, soft};
use std::sync::Arc;

/// A mass m = 1 kg on a spring k = ω² N/m to a fixed point, displaced along the spring.
fn oscillator(omega: f64, drag: f64) -> TissueModel {
    let spring = Constraint {
        nodes: [0, 1],
        rest: 10.0,
        stiffness: omega * omega,
        damping: 0.0,
    };
    TissueModel::assemble(
        vec![Vector3::zeros(), Vector3::x() * 10.0],
        vec![1.0; 2],
        &[true, false],
        vec![],
        10.0,
        vec![Arc::new(Springs::new([spring]))],
        drag,
    )
}

fn free_node(drag: f64) -> TissueModel {
    let positions = vec![Vector3::zeros()];
    TissueModel::assemble(positions, vec![0.3], &[false], vec![], 1.0, vec![], drag)
}

/// A block with all values of a tissue; random offsets of the nodes by `offset` of the mean edge length.
fn block(cells: [usize; 3], clamp: bool, drag: f64, offset: f64) -> (TissueModel, State) {
    let size = cells.map(|n| n as f64 * 1e-3);
    let mesh = block_mesh(size, cells);
    let clamped: Vec<bool> = mesh
        .positions
        .iter()
        .map(|p| clamp && p.x < -0.49 * size[0])
        .collect();
    let model = build_model(&mesh, &[(0, soft())], &clamped, drag, Vec::new()).unwrap();
    let mut state = State::at_rest(&model);
    let mut next = numbers();
    for (node, p) in state.positions.iter_mut().enumerate() {
        let shift = Vector3::new(next(), next(), next()) * (offset * model.mean_edge_length());
        if !model.is_clamped(node) {
            *p += shift;
        }
    }
    (model, state)
}

fn run(model: &TissueModel, state: &mut State, control: &Control, h: f64, steps: usize) {
    try_run(model, state, control, h, steps).unwrap();
}

fn try_run(
    model: &TissueModel,
    state: &mut State,
    control: &Control,
    h: f64,
    steps: usize,
) -> Result<(), StepFailure> {
    let mut solver = SolverVerlet::new(model);
    for _ in 0..steps {
        solver.step(model, state, control, &[], h, &Serial)?;
    }
    Ok(())
}

#[test]
fn order_of_convergence_is_two_with_and_without_drag() {
    // x'' + c x' + ω² x = 0, x(0) = 1, x'(0) = 0: e^(−ct/2)(cos νt + c/(2ν) sin νt), ν² = ω² − c²/4.
    let (omega, t) = (2.0, 3.0);
    for drag in [0.0f64, 0.8] {
        let nu = (omega * omega - drag * drag / 4.0).sqrt();
        let exact = libm::exp(-drag * t / 2.0)
            * (libm::cos(nu * t) + drag / (2.0 * nu) * libm::sin(nu * t));
        let error = |steps: usize| {
            let model = oscillator(omega, drag);
            let mut state = State::at_rest(&model);
            state.positions[1].x += 1.0;
            run(
                &model,
                &mut state,
                &Control::default(),
                t / steps as f64,
                steps,
            );
            (state.positions[1].x - 10.0 - exact).abs()
        };
        // Halving h divides the error by 4; the next term of the error is (hω)² ≈ 1e-3 of it.
        let ratio = error(200) / error(400);
        assert!((ratio - 4.0).abs() < 0.02, "drag {drag}: {ratio}");
    }
}

#[test]
fn a_changed_step_keeps_second_order() {
    let error = |steps: usize| {
        let model = oscillator(2.0, 0.0);
        let mut state = State::at_rest(&model);
        state.positions[1].x += 1.0;
        let h = 3.0 / (1.5 * steps as f64);
        for _ in 0..steps / 2 {
            run(&model, &mut state, &Control::default(), h, 1);
            run(&model, &mut state, &Control::default(), 2.0 * h, 1);
        }
        (state.positions[1].x - 10.0 - libm::cos(6.0)).abs()
    };
    let ratio = error(400) / error(800);
    assert!((ratio - 4.0).abs() < 0.1, "{ratio}");
}

#[test]
fn the_limit_is_sharp_at_two_over_omega_for_any_drag() {
    for drag in [0.0, 0.5, 5.0] {
        let largest = |h: f64, steps: usize| {
            let model = oscillator(1.0, drag);
            let mut state = State::at_rest(&model);
            state.positions[1].x += 1e-3;
            let mut largest = 0.0f64;
            for _ in 0..steps {
                if try_run(&model, &mut state, &Control::default(), h, 1).is_err() {
                    return f64::INFINITY;
                }
                largest = largest.max((state.positions[1].x - 10.0).abs());
            }
            largest
        };
        // Undamped amplitude below the limit: 1/√(1 − (hω/2)²) times the start, here 7.1 for hω = 1.98.
        assert!(largest(1.98, 5000) < 7.2e-3, "drag {drag}");
        // Above it the amplitude grows at least by the factor of the double root, e^(2·acosh(1.01)) per two steps without
        // drag; with strong drag the growing root is close to −1 and needs longer.
        assert!(largest(2.02, 5000) > 1.0, "drag {drag}");
    }
}

#[test]
fn a_free_node_loses_speed_exactly_as_the_exponential() {
    let model = free_node(120.0);
    let mut state = State::at_rest(&model);
    state.velocities[0] = Vector3::new(0.1, -0.2, 0.3);
    let (h, steps) = (1e-4, 500);
    run(&model, &mut state, &Control::default(), h, steps);
    // The velocity kept is that of the middle of the last step.
    let expected = Vector3::new(0.1, -0.2, 0.3) * libm::exp(-120.0 * h * (steps as f64 - 0.5));
    // One rounding per step.
    assert!(
        (state.velocities[0] - expected).norm() <= steps as f64 * f64::EPSILON * expected.norm()
    );
}

#[test]
fn free_fall_is_exact_and_drag_gives_the_terminal_speed() {
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        ..Control::default()
    };
    let model = free_node(0.0);
    let mut state = State::at_rest(&model);
    let (h, steps) = (1e-3, 700);
    run(&model, &mut state, &control, h, steps);
    // Verlet integrates a constant force without error: −g t²/2.
    let fallen = -0.5 * 9.81 * (h * steps as f64) * (h * steps as f64);
    assert!((state.positions[0].z / fallen - 1.0).abs() < steps as f64 * f64::EPSILON);

    // Terminal speed g/c; the scheme's own fixed point is (gh/2)·coth(ch/2) = g/c·(1 + (ch)²/12 − …).
    let drag = 50.0;
    let model = free_node(drag);
    let mut state = State::at_rest(&model);
    run(&model, &mut state, &control, h, 2000);
    let ch = drag * h;
    let expected = -9.81 / drag * (1.0 + ch * ch / 12.0);
    assert!(
        (state.velocities[0].z / expected - 1.0).abs() < ch * ch * ch * ch,
        "next term is (ch)⁴/720"
    );
}

#[test]
fn internal_forces_conserve_momentum_and_vanish_under_rigid_motion() {
    let (model, state) = block([3, 2, 2], false, 0.0, 0.15);
    let mut solver = SolverVerlet::new(&model);
    let forces = solver
        .forces(&model, &state, &Control::default(), &Serial)
        .to_vec();
    let scale: f64 = forces.iter().map(|f| f.norm()).sum();
    let sum: Vector3<f64> = forces.iter().sum();
    let moment: Vector3<f64> = state
        .positions
        .iter()
        .zip(&forces)
        .map(|(p, f)| p.cross(f))
        .sum();
    let reach = state.positions.iter().map(|p| p.norm()).fold(0.0, f64::max);
    // Each node sums at most 40 element forces of size ≤ scale.
    let rounding = 40.0 * f64::EPSILON * scale;
    assert!(
        sum.norm() < rounding && moment.norm() < rounding * reach,
        "{sum} {moment}"
    );

    let mut turned = State::at_rest(&model);
    let rotation = nalgebra::Rotation3::from_euler_angles(0.3, 1.1, -0.7);
    for p in &mut turned.positions {
        *p = rotation * *p + Vector3::new(0.01, 0.02, -0.03);
    }
    let worst = solver
        .forces(&model, &turned, &Control::default(), &Serial)
        .iter()
        .map(|f| f.norm())
        .fold(0.0, f64::max);
    // A length of 1 mm at 40 mm from the origin is known to ε·40 mm; times the stiffness of a node's springs and volumes.
    let stiffness = gershgorin_bound(&model, Part::Stiffness)
        * model.masses().iter().fold(0.0, |a: f64, &m| a.max(m));
    assert!(worst < 10.0 * stiffness * f64::EPSILON * 0.04, "{worst}");
}

#[test]
fn energy_of_the_undamped_block_does_not_drift_at_half_the_limit() {
    // NUMERICS 3.5: 10⁴ steps, drift < 5 % at s = 0.5.
    let (model, mut state) = block([2, 2, 2], false, 0.0, 0.05);
    let h = 2.0 * 0.5 / power_iteration(&model, Part::Stiffness, 200).sqrt();
    let mut solver = SolverVerlet::new(&model);
    let start = state.energies(&model).total();
    // Compared as means over 500 steps: a single value oscillates by hω/2 of the energy in a mode.
    let mut mean = |state: &mut State| {
        let mut sum = 0.0;
        for _ in 0..500 {
            solver
                .step(&model, state, &Control::default(), &[], h, &Serial)
                .unwrap();
            sum += state.energies(&model).total();
        }
        sum / 500.0
    };
    let early = mean(&mut state);
    run(&model, &mut state, &Control::default(), h, 9000);
    let late = mean(&mut state);
    assert!((late / early - 1.0).abs() < 0.05, "{start} {early} {late}");
    // In a linear mode x_n = x_0 cos nφ and u has the amplitude ω x_0 (sin φ/2 = hω/2), so that the mean is the energy at the
    // start; offsets of 5 % of an edge are linear to about that share (measured: 1.5 %).
    assert!((early / start - 1.0).abs() < 0.05, "{start} {early}");
}

#[test]
fn the_block_blows_up_beyond_the_limit_and_not_below() {
    for (share, stable) in [(0.98, true), (1.02, false)] {
        let (model, mut state) = block([2, 2, 2], true, 0.0, 1e-6);
        let h = share * 2.0 / power_iteration(&model, Part::Stiffness, 500).sqrt();
        let ended = try_run(&model, &mut state, &Control::default(), h, 3000);
        let offset = state
            .positions
            .iter()
            .zip(model.rest_positions())
            .map(|(p, r)| (p - r).norm() / model.mean_edge_length())
            .sum::<f64>();
        // Per mode bounded by 1/√(1 − 0.98²) = 5 times the start, 1e-6 in each of 27 nodes; unstable growth is e^(0.4) per
        // step and ends beyond all numbers.
        assert_eq!(ended.is_ok() && offset < 1e-3, stable, "{share}: {offset}");
    }
}

#[test]
fn every_target_is_hit_in_one_step() {
    for drag in [0.0, 150.0] {
        let (model, mut state) = block([3, 3, 2], true, drag, 0.1);
        let control = Control {
            gravity: Vector3::new(0.0, 0.0, -9.81),
            ..Control::default()
        };
        let h = 2.0 * 0.5 / gershgorin_bound(&model, Part::Stiffness).sqrt();
        // Any velocity and a step before of another length.
        run(&model, &mut state, &control, 0.7 * h, 5);
        let mut next = numbers();
        let targets: Vec<NodeTarget> = (0..model.node_count() as u32)
            .filter(|&node| node % 3 == 0 && !model.is_clamped(node as usize))
            .map(|node| {
                let shift = Vector3::new(next(), next(), next()) * (0.2 * model.mean_edge_length());
                NodeTarget {
                    node,
                    target: state.positions[node as usize] + shift,
                    overlap: Vector3::zeros(),
                }
            })
            .collect();
        SolverVerlet::new(&model)
            .step(&model, &mut state, &control, &targets, h, &Serial)
            .unwrap();
        for t in &targets {
            let miss = (state.positions[t.node as usize] - t.target).norm();
            assert!(
                miss <= 1e-12 * model.mean_edge_length(),
                "drag {drag}: {miss}"
            );
        }
    }
}

#[test]
fn a_held_node_comes_to_rest_and_needs_exactly_the_opposite_of_the_other_forces() {
    let (model, mut state) = block([2, 2, 2], true, 80.0, 0.0);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        ..Control::default()
    };
    let h = 2.0 * 0.5 / gershgorin_bound(&model, Part::Stiffness).sqrt();
    let node = (0..model.node_count())
        .find(|&i| !model.is_clamped(i))
        .unwrap();
    state.velocities[node] = Vector3::new(0.0, 0.0, -0.5);
    let target = state.positions[node] + Vector3::new(0.0, 0.0, 1e-4);
    let held = NodeTarget {
        node: node as u32,
        target,
        overlap: Vector3::zeros(),
    };
    let mut solver = SolverVerlet::new(&model);
    let mut contact = Vector3::zeros();
    for _ in 0..30 {
        solver.predict(&model, &state, &control, h, &Serial);
        contact = solver.contact_force(&model, held.node, &(held.target - solver.predicted[node]));
        solver.finish(&model, &mut state, &[held]);
    }
    // NUMERICS 2.4: v = 0 to the rounding of a position over h.
    let rounding = 4.0 * f64::EPSILON * target.norm() / h;
    assert!(
        state.velocities[node].norm() <= rounding,
        "{}",
        state.velocities[node].norm()
    );
    let others = solver.forces.last()[node];
    assert!(
        (contact + others).norm() <= rounding * model.masses()[node] / h * 2.0,
        "{contact} {others}"
    );
}

#[test]
fn undoing_an_overlap_moves_a_node_without_speeding_it_up() {
    let model = free_node(0.0);
    let mut state = State::at_rest(&model);
    let shift = Vector3::new(0.0, 0.0, 1e-4);
    let target = NodeTarget {
        node: 0,
        target: shift,
        overlap: shift,
    };
    let mut solver = SolverVerlet::new(&model);
    solver.predict(&model, &state, &Control::default(), 1e-4, &Serial);
    assert_eq!(
        solver.contact_force(&model, 0, &(shift - target.overlap)),
        Vector3::zeros()
    );
    solver.finish(&model, &mut state, &[target]);
    assert!((state.positions[0] - shift).norm() < 1e-19);
    assert!(state.velocities[0].norm() < 1e-15, "d/h would be 1 m/s");
}

#[test]
fn impulse_of_contact_is_the_change_of_momentum() {
    let model = free_node(30.0);
    let mut state = State::at_rest(&model);
    state.velocities[0] = Vector3::new(0.2, 0.0, -0.1);
    run(&model, &mut state, &Control::default(), 2e-4, 3);
    let before = state.velocities[0] * libm::exp(-30.0 * 0.5 * (2e-4 + 1e-4));
    let target = NodeTarget {
        node: 0,
        target: Vector3::new(1e-5, 1e-5, 0.0),
        overlap: Vector3::zeros(),
    };
    let mut solver = SolverVerlet::new(&model);
    solver.predict(&model, &state, &Control::default(), 1e-4, &Serial);
    let impulse =
        solver.contact_force(&model, 0, &(target.target - solver.predicted[0])) * solver.kicks[0];
    solver.finish(&model, &mut state, &[target]);
    let change = (state.velocities[0] - before) * 0.3;
    assert!((impulse - change).norm() < 1e-14 * impulse.norm());
}

/// Runs the parts on two threads, in an order that changes from call to call.
struct TwoThreads;

impl Executor for TwoThreads {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        let next = std::sync::atomic::AtomicUsize::new(0);
        let work = || {
            loop {
                let part = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                if part >= parts {
                    return;
                }
                body(parts - 1 - part);
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(work);
            work();
        });
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let (model, start) = block([16, 8, 6], true, 100.0, 0.05);
    assert!(model.parts().len() > 1, "large enough to be divided");
    let h = 2.0 * 0.3 / gershgorin_bound(&model, Part::Stiffness).sqrt();
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        ..Control::default()
    };
    let [serial, threaded] = [&Serial as &dyn Executor, &TwoThreads].map(|exec| {
        let mut state = start.clone();
        let mut solver = SolverVerlet::new(&model);
        for _ in 0..40 {
            solver
                .step(&model, &mut state, &control, &[], h, exec)
                .unwrap();
        }
        state
    });
    assert_eq!(serial, threaded);
}
