//! Closed forms of oscillators, orders of convergence.

use super::*;
use crate::elements::{Constraint, Springs};
use std::sync::Arc;

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
            // Measured 0.952, 2.017 and 2.034: what the next term of the error leaves at these steps, twice that is allowed.
            assert!(
                (measured - order).abs() < 0.1,
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
