//! Logarithm and power of the volume ratio, for laws that have one.

/// J from which down the logarithm is replaced.
pub(super) const SMALLEST_VOLUME: f64 = 0.2;

/// ln J and its first two derivatives; below [`SMALLEST_VOLUME`] its Taylor polynomial of second order, which has values for every J
/// and a slope that goes on growing towards inversion.
#[inline]
pub(super) fn log_volume(j: f64) -> [f64; 3] {
    if j >= SMALLEST_VOLUME {
        let inverse = 1.0 / j;
        return [libm::log(j), inverse, -inverse * inverse];
    }
    const SLOPE: f64 = 1.0 / SMALLEST_VOLUME;
    let below = j - SMALLEST_VOLUME;
    [
        libm::log(SMALLEST_VOLUME) + below * SLOPE - 0.5 * (below * SLOPE) * (below * SLOPE),
        SLOPE - below * SLOPE * SLOPE,
        -SLOPE * SLOPE,
    ]
}

/// J^(−2/3) and its first two derivatives; below [`SMALLEST_VOLUME`] its Taylor polynomial of second order.
#[inline]
pub(super) fn volume_power(j: f64) -> [f64; 3] {
    let at = j.max(SMALLEST_VOLUME);
    let root = libm::cbrt(at);
    let power = 1.0 / (root * root);
    let slope = -2.0 / 3.0 * power / at;
    let curvature = -5.0 / 3.0 * slope / at;
    let below = j - at;
    [
        power + below * (slope + 0.5 * below * curvature),
        slope + below * curvature,
        curvature,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_continuation_is_smooth() {
        let [above, below] = [0.0, -1e-15].map(|d| log_volume(SMALLEST_VOLUME + d));
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
