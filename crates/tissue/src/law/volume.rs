//! The logarithm of the volume ratio, for laws that have one.

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
    }
}
