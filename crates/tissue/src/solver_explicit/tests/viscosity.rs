//! Kelvin–Voigt viscosity: the decay rate of a mode at three step sizes.

use super::oscillator;
use crate::executor::Serial;
use crate::method::Method;
use crate::state::Control;

/// The decay rate of a mode at step h, from the recurrence x₊ = T x − D x₋ that the scheme makes of it: D is the product of
/// its two roots.
fn decay_rate(method: Method, omega: f64, tau: f64, h: f64) -> f64 {
    let (model, mut state) = oscillator(omega, 0.0, tau * omega * omega);
    let mut solver = method.solver(&model).unwrap();
    let mut x = Vec::new();
    for _ in 0..40 {
        solver
            .step(&model, &mut state, &Control::default(), &[], h, &Serial)
            .unwrap();
        x.push(state.positions[1].x - 10.0);
    }
    // Four values far enough from the start: a third, small root is gone.
    let [a, b, c, d] = [x[36], x[37], x[38], x[39]];
    let product = (c * c - b * d) / (b * b - a * c);
    -libm::log(product) / (2.0 * h)
}

#[test]
fn viscosity_makes_a_mode_decay_at_the_rate_of_kelvin_and_voigt() {
    // x'' + τω² x' + ω² x = 0: the rate is τω²/2.
    let (omega, tau) = (4.0, 0.02);
    let exact = 0.5 * tau * omega * omega;
    let steps = [0.04, 0.02, 0.01];
    for method in [Method::StoermerVerlet, Method::SymplecticEuler] {
        for h in steps {
            // The force of the velocity of the step before: the product of the roots is 1 − δ, δ = hτω².
            let scheme = -libm::log(1.0 - h * tau * omega * omega) / (2.0 * h);
            let rate = decay_rate(method, omega, tau, h);
            assert!(
                (rate / scheme - 1.0).abs() < 1e-9,
                "{method:?} {h}: {rate} {scheme}"
            );
            // 1 + δ/2 + δ²/3 + …: first order.
            let delta = h * tau * omega * omega;
            assert!((rate / exact - 1.0 - delta / 2.0).abs() < delta * delta / 2.0);
        }
    }
    // Second order with the velocity expected at the end of the step.
    let error = steps.map(|h| decay_rate(Method::VelocityVerlet, omega, tau, h) / exact - 1.0);
    for pair in error.windows(2) {
        assert!((pair[0] / pair[1] - 4.0).abs() < 0.5, "{error:?}");
    }
    assert!(error[2].abs() < 1e-3, "{error:?}");
}
