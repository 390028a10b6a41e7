//! Closed forms, orders, conservation, targets, failures, same bits.

use super::*;
use crate::elements::{Constraint, Springs};
use crate::executor::Serial;
use crate::model::TissueModel;
use crate::state::{NodeTarget, Pressure};
use crate::testing::{build, numbers, soft_block};
use nalgebra::Vector3;
use std::sync::Arc;

const SCHEMES: [ImplicitScheme; 3] = [
    ImplicitScheme::BackwardEuler,
    ImplicitScheme::Midpoint,
    ImplicitScheme::Sdirk2,
];

const TIGHT: Newton = Newton {
    iterations: 30,
    tolerance: 1e-12,
    must_converge: true,
};

/// A mass m = 1 kg on a spring k = ω² N/m with damping k_d to a fixed point, displaced along the spring.
fn oscillator(omega: f64, damping: f64, drag: f64) -> TissueModel {
    let spring = Constraint {
        nodes: [0, 1],
        rest: 10.0,
        stiffness: omega * omega,
        damping,
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

/// A block of soft tissue clamped on one side, bent by `bend` [1/m].
fn block(clamp: bool, bend: f64) -> (TissueModel, State) {
    let model = build(&soft_block([2, 2, 1]), |p| clamp && p.x < -0.9e-3);
    let mut state = State::at_rest(&model);
    for position in &mut state.positions {
        let x = position.x + 1e-3;
        position.z += bend * x * x;
    }
    (model, state)
}

fn run(
    model: &TissueModel,
    state: &mut State,
    scheme: ImplicitScheme,
    newton: Newton,
    control: &Control,
    h: f64,
    steps: usize,
) -> StepReport {
    let mut solver = SolverImplicit::new(model, scheme, newton);
    let mut last = StepReport::default();
    for _ in 0..steps {
        last = solver
            .step(model, state, control, &Contacts::default(), h, &Serial)
            .unwrap();
    }
    last
}

fn energy(model: &TissueModel, state: &State) -> f64 {
    state.energies(model).total()
}

#[test]
fn one_step_of_an_oscillator_is_that_of_the_stability_function() {
    // x' = v, v' = −ω²x: u_{n+1} = R(hA) u_n, so x + i v/ω is multiplied by R(iω h) (or its conjugate).
    let (omega, h) = (2.0, 0.3);
    let z = omega * h;
    // R(iz) = (re, im) for backward Euler 1/(1 − iz), midpoint (1 + iz/2)/(1 − iz/2), SDIRK2 (1 + (1−2γ)iz)/(1 − γiz)².
    let divide = |(a, b): (f64, f64), (c, d): (f64, f64)| {
        let n = c * c + d * d;
        ((a * c + b * d) / n, (b * c - a * d) / n)
    };
    for (scheme, factor) in [
        (ImplicitScheme::BackwardEuler, divide((1.0, 0.0), (1.0, -z))),
        (
            ImplicitScheme::Midpoint,
            divide((1.0, z / 2.0), (1.0, -z / 2.0)),
        ),
        (
            ImplicitScheme::Sdirk2,
            divide(
                (1.0, (1.0 - 2.0 * GAMMA) * z),
                (1.0 - GAMMA * GAMMA * z * z, -2.0 * GAMMA * z),
            ),
        ),
    ] {
        let model = oscillator(omega, 0.0, 0.0);
        let mut state = State::at_rest(&model);
        state.positions[1].x += 0.7;
        run(&model, &mut state, scheme, TIGHT, &Control::default(), h, 1);
        // x − i v/ω = R* x_0 for v_0 = 0: x = Re R x_0, v = −ω Im R x_0.
        let expected = (10.0 + 0.7 * factor.0, -omega * factor.1 * 0.7);
        let (x, v) = (state.positions[1].x, state.velocities[1].x);
        // A few roundings of positions of size 10, divided by the span for velocities.
        let rounding = 8.0 * 10.0 * f64::EPSILON;
        assert!(
            (x - expected.0).abs() < rounding,
            "{scheme:?}: {x} {expected:?}"
        );
        assert!(
            (v - expected.1).abs() < rounding / (GAMMA * h),
            "{scheme:?}: {v} {expected:?}"
        );
    }
}

#[test]
fn orders_on_an_oscillator_with_drag_and_damping() {
    // x'' + (c + k_d) x' + ω² x = 0, x(0) = 1, x'(0) = 0.
    let (omega, t) = (2.0, 3.0);
    let rate: f64 = 0.5 + 0.3;
    let nu = (omega * omega - rate * rate / 4.0).sqrt();
    let decay = libm::exp(-rate * t / 2.0);
    let exact = (
        decay * (libm::cos(nu * t) + rate / (2.0 * nu) * libm::sin(nu * t)),
        -decay * omega * omega / nu * libm::sin(nu * t),
    );
    for (scheme, ratio) in SCHEMES.into_iter().zip([2.0, 4.0, 4.0]) {
        for iterations in [1, 20] {
            let newton = Newton {
                iterations,
                must_converge: false,
                ..TIGHT
            };
            let error = |steps: usize| {
                let model = oscillator(omega, 0.3, 0.5);
                let mut state = State::at_rest(&model);
                state.positions[1].x += 1.0;
                let h = t / steps as f64;
                run(
                    &model,
                    &mut state,
                    scheme,
                    newton,
                    &Control::default(),
                    h,
                    steps,
                );
                let x = state.positions[1].x - 10.0 - exact.0;
                let v = state.velocities[1].x - exact.1;
                (x * x + v * v / (omega * omega)).sqrt()
            };
            // The next term of the error is hω = 1e-2 of the first, for backward Euler a few times that.
            let measured = error(600) / error(1200);
            assert!(
                (measured / ratio - 1.0).abs() < 0.03,
                "{scheme:?} {iterations}: {measured}"
            );
        }
    }
}

#[test]
fn orders_on_a_bent_block() {
    // No closed form: against a run of second order with steps so small that its error is below a percent of the others.
    let end = |scheme, newton, steps: usize| {
        let (model, mut state) = block(true, 100.0);
        let h = 4e-4 / steps as f64;
        run(
            &model,
            &mut state,
            scheme,
            newton,
            &Control::default(),
            h,
            steps,
        );
        state.positions
    };
    let exact = end(ImplicitScheme::Midpoint, TIGHT, 5120);
    for (scheme, order) in SCHEMES.into_iter().zip([1.0, 2.0, 2.0]) {
        for iterations in [1, 20] {
            let newton = Newton {
                iterations,
                must_converge: false,
                ..TIGHT
            };
            let error = |steps: usize| {
                let difference = end(scheme, newton, steps).into_iter().zip(&exact);
                difference
                    .map(|(a, b)| (a - b).norm_squared())
                    .sum::<f64>()
                    .sqrt()
            };
            let errors = [error(320), error(640)];
            let measured = libm::log2(errors[0] / errors[1]);
            assert!(
                (measured - order).abs() < 0.15,
                "{scheme:?} {iterations}: {measured}"
            );
        }
    }
}

#[test]
fn energy_of_an_oscillator_falls_or_stays_as_the_closed_form_says() {
    let (omega, h, steps) = (3.0, 0.1, 50);
    for (scheme, factor) in [
        (
            ImplicitScheme::BackwardEuler,
            1.0 / (1.0 + h * h * omega * omega),
        ),
        (ImplicitScheme::Midpoint, 1.0),
    ] {
        let model = oscillator(omega, 0.0, 0.0);
        let mut state = State::at_rest(&model);
        state.positions[1].x += 0.5;
        let start = energy(&model, &state);
        run(
            &model,
            &mut state,
            scheme,
            TIGHT,
            &Control::default(),
            h,
            steps,
        );
        let expected = start * libm::pow(factor, steps as f64);
        // Rounding of positions of size 10 against an amplitude of 0.5 · 0.07 at the end, in each step.
        let share = (energy(&model, &state) - expected).abs() / expected;
        assert!(share < 1e-11, "{scheme:?}: {share}");
    }
}

#[test]
fn damping_decays_as_kelvin_and_voigt_say_at_three_steps() {
    // x = e^(−δt) (cos νt + δ/ν sin νt) with δ = k_d/2m: the amplitude falls by e^(−2πδ/ν) per period, whatever the step.
    let (omega, damping) = (2.0f64, 0.2f64);
    let delta = 0.5 * damping;
    let nu = (omega * omega - delta * delta).sqrt();
    let period = 2.0 * std::f64::consts::PI / nu;
    for scheme in [ImplicitScheme::Midpoint, ImplicitScheme::Sdirk2] {
        for steps in [40, 80, 160] {
            let model = oscillator(omega, damping, 0.0);
            let mut state = State::at_rest(&model);
            state.positions[1].x += 1.0;
            let h = period / steps as f64;
            run(
                &model,
                &mut state,
                scheme,
                TIGHT,
                &Control::default(),
                h,
                steps,
            );
            let decay = state.positions[1].x - 10.0;
            let expected = libm::exp(-delta * period);
            // Errors of second order in frequency and decay: less than (hω)²/6 of each radian (midpoint: 1/12 of the frequency,
            // SDIRK2: 0.04), of which the phase counts only with the slope δ/ν at a peak.
            let bound = (h * omega) * (h * omega) * expected;
            assert!(
                (decay - expected).abs() < bound,
                "{scheme:?} {steps}: {decay} {expected} {bound}"
            );
        }
    }
}

#[test]
fn newton_converges_quadratically() {
    let (model, start) = block(true, 150.0);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -2e3),
        ..Control::default()
    };
    let residual = |iterations| {
        let newton = Newton {
            iterations,
            tolerance: 0.0,
            must_converge: false,
        };
        let mut state = start.clone();
        run(
            &model,
            &mut state,
            ImplicitScheme::BackwardEuler,
            newton,
            &control,
            2e-3,
            1,
        )
        .residual
    };
    let residuals: Vec<f64> = (1..12).map(residual).collect();
    // The last step that is above rounding, and the two before it: r' = C r² in all of them.
    let last = residuals.iter().rposition(|r| *r > 0.0).unwrap();
    assert!(last >= 3, "it takes a few iterations: {residuals:?}");
    let falls = [last - 1, last].map(|i| libm::log(residuals[i] / residuals[i - 1]));
    assert!(falls[1] / falls[0] > 1.8, "{residuals:?}");
}

#[test]
fn momentum_of_a_free_body_is_kept() {
    for scheme in SCHEMES {
        let (model, mut state) = block(false, 100.0);
        let mut next = numbers();
        for velocity in &mut state.velocities {
            *velocity = Vector3::new(next(), next(), next()) * 0.05;
        }
        let momentum = |state: &State| -> Vector3<f64> {
            let each = state.velocities.iter().zip(model.masses());
            each.map(|(v, m)| v * *m).sum()
        };
        let spin = |state: &State| -> Vector3<f64> {
            let each = state.positions.iter().zip(&state.velocities);
            each.zip(model.masses())
                .map(|((x, v), m)| x.cross(v) * *m)
                .sum()
        };
        let start = (momentum(&state), spin(&state));
        let size: f64 = model.masses().iter().sum::<f64>() * 0.05;
        run(
            &model,
            &mut state,
            scheme,
            TIGHT,
            &Control::default(),
            2e-4,
            20,
        );
        // What Newton leaves, 1e-12 of the forces, for 20 steps; forces are below 1e3 times momentum per step.
        let change = (momentum(&state) - start.0).norm() / size;
        assert!(change < 1e-9, "{scheme:?}: {change}");
        let turned = (spin(&state) - start.1).norm() / (size * 1e-3);
        if scheme == ImplicitScheme::Midpoint {
            assert!(turned < 1e-9, "{turned}");
        } else {
            // The failure that the documentation names.
            assert!(turned > 1e-6, "{scheme:?}: {turned}");
        }
    }
}

#[test]
fn targets_and_clamps_are_met_to_the_last_bit() {
    for scheme in SCHEMES {
        let (model, mut state) = block(true, 0.0);
        let mut solver = SolverImplicit::new(&model, scheme, TIGHT);
        let lead = model.node_count() - 1;
        let goal = state.positions[lead] + Vector3::new(1e-4, 2e-4, -3e-4);
        let overlap = Vector3::new(0.0, 0.0, -1e-4);
        let before = state.positions[lead];
        let contacts = Contacts {
            targets: vec![NodeTarget {
                node: lead as u32,
                target: goal,
                overlap,
            }],
        };
        let shift = Vector3::new(0.0, 5e-5, 0.0);
        let clamps: Vec<Vector3<f64>> = model
            .clamped()
            .iter()
            .map(|&node| model.rest_positions()[node as usize] + shift)
            .collect();
        let control = Control {
            clamped_positions: clamps.clone(),
            ..Control::default()
        };
        let h = 1e-3;
        solver
            .step(&model, &mut state, &control, &contacts, h, &Serial)
            .unwrap();
        assert_eq!(state.positions[lead], goal, "{scheme:?}");
        assert_eq!(state.velocities[lead], (goal - before) / h - overlap / h);
        for (node, place) in model.clamped().iter().zip(&clamps) {
            assert_eq!(state.positions[*node as usize], *place, "{scheme:?}");
        }
    }
}

#[test]
fn a_follower_pressure_is_balanced() {
    // A free block under even pressure on all sides shrinks and does not move. Its surface: outward triangles of all faces that
    // one element alone has.
    let mesh = soft_block([2, 2, 1]);
    let model = build(&mesh, |_| false);
    let mut faces: Vec<([u32; 3], [u32; 3])> = Vec::new();
    for [a, b, c, d] in mesh.tets.iter().copied() {
        for face in [[a, c, b], [a, b, d], [b, c, d], [a, d, c]] {
            let mut sorted = face;
            sorted.sort_unstable();
            faces.push((sorted, face));
        }
    }
    faces.sort_unstable();
    let outside: Vec<[u32; 3]> = faces
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() == 1)
        .map(|same| same[0].1)
        .collect();
    let control = Control {
        pressures: vec![Pressure {
            triangles: outside.into(),
            pressure: 2e3,
        }],
        ..Control::default()
    };
    let volume = |state: &State| -> f64 {
        let corners = |tet: &[u32; 4]| tet.map(|node| state.positions[node as usize]);
        let volumes = model.tets().iter().map(corners);
        volumes
            .map(|[a, b, c, d]| microsim_mesh::signed_volume(&a, &b, &c, &d))
            .sum()
    };
    let mut state = State::at_rest(&model);
    let start = volume(&state);
    let h = 0.05;
    run(
        &model,
        &mut state,
        ImplicitScheme::BackwardEuler,
        TIGHT,
        &control,
        h,
        30,
    );
    let share = volume(&state) / start;
    // Bulk modulus: κ = 5e4 Pa of the volumes and, of springs with c·E per edge and tetrahedron, less than E = 25e3 Pa:
    // between p/(κ + E) and p/κ.
    assert!(
        1.0 - share > 2e3 / 7.5e4 && 1.0 - share < 2e3 / 5e4,
        "{share}"
    );
    let drift: Vector3<f64> = state
        .positions
        .iter()
        .zip(model.rest_positions())
        .map(|(x, rest)| x - rest)
        .sum();
    assert!(drift.norm() < 1e-9, "{drift}");
}

#[test]
fn a_body_far_from_rest_comes_back() {
    // Inverted, flat, and with one node far out: backward Euler goes down its potential to the rest shape.
    for case in 0..3 {
        let model = build(&soft_block([4, 2, 2]), |p| p.x < -0.9e-3);
        let mut state = State::at_rest(&model);
        for (node, position) in state.positions.iter_mut().enumerate() {
            if model.is_clamped(node) {
                continue;
            }
            match case {
                0 => position.z = -position.z,
                1 => position.z = 0.0,
                _ if node + 1 == model.node_count() => position.z += 4e-3,
                _ => {}
            }
        }
        let newton = Newton {
            must_converge: false,
            ..Newton::default()
        };
        run(
            &model,
            &mut state,
            ImplicitScheme::BackwardEuler,
            newton,
            &Control::default(),
            5e-3,
            60,
        );
        let farthest = state
            .positions
            .iter()
            .zip(model.rest_positions())
            .map(|(x, rest)| (x - rest).norm())
            .fold(0.0, f64::max);
        assert!(farthest < 1e-6, "case {case}: {farthest} m of 2 mm");
    }
}

#[test]
fn failures_leave_the_state_as_it_was() {
    for scheme in SCHEMES {
        let (model, mut state) = block(true, 100.0);
        let mut solver = SolverImplicit::new(
            &model,
            scheme,
            Newton {
                iterations: 1,
                tolerance: 1e-14,
                must_converge: true,
            },
        );
        let start = state.clone();
        let none = Contacts::default();
        let result = solver.step(
            &model,
            &mut state,
            &Control::default(),
            &none,
            1e-2,
            &Serial,
        );
        assert!(
            matches!(result, Err(StepFailure::NotConverged { iterations: 1, residual }) if residual > 1e-14),
            "{result:?}"
        );
        assert_eq!(state, start);
        state.velocities[3].y = f64::NAN;
        let result = solver.step(
            &model,
            &mut state,
            &Control::default(),
            &none,
            1e-2,
            &Serial,
        );
        assert_eq!(result, Err(StepFailure::NotFinite), "{scheme:?}");
        assert_eq!(state.positions, start.positions);
        assert!(state.velocities[3].y.is_nan());
    }
}

/// Runs the parts of a loop backwards.
struct Backwards;

impl Executor for Backwards {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        (0..parts).rev().for_each(body);
    }
}

#[test]
fn same_bits_on_any_executor_and_from_any_copy() {
    // Large enough for several parts.
    let model = build(&soft_block([10, 10, 8]), |p| p.x < -0.9e-3);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -500.0),
        ..Control::default()
    };
    let none = Contacts::default();
    let newton = Newton {
        iterations: 2,
        must_converge: false,
        ..Newton::default()
    };
    let mut solver = SolverImplicit::new(&model, ImplicitScheme::BackwardEuler, newton);
    let mut state = State::at_rest(&model);
    solver
        .step(&model, &mut state, &control, &none, 1e-3, &Serial)
        .unwrap();
    let mut twin = state.clone();
    let mut copy = solver.boxed_clone();
    solver
        .step(&model, &mut state, &control, &none, 1e-3, &Serial)
        .unwrap();
    copy.step(&model, &mut twin, &control, &none, 1e-3, &Backwards)
        .unwrap();
    assert_eq!(state, twin);
}
