//! Measured limits of the step against the closed forms of NUMERICS 3.1.

use super::{ALL, block, oscillator, run};
use crate::executor::Serial;
use crate::method::Method;
use crate::model::TissueModel;
use crate::stability::{self, Part, power_iteration};
use crate::state::{Control, State};

/// The oscillator displaced by 1 mm, so that growth by a thousand stays linear.
fn faint_oscillator(omega: f64, drag: f64) -> (TissueModel, State) {
    let (model, mut state) = oscillator(omega, drag, 0.0);
    state.positions[1].x = 10.0 + 1e-3;
    (model, state)
}

/// The largest step between `low` and `high` after `steps` of which `size` has not grown to 100 times its start.
fn measured_limit(
    method: Method,
    (model, start): (&TissueModel, &State),
    size: impl Fn(&State) -> f64,
    guess: f64,
    steps: usize,
) -> f64 {
    let bound = 100.0 * size(start);
    let stable = |h: f64| {
        let mut state = start.clone();
        let mut solver = method.solver(model).unwrap();
        (0..steps).all(|_| {
            let done = solver.step(model, &mut state, &Control::default(), &[], h, &Serial);
            done.is_ok() && size(&state) < bound
        })
    };
    let (mut low, mut high) = (0.7 * guess, 1.4 * guess);
    assert!(
        stable(low) && !stable(high),
        "{method:?}: not between {low} and {high}"
    );
    for _ in 0..8 {
        let middle = 0.5 * (low + high);
        match stable(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// NUMERICS 3.1, every line of its table that is a method here, to 3 %.
#[test]
fn limits_of_one_mode_are_those_predicted() {
    let omega = 3.0;
    for method in ALL {
        for zeta in [0.0, 0.2, 0.5, 1.5] {
            let drag = 2.0 * zeta * omega;
            let predicted = stability::limit(&method, omega * omega, drag);
            if predicted == 0.0 {
                continue;
            }
            let (model, start) = faint_oscillator(omega, drag);
            let size = |state: &State| (state.positions[1].x - 10.0).abs();
            let measured = measured_limit(method, (&model, &start), size, predicted, 6000);
            let error = (measured / predicted - 1.0).abs();
            assert!(
                error < 0.03,
                "{method:?} ζ = {zeta}: {measured} {predicted}"
            );
        }
    }
    assert_eq!(
        stability::limit(&Method::ExplicitEuler, 9.0, 0.0),
        0.0,
        "never stable"
    );
}

#[test]
fn limits_of_a_block_are_those_predicted() {
    let (model, _) = block(true, 0.0, 0.0);
    let lambda = power_iteration(&model, Part::Stiffness, 1000);
    for method in ALL {
        for zeta in [0.0, 0.5] {
            let drag = 2.0 * zeta * lambda.sqrt();
            let predicted = stability::limit(&method, lambda, drag);
            if predicted == 0.0 {
                continue;
            }
            let (model, start) = block(true, drag, 1e-7);
            let size = |state: &State| -> f64 {
                let nodes = state.positions.iter().zip(model.rest_positions());
                nodes.map(|(p, r)| (p - r).norm()).sum()
            };
            let measured = measured_limit(method, (&model, &start), size, predicted, 1500);
            let error = (measured / predicted - 1.0).abs();
            assert!(
                error < 0.03,
                "{method:?} ζ = {zeta}: {measured} {predicted}"
            );
        }
    }
}

/// The loop of the dissertation: any drag lowers its limit from 2/ω to √2/ω; in the standard form no drag does.
#[test]
fn the_lagged_verlet_loses_the_root_of_two_at_once() {
    let size = |method: Method, drag: f64, h: f64, steps: usize| {
        let (model, mut state) = faint_oscillator(1.0, drag);
        let mut largest = 0.0f64;
        for _ in 0..steps / 100 {
            run(method, &model, &mut state, h, 100).unwrap();
            largest = largest.max((state.positions[1].x - 10.0).abs() / 1e-3);
        }
        largest
    };
    let root = std::f64::consts::SQRT_2;
    for drag in [1e-3, 1e-2, 1e-1] {
        // Near the limit the growth is some δ·(q − 2)/4 a step: as many steps as give 1e3.
        let steps = (400.0 / drag) as usize;
        assert!(
            size(Method::VelocityVerletLagged, drag, 1.05 * root, steps) > 10.0,
            "{drag}"
        );
        assert!(
            size(Method::VelocityVerletLagged, drag, 0.93 * root, steps) < 10.0,
            "{drag}"
        );
        assert!(
            size(Method::VelocityVerlet, drag, 1.98, steps) < 10.0,
            "{drag}"
        );
    }
    assert!(
        size(Method::VelocityVerletLagged, 0.0, 1.98, 50_000) < 10.0,
        "without drag"
    );
}
