//! Tremor: what moves the tip in the band of the physiological tremor.
//!
//! DOMAIN 2: detrend, Hann window, power spectral density of x, y, z summed, root of the integral over 8..12 Hz. One window
//! over the whole segment: its middle counts more than its ends. Deliberate motion with content in the band counts too.

use std::f64::consts::PI;

use crate::fft;

/// Lower end of the band \[Hz\].
pub const TREMOR_LOW_HZ: f64 = 8.0;

/// Upper end of the band \[Hz\].
pub const TREMOR_HIGH_HZ: f64 = 12.0;

/// Root mean square \[m\] of the motion between 8 and 12 Hz of positions sampled at `rate` \[Hz\], all axes together.
///
/// One-sided density P_k = 2·|X_k|²/(rate·Σw²), w the Hann window: a vibration A·sin along one axis gives A/√2, however
/// long the segment. `None` for fewer than three positions, or a rate that holds no 12 Hz (up to 24 Hz).
///
/// The window's lobe is ±2/T wide: below about 1 s the band's edges blur by more than the half width of the band.
pub fn tremor_rms(positions: &[[f64; 3]], rate: f64) -> Option<f64> {
    let count = positions.len();
    if count < 3 || rate.is_nan() || rate <= 2.0 * TREMOR_HIGH_HZ {
        return None;
    }
    let window: Vec<f64> = (0..count)
        .map(|n| 0.5 - 0.5 * libm::cos(2.0 * PI * n as f64 / count as f64))
        .collect();
    let window_power: f64 = window.iter().map(|weight| weight * weight).sum();
    let size = count.next_power_of_two();
    let bin = rate / size as f64;

    let mut variance = 0.0;
    for axis in 0..3 {
        let mut values: Vec<f64> = positions.iter().map(|position| position[axis]).collect();
        detrend(&mut values);
        values
            .iter_mut()
            .zip(&window)
            .for_each(|(value, weight)| *value *= weight);
        for (k, power) in fft::power_spectrum(&values, size).into_iter().enumerate() {
            if (TREMOR_LOW_HZ..=TREMOR_HIGH_HZ).contains(&(k as f64 * bin)) {
                variance += 2.0 * power / (rate * window_power) * bin;
            }
        }
    }
    variance.is_finite().then(|| variance.sqrt())
}

/// Takes the straight line of least squares away.
fn detrend(values: &mut [f64]) {
    let count = values.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = values.iter().sum::<f64>() / count;
    let (mut moment, mut spread) = (0.0, 0.0);
    for (n, value) in values.iter().enumerate() {
        let x = n as f64 - middle;
        moment += x * (value - mean);
        spread += x * x;
    }
    let slope = moment / spread;
    for (n, value) in values.iter_mut().enumerate() {
        *value -= mean + slope * (n as f64 - middle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 60.0;

    /// A vibration of the given amplitude, frequency and direction on top of a drift.
    fn vibration(
        seconds: f64,
        amplitude: f64,
        frequency: f64,
        direction: [f64; 3],
    ) -> Vec<[f64; 3]> {
        let count = (seconds * RATE) as usize;
        (0..count)
            .map(|n| {
                let t = n as f64 / RATE;
                let s = amplitude * libm::sin(2.0 * PI * frequency * t);
                [0, 1, 2].map(|axis| 0.1 + 2e-3 * t * (axis as f64 - 1.0) + s * direction[axis])
            })
            .collect()
    }

    /// Closed form A/√2. The drift is removed exactly; the line fitted to m = 10·T cycles of a sine has a slope term of
    /// relative power 6/(π·m)², and it lies far from the band; side lobes of the Hann window beyond ±2 Hz (2·T bins) hold
    /// less than 0.1 % of the power: together below 0.1 % for T ≥ 2 s.
    #[test]
    fn rms_of_a_pure_vibration() {
        let amplitude = 50e-6;
        for seconds in [2.0, 3.7, 10.0, 34.2] {
            for direction in [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]] {
                let found = tremor_rms(&vibration(seconds, amplitude, 10.0, direction), RATE)
                    .expect("long enough");
                let expected = amplitude / 2.0f64.sqrt();
                assert!(
                    (found / expected - 1.0).abs() < 1e-3,
                    "{seconds} s: {found} {expected}"
                );
            }
        }
    }

    /// Outside the band almost nothing is left: a slow deliberate motion of 5 mm shows less than 1 µm.
    #[test]
    fn deliberate_motion_is_not_tremor() {
        // Hann side lobes fall with the cube of the distance in bins: from 1 Hz to 8 Hz over 10 s that is 70 bins, an
        // amplitude below 1/70³ = 3·10⁻⁶ of 5 mm per bin, 40 bins.
        let found =
            tremor_rms(&vibration(10.0, 5e-3, 1.0, [1.0, 0.0, 0.0]), RATE).expect("long enough");
        assert!(found < 40f64.sqrt() * 5e-3 * 3e-6, "{found}");
        let still =
            tremor_rms(&vibration(10.0, 0.0, 10.0, [1.0, 0.0, 0.0]), RATE).expect("long enough");
        assert!(still < 1e-15, "a drift alone: {still}");
    }

    #[test]
    fn a_rate_that_cannot_hold_the_band_has_no_value() {
        assert_eq!(
            tremor_rms(&vibration(4.0, 1e-4, 10.0, [1.0, 0.0, 0.0]), 24.0),
            None
        );
        assert_eq!(tremor_rms(&[[0.0; 3]; 2], RATE), None);
        assert_eq!(tremor_rms(&[[f64::NAN; 3]; 99], RATE), None);
    }
}
