//! Roots of functions of one and of a few unknowns.

use nalgebra::{DMatrix, DVector};

/// Steps of Newton's method: it squares its error, so those that are not enough will never be.
const STEPS: usize = 60;

/// Largest relative change of an unknown in a step.
const LARGEST_CHANGE: f64 = 0.1;

/// The root of a rising function between two places, to rounding; not a number where the function has the same sign at both.
pub fn root(function: &dyn Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    let (mut below, mut above) = (function(low), function(high));
    // Neither is true of what is no number.
    if !(below <= 0.0 && above >= 0.0) {
        return f64::NAN;
    }
    // The rule of false position with the halving of Dowell & Jarratt (1971), so that no end stays for ever.
    let mut last = 0;
    let mut best = if -below < above {
        (low, -below)
    } else {
        (high, above)
    };
    for step in 0..200 {
        // Every third time the half, where false position would creep along a steep function or meet infinity.
        let position = (low * above - high * below) / (above - below);
        let creeps = step % 3 == 2 || !(low < position && position < high);
        let middle = if creeps { 0.5 * (low + high) } else { position };
        if !(low < middle && middle < high) {
            break;
        }
        let value = function(middle);
        if value.abs() < best.1 {
            best = (middle, value.abs());
        }
        if value < 0.0 {
            (low, below) = (middle, value);
            above *= if last == -1 { 0.5 } else { 1.0 };
            last = -1;
        } else {
            (high, above) = (middle, value);
            below *= if last == 1 { 0.5 } else { 1.0 };
            last = 1;
        }
    }
    best.0
}

/// Positive unknowns at which all of `residuals` are zero, from `start`: until the last relative change is below `tolerance`.
///
/// # Panics
/// If the method does not converge.
pub fn solve<const N: usize>(
    residuals: &dyn Fn([f64; N]) -> [f64; N],
    start: [f64; N],
    tolerance: f64,
) -> [f64; N] {
    let mut at = start;
    for _ in 0..STEPS {
        // By relative changes, in central differences: the error is 1e-10 of the third derivative.
        let h = 1e-5;
        let mut jacobian = DMatrix::zeros(N, N);
        for column in 0..N {
            let moved = |factor: f64| {
                let mut moved = at;
                moved[column] *= factor;
                DVector::from_row_slice(&residuals(moved))
            };
            let slope = (moved(1.0 + h) - moved(1.0 - h)) / (2.0 * h);
            jacobian.set_column(column, &slope);
        }
        let value = DVector::from_row_slice(&residuals(at));
        let step = jacobian.lu().solve(&value);
        let mut change = step.unwrap_or_else(|| panic!("no direction at {at:?}: {value}"));
        let largest = change.amax();
        assert!(largest.is_finite(), "no number at {at:?}");
        change *= (LARGEST_CHANGE / largest).min(1.0);
        for (unknown, change) in at.iter_mut().zip(change.iter()) {
            *unknown *= 1.0 - change;
        }
        if largest < tolerance {
            return at;
        }
    }
    panic!(
        "no root from {start:?} after {STEPS} steps: {at:?}, {:?}",
        residuals(at)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_known_functions_are_found() {
        let found = root(&|x| x * x - 2.0, [0.0, 40.0]);
        assert!((found - 2.0_f64.sqrt()).abs() < 1e-15);
        // Steep and beyond all numbers at one end, as an exponential law is.
        for end in [5.0, 50.0] {
            let found = root(&|x| libm::expm1(20.0 * x * x) - 1.0, [0.0, end]);
            assert!((20.0 * found * found - std::f64::consts::LN_2).abs() < 1e-14);
        }
        assert!(root(&|x| x * x + 1.0, [0.0, 1.0]).is_nan());
        assert!(root(&|_| f64::NAN, [0.0, 1.0]).is_nan());
        // x y = 6, x + y = 5.
        let [x, y] = solve(&|[x, y]| [x * y - 6.0, x + y - 5.0], [1.0, 9.0], 1e-12);
        assert!((x - 2.0).abs() < 1e-12 && (y - 3.0).abs() < 1e-12);
    }

    #[test]
    #[should_panic(expected = "no root from")]
    fn what_has_no_root_is_not_solved() {
        solve(&|[x]| [x * x + 1.0], [0.7], 1e-12);
    }
}
