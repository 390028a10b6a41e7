//! A thin ring, or a long tube in plane strain, that two opposite lines press flat: large bending without extension, solved along a quarter of the ring.
//!
//! From a line (s = 0) to the side (s = π/2, in radii) the section bears a force along the load alone, half of it, so that its tangent's angle follows
//! θ'' = (W R²/2 E' I) cos θ with θ(0) = 0 and θ(π/2) = π/2. Not here: extension and shear, which are of the order of the square of thickness over radius, and rings
//! that are flat at the lines, from 0.28 of the diameter on.

use super::newton::solve;
use std::f64::consts::FRAC_PI_2;

/// Steps of the method of Runge and Kutta along the quarter: with half as many the result is off by 1e-12.
const STEPS: usize = 400;

/// A ring between two lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlattenedRing {
    /// Load per length over E' I/R².
    pub load: f64,
    /// Largest width over the diameter of the round ring.
    pub width: f64,
}

impl FlattenedRing {
    /// At a height over the diameter of the round ring, above 0.73.
    pub fn at_height(height: f64) -> Self {
        let residuals = |[load, bend]: [f64; 2]| {
            let [angle, _, up, _] = quarter(load, bend);
            [angle - FRAC_PI_2, up - height]
        };
        let flattening = 1.0 - height;
        // That of small deflections (see the test), and a guess of what is left of the curvature at the line.
        let start = [flattening / 0.1488, 1.0 - 3.0 * flattening];
        let [load, bend] = solve(&residuals, start, 1e-12);
        let [.., width] = quarter(load, bend);
        Self {
            load: 2.0 * load,
            width,
        }
    }
}

/// Angle and curvature at the side, and how far it is from the line along the load and across, for half of the load and the curvature at the line.
fn quarter(half_load: f64, bend: f64) -> [f64; 4] {
    let slope = |[angle, curvature, ..]: [f64; 4]| {
        let (sine, cosine) = libm::sincos(angle);
        [curvature, half_load * cosine, sine, cosine]
    };
    let step = FRAC_PI_2 / STEPS as f64;
    let moved = |at: [f64; 4], by: [f64; 4], step: f64| [0, 1, 2, 3].map(|k| at[k] + step * by[k]);
    let mut at = [0.0, bend, 0.0, 0.0];
    for _ in 0..STEPS {
        let a = slope(at);
        let b = slope(moved(at, a, 0.5 * step));
        let c = slope(moved(at, b, 0.5 * step));
        let d = slope(moved(at, c, step));
        let mean = [0, 1, 2, 3].map(|k| (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]) / 6.0);
        at = moved(at, mean, step);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Under a small load the ring of Timoshenko (Strength of Materials II, 1941, section 12): the diameter along the load shrinks by (π/4 − 2/π) W R³/(E' I), about
    /// 0.149, and the one across grows by (2/π − 1/2) W R³/(E' I), about 0.137. What is left out is in proportion to the load.
    #[test]
    fn a_little_flattened_ring_is_that_of_timoshenko() {
        let errors = [1e-3, 1e-4].map(|flattening| {
            let ring = FlattenedRing::at_height(1.0 - flattening);
            let shrinks = (0.25 * PI - 2.0 / PI) * ring.load / (2.0 * flattening) - 1.0;
            let grows = 2.0 * (ring.width - 1.0) / ((2.0 / PI - 0.5) * ring.load) - 1.0;
            [shrinks, grows]
        });
        for k in [0, 1] {
            let [coarse, fine] = [errors[0][k], errors[1][k]];
            assert!(coarse.abs() < 2e-3, "{errors:?}");
            assert!((coarse / fine - 10.0).abs() < 0.1, "{errors:?}");
        }
    }

    /// Half as many steps of a method of the fourth order are off sixteen times as far: a check of the balance along the quarter, by its first integral
    /// θ'²/2 − (W R²/2 E' I) sin θ, which stays what it is at the line.
    #[test]
    fn the_balance_along_the_quarter_holds() {
        let (half_load, bend) = (1.2, 0.13);
        let [angle, curvature, ..] = quarter(half_load, bend);
        let integral = 0.5 * curvature * curvature - half_load * libm::sin(angle);
        assert!((integral - 0.5 * bend * bend).abs() < 1e-11, "{integral}");
    }
}
