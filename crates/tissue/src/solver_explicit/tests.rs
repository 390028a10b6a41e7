//! Orders, energy, momentum, landing, failure: for every explicit method.

mod flow;
mod limits;
mod viscosity;

use crate::build::build_model;
use crate::elements::{Constraint, Springs};
use crate::executor::Serial;
use crate::method::Method;
use crate::model::TissueModel;
use crate::solver::StepFailure;
use crate::stability::{Part, gershgorin_bound, power_iteration};
use crate::state::{Control, NodeTarget, State};
use crate::testing::{block_mesh, numbers, soft};
use nalgebra::Vector3;
use std::sync::Arc;

const ALL: [Method; 5] = [
    Method::StoermerVerlet,
    Method::ExplicitEuler,
    Method::SymplecticEuler,
    Method::VelocityVerlet,
    Method::VelocityVerletLagged,
];

/// A mass of 1 kg on a spring ω² N/m with k_d to a fixed point, at 10 m along x; displaced by 1 m. It is linear up to the
/// amplitude at which the spring turns over, 10 m.
fn oscillator(omega: f64, drag: f64, k_d: f64) -> (TissueModel, State) {
    let spring = Constraint {
        nodes: [0, 1],
        rest: 10.0,
        stiffness: omega * omega,
        damping: k_d,
    };
    let model = TissueModel::assemble(
        vec![Vector3::zeros(), Vector3::x() * 10.0],
        vec![1.0; 2],
        &[true, false],
        vec![],
        10.0,
        vec![Arc::new(Springs::new([spring]))],
        drag,
    );
    let mut state = State::at_rest(&model);
    state.positions[1].x += 1.0;
    (model, state)
}

/// A block of tissue, with offsets of the free nodes by `offset` of the mean edge length.
fn block(clamp: bool, drag: f64, offset: f64) -> (TissueModel, State) {
    let mesh = block_mesh([2e-3; 3], [2; 3]);
    let clamped: Vec<bool> = mesh
        .positions
        .iter()
        .map(|p| clamp && p.x < -0.9e-3)
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

fn run(
    method: Method,
    model: &TissueModel,
    state: &mut State,
    h: f64,
    steps: usize,
) -> Result<(), StepFailure> {
    let mut solver = method.solver(model).unwrap();
    for _ in 0..steps {
        solver.step(model, state, &Control::default(), &[], h, &Serial)?;
    }
    Ok(())
}

#[test]
fn observed_orders_are_those_of_the_schemes() {
    // x'' + c x' + ω² x = 0, x(0) = 1, x'(0) = 0: e^(−ct/2)(cos νt + c/(2ν) sin νt), ν² = ω² − c²/4.
    let (omega, t) = (2.0, 3.0);
    for (method, drag, order) in [
        (Method::ExplicitEuler, 0.0, 1),
        (Method::ExplicitEuler, 0.8, 1),
        (Method::SymplecticEuler, 0.0, 1),
        (Method::SymplecticEuler, 0.8, 1),
        (Method::VelocityVerlet, 0.0, 2),
        (Method::VelocityVerlet, 0.8, 2),
        (Method::VelocityVerletLagged, 0.0, 2),
        (Method::VelocityVerletLagged, 0.8, 1),
    ] {
        let nu = f64::sqrt(omega * omega - drag * drag / 4.0);
        let exact = libm::exp(-drag * t / 2.0)
            * (libm::cos(nu * t) + drag / (2.0 * nu) * libm::sin(nu * t));
        let error = |steps: usize| {
            let (model, mut state) = oscillator(omega, drag, 0.0);
            run(method, &model, &mut state, t / steps as f64, steps).unwrap();
            state.positions[1].x - 10.0 - exact
        };
        // The ratio of errors is 2^order up to a share O(h) of it, and the next halving halves what is missing.
        let wanted = f64::powi(2.0, order);
        let [a, b] = [error(2000) / error(4000), error(4000) / error(8000)];
        assert!((a - wanted).abs() < 0.02 * wanted, "{method:?} {drag}: {a}");
        assert!(
            (b - wanted).abs() < 0.6 * (a - wanted).abs() + 1e-3,
            "{method:?} {drag}: {a} {b}"
        );
    }
}

#[test]
fn velocities_of_velocity_verlet_are_those_at_the_end_of_the_step() {
    let error = |steps: usize| {
        let (model, mut state) = oscillator(2.0, 0.0, 0.0);
        run(
            Method::VelocityVerlet,
            &model,
            &mut state,
            3.0 / steps as f64,
            steps,
        )
        .unwrap();
        state.velocities[1].x + 2.0 * libm::sin(6.0)
    };
    let ratio = error(400) / error(800);
    assert!((ratio - 4.0).abs() < 0.02, "{ratio}");
}

/// What each scheme does with the energy of a mode, to rounding.
#[test]
fn energy_of_an_oscillator_follows_the_closed_form_of_each_scheme() {
    let (omega, h) = (3.0f64, 0.1);
    let q = h * h * omega * omega;
    for method in [
        Method::ExplicitEuler,
        Method::SymplecticEuler,
        Method::VelocityVerlet,
    ] {
        let (model, mut state) = oscillator(omega, 0.0, 0.0);
        let mut solver = method.solver(&model).unwrap();
        let energy = |state: &State| {
            let (x, v) = (state.positions[1].x - 10.0, state.velocities[1].x);
            let plain = 0.5 * v * v + 0.5 * omega * omega * x * x;
            match method {
                Method::SymplecticEuler => plain - 0.5 * h * omega * omega * x * v,
                Method::VelocityVerlet => plain - q / 8.0 * omega * omega * x * x,
                _ => plain,
            }
        };
        // Explicit Euler reaches the end of the linear range after 53 steps.
        let (growth, steps) = match method {
            Method::ExplicitEuler => (1.0 + q, 50),
            _ => (1.0, 200),
        };
        let mut expected = energy(&state);
        for step in 1..=steps {
            solver
                .step(&model, &mut state, &Control::default(), &[], h, &Serial)
                .unwrap();
            expected *= growth;
            // Positions at 10 m: each step rounds by some 1e-15 of the amplitude times 10.
            let error = (energy(&state) / expected - 1.0).abs();
            assert!(
                error < 1e-13 * step as f64,
                "{method:?} step {step}: {error}"
            );
        }
    }
}

#[test]
fn energy_of_a_block_drifts_with_explicit_euler_alone() {
    // NUMERICS 3.5: 10⁴ steps at half the limit, drift < 5 %; means over 500 steps, as a value oscillates.
    for method in [
        Method::SymplecticEuler,
        Method::VelocityVerlet,
        Method::VelocityVerletLagged,
    ] {
        let (model, mut state) = block(false, 0.0, 0.02);
        let h = 1.0 / power_iteration(&model, Part::Stiffness, 200).sqrt();
        let mean = |state: &mut State| {
            let mut sum = 0.0;
            for _ in 0..500 {
                run(method, &model, state, h, 1).unwrap();
                sum += state.energies(&model).total();
            }
            sum / 500.0
        };
        let early = mean(&mut state);
        run(method, &model, &mut state, h, 9000).unwrap();
        let late = mean(&mut state);
        assert!(
            (late / early - 1.0).abs() < 0.05,
            "{method:?}: {early} {late}"
        );
    }
    let (model, mut state) = block(false, 0.0, 0.02);
    let lambda = power_iteration(&model, Part::Stiffness, 200);
    let start = state.energies(&model).total();
    // q of the fastest mode is 0.01: the energy of the slower modes grows less, that of the sum at least a little.
    run(
        Method::ExplicitEuler,
        &model,
        &mut state,
        0.1 / lambda.sqrt(),
        1000,
    )
    .unwrap();
    assert!(state.energies(&model).total() > 3.0 * start);
}

#[test]
fn momentum_of_a_free_body_is_kept() {
    for method in ALL {
        let (model, mut state) = block(false, 0.0, 0.05);
        let mut next = numbers();
        for v in &mut state.velocities {
            *v = Vector3::new(next(), next(), next()) * 0.01;
        }
        let momentum = |state: &State| -> Vector3<f64> {
            state
                .velocities
                .iter()
                .zip(model.masses())
                .map(|(v, m)| v * *m)
                .sum()
        };
        let before = momentum(&state);
        let h = 0.2 / gershgorin_bound(&model, Part::Stiffness).sqrt();
        run(method, &model, &mut state, h, 100).unwrap();
        let size: f64 = state
            .velocities
            .iter()
            .zip(model.masses())
            .map(|(v, m)| v.norm() * m)
            .sum();
        // A few roundings per node and step.
        let change = (momentum(&state) - before).norm();
        assert!(
            change < 100.0 * 10.0 * f64::EPSILON * size,
            "{method:?}: {change} of {size}"
        );
    }
}

#[test]
fn every_target_is_hit_in_one_step() {
    for method in ALL.into_iter().filter(Method::reaches_node_targets) {
        for drag in [0.0, 150.0] {
            let (model, mut state) = block(true, drag, 0.1);
            let control = Control {
                gravity: Vector3::new(0.0, 0.0, -9.81),
                ..Control::default()
            };
            let h = 0.5 / gershgorin_bound(&model, Part::Stiffness).sqrt();
            // Any velocity, and a step before of another length.
            let mut solver = method.solver(&model).unwrap();
            for _ in 0..5 {
                solver
                    .step(&model, &mut state, &control, &[], 0.7 * h, &Serial)
                    .unwrap();
            }
            let mut next = numbers();
            let mut target = |node: u32| NodeTarget {
                node,
                target: state.positions[node as usize]
                    + Vector3::new(next(), next(), next()) * (0.2 * model.mean_edge_length()),
                overlap: Vector3::zeros(),
            };
            let targets: Vec<_> = (0..27)
                .filter(|node| node % 3 == 1)
                .map(&mut target)
                .collect();
            assert!(targets.iter().all(|t| !model.is_clamped(t.node as usize)));
            solver
                .step(&model, &mut state, &control, &targets, h, &Serial)
                .unwrap();
            for t in &targets {
                let miss = (state.positions[t.node as usize] - t.target).norm();
                assert!(
                    miss <= 1e-12 * model.mean_edge_length(),
                    "{method:?}: {miss}"
                );
            }
        }
    }
}

/// The target is reached by a force of that one step: the same force as a load lands the node there too (NUMERICS 2).
#[test]
fn the_formulas_of_the_contact_force_are_those_of_the_schemes() {
    let h = 0.02;
    for method in [Method::SymplecticEuler, Method::VelocityVerletLagged] {
        let (model, mut start) = oscillator(3.0, 0.0, 0.0);
        run(method, &model, &mut start, h, 3).unwrap();
        let step = |control: &Control, targets: &[NodeTarget]| {
            let mut state = start.clone();
            let mut solver = method.solver(&model).unwrap();
            solver
                .step(&model, &mut state, control, targets, h, &Serial)
                .unwrap();
            state
        };
        let free = step(&Control::default(), &[]).positions[1];
        let target = free + Vector3::new(0.05, -0.02, 0.01);
        // m/h² for both at constant h, m = 1 kg.
        let load = Control {
            forces: vec![(1, (target - free) / (h * h))],
            ..Control::default()
        };
        let aim = NodeTarget {
            node: 1,
            target,
            overlap: Vector3::zeros(),
        };
        let led = step(&Control::default(), &[aim]);
        let pushed = step(&load, &[]);
        let differences = [
            led.positions[1] - pushed.positions[1],
            (led.velocities[1] - pushed.velocities[1]) * h,
        ];
        assert!(
            differences.iter().all(|d| d.norm() < 1e-13),
            "{method:?}: {differences:?}"
        );
        if method == Method::VelocityVerletLagged {
            assert!((led.accelerations[1] - pushed.accelerations[1]).norm() * h * h < 1e-13);
        }
    }
}

#[test]
fn undoing_an_overlap_leaves_no_velocity() {
    for method in ALL.into_iter().filter(Method::reaches_node_targets) {
        let model = TissueModel::assemble(
            vec![Vector3::zeros()],
            vec![0.3],
            &[false],
            vec![],
            1.0,
            vec![],
            0.0,
        );
        let mut state = State::at_rest(&model);
        let shift = Vector3::new(0.0, 0.0, 1e-4);
        let aim = NodeTarget {
            node: 0,
            target: shift,
            overlap: shift,
        };
        let mut solver = method.solver(&model).unwrap();
        let targets = [aim];
        solver
            .step(
                &model,
                &mut state,
                &Control::default(),
                &targets,
                1e-4,
                &Serial,
            )
            .unwrap();
        run(method, &model, &mut state, 1e-4, 10).unwrap();
        assert!((state.positions[0] - shift).norm() < 1e-18, "{method:?}");
    }
}

#[test]
fn clamped_nodes_go_where_the_control_wants_them() {
    for method in ALL {
        let (model, mut state) = block(true, 0.0, 0.01);
        let wanted: Vec<_> = model
            .clamped()
            .iter()
            .map(|&node| state.positions[node as usize] + Vector3::new(1e-5, 0.0, 2e-5))
            .collect();
        let control = Control {
            clamped_positions: wanted.clone(),
            ..Control::default()
        };
        let h = 0.1 / gershgorin_bound(&model, Part::Stiffness).sqrt();
        let mut solver = method.solver(&model).unwrap();
        for _ in 0..3 {
            solver
                .step(&model, &mut state, &control, &[], h, &Serial)
                .unwrap();
            for (&node, wanted) in model.clamped().iter().zip(&wanted) {
                assert_eq!(state.positions[node as usize], *wanted, "{method:?}");
            }
        }
        for &node in model.clamped() {
            assert_eq!(
                state.velocities[node as usize],
                Vector3::zeros(),
                "{method:?}: it stands"
            );
        }
    }
}

#[test]
fn a_step_into_nothing_leaves_the_state_as_it_was() {
    for method in ALL {
        let (model, mut state) = block(true, 10.0, 0.05);
        let h = 0.5 / gershgorin_bound(&model, Part::Stiffness).sqrt();
        run(method, &model, &mut state, h, 4).unwrap();
        let before = state.clone();
        let mut solver = method.solver(&model).unwrap();
        let push = Control {
            forces: vec![(13, Vector3::x() * f64::MAX)],
            ..Control::default()
        };
        let bad = NodeTarget {
            node: 13,
            target: Vector3::x() * f64::NAN,
            overlap: Vector3::zeros(),
        };
        let mut cases = vec![(push, vec![])];
        if method.reaches_node_targets() {
            cases.push((Control::default(), vec![bad]));
        }
        for (control, targets) in cases {
            let result = solver.step(&model, &mut state, &control, &targets, h, &Serial);
            assert_eq!(
                (result, &state),
                (Err(StepFailure::NotFinite), &before),
                "{method:?}"
            );
        }
        // The solver has not been spoilt.
        let mut other = before.clone();
        run(method, &model, &mut other, h, 3).unwrap();
        for _ in 0..3 {
            solver
                .step(&model, &mut state, &Control::default(), &[], h, &Serial)
                .unwrap();
        }
        assert_eq!(state, other, "{method:?}");
    }
}
