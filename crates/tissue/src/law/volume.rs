//! Logarithm and power of the volume ratio, for laws that have one.

use crate::number::Number;

/// J from which down the logarithm is replaced.
pub(super) const SMALLEST_VOLUME: f64 = 0.2;

/// ln J; below [`SMALLEST_VOLUME`] its Taylor polynomial of second order, which has values for every J and a slope that goes on growing
/// towards inversion.
#[inline(always)]
pub(super) fn log_volume<N: Number>(j: N) -> N {
    let at = j.most(N::of(SMALLEST_VOLUME));
    let slope = N::of(1.0) / at;
    let below = j - at;
    at.natural_log() + below * slope - N::of(0.5) * (below * slope) * (below * slope)
}

/// Its first two derivatives.
#[inline(always)]
pub(super) fn log_volume_slopes<N: Number>(j: N) -> [N; 2] {
    let at = j.most(N::of(SMALLEST_VOLUME));
    let slope = N::of(1.0) / at;
    let below = j - at;
    [slope - below * slope * slope, -slope * slope]
}

/// J^(−2/3) and its first two derivatives; below [`SMALLEST_VOLUME`] its Taylor polynomial of second order.
#[inline(always)]
pub(super) fn volume_power<N: Number>(j: N) -> [N; 3] {
    let of = N::of;
    let at = j.most(of(SMALLEST_VOLUME));
    let root = at.cube_root();
    let power = of(1.0) / (root * root);
    let slope = of(-2.0 / 3.0) * power / at;
    let curvature = of(-5.0 / 3.0) * slope / at;
    let below = j - at;
    [
        power + below * (slope + of(0.5) * below * curvature),
        slope + below * curvature,
        curvature,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_continuation_is_smooth() {
        let [above, below] = [0.0, -1e-15].map(|d| {
            let j = SMALLEST_VOLUME + d;
            let [slope, curvature] = log_volume_slopes(j);
            [log_volume(j), slope, curvature]
        });
        for k in 0..3 {
            // 1e-15 times the next derivative, 2/J³ = 250, and rounding of values up to 25.
            assert!((above[k] - below[k]).abs() < 3e-13, "{above:?} {below:?}");
        }
        let [above, below] = [0.0, -1e-15].map(|d| volume_power(SMALLEST_VOLUME + d));
        for k in 0..3 {
            // 1e-15 times the next derivative, 80/27 J^(−11/3) = 1083, and rounding of values up to 81.
            assert!((above[k] - below[k]).abs() < 2e-12, "{above:?} {below:?}");
        }
    }

    /// At 8 the cube root is 2: 1/4, −2/3 · 1/4 / 8 and 10/9 · 1/4 / 64.
    #[test]
    fn the_power_of_the_volume_has_its_derivatives() {
        let expected = [0.25, -1.0 / 48.0, 5.0 / 1152.0];
        for (value, expected) in volume_power(8.0).iter().zip(expected) {
            assert!((value - expected).abs() < 1e-16, "{value} {expected}");
        }
    }
}
