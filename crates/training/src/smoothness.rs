//! Smoothness of a speed profile: spectral arc length and log dimensionless jerk.
//!
//! SPARC: Balasubramanian, Melendez-Calderon, Burdet (2012) and the 2015 paper "On the analysis of movement smoothness". It is defined for
//! one movement: the speed profile of several, with rests between them, has the spectrum of their rhythm.
//! LDLJ: the same 2015 paper. Definitions and check values: DOMAIN 2.
//!
//! LDLJ lives on second differences: noise, the sampling rate and the interpolation all move it. Compare values of the
//! same rate and formula only. SPARC sees nothing above 10 Hz, nor anything below 5 % of the strongest component.

use crate::fft;

/// Highest frequency that SPARC looks at \[Hz\].
pub const SPARC_FREQUENCY_MAX_HZ: f64 = 10.0;

/// Fraction of the strongest component below which SPARC cuts the spectrum's ends off.
pub const SPARC_AMPLITUDE_MIN: f64 = 0.05;

/// Zero padding of SPARC, as a power of two.
const SPARC_PADDING: u32 = 4;

/// Spectral arc length of a speed profile sampled at `rate` \[Hz\]; negative, nearer to 0 is smoother.
///
/// V(f) = |FFT(v, nfft)|, nfft = 2^(⌈log2 N⌉+4), over its maximum; of f ≤ 10 Hz the bins from the first to the last with
/// V ≥ 0.05; −Σ sqrt((Δf/(f_last − f_first))² + (ΔV)²).
///
/// `None` for a profile that is empty, zero or not finite, for one with fewer than two such bins, and for a rate below
/// 20 Hz, which holds no 10 Hz.
pub fn sparc(speed: &[f64], rate: f64) -> Option<f64> {
    if speed.is_empty() || rate.is_nan() || rate < 2.0 * SPARC_FREQUENCY_MAX_HZ {
        return None;
    }
    let size = speed.len().next_power_of_two() << SPARC_PADDING;
    let power = fft::power_spectrum(speed, size);
    let largest = power.iter().copied().fold(0.0, f64::max);
    if !largest.is_normal() {
        return None;
    }
    let bin = rate / size as f64;
    let amplitude: Vec<f64> = power
        .iter()
        .enumerate()
        .take_while(|(k, _)| *k as f64 * bin <= SPARC_FREQUENCY_MAX_HZ)
        .map(|(_, value)| (value / largest).sqrt())
        .collect();
    let first = amplitude
        .iter()
        .position(|&value| value >= SPARC_AMPLITUDE_MIN)?;
    let last = amplitude
        .iter()
        .rposition(|&value| value >= SPARC_AMPLITUDE_MIN)?;
    let bins = &amplitude[first..=last];
    let step = 1.0 / (last - first) as f64;
    let length: f64 = bins
        .windows(2)
        .map(|pair| (step * step + (pair[1] - pair[0]) * (pair[1] - pair[0])).sqrt())
        .sum();
    (bins.len() > 1).then_some(-length)
}

/// Log dimensionless jerk of a speed profile sampled at `rate` \[Hz\]; larger (less negative) is smoother.
///
/// −ln[(T³/v_peak²)·Σ(d²v/dt²)²·dt] with T = N·dt and second differences. `None` for fewer than three values, for a
/// profile that is zero or not finite, and for one without any jerk (even or evenly accelerated), whose logarithm has no
/// bound.
pub fn ldlj(speed: &[f64], rate: f64) -> Option<f64> {
    let step = 1.0 / rate;
    let peak = speed
        .iter()
        .copied()
        .fold(0.0, |peak: f64, value| peak.max(value.abs()));
    let squared: f64 = speed
        .windows(3)
        .map(|three| {
            let jerk = (three[2] - 2.0 * three[1] + three[0]) / (step * step);
            jerk * jerk
        })
        .sum();
    let duration = speed.len() as f64 * step;
    let dimensionless = duration * duration * duration / (peak * peak) * squared * step;
    dimensionless.is_normal().then(|| -libm::log(dimensionless))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The signal of DOMAIN 2: v = exp(−5t²), t = −1..1 (end excluded), step 0.01.
    fn domain_signal() -> Vec<f64> {
        (0..200)
            .map(|k| {
                let t = -1.0 + k as f64 * 0.01;
                libm::exp(-5.0 * t * t)
            })
            .collect()
    }

    /// DOMAIN 2: −1.41403, the value of the published reference code on its own example.
    #[test]
    fn sparc_of_the_published_signal() {
        let value = sparc(&domain_signal(), 100.0).expect("a signal");
        assert!((value + 1.41403).abs() < 5e-6, "{value}");
    }

    /// DOMAIN 2: −5.81636 on the same signal.
    #[test]
    fn ldlj_of_the_published_signal() {
        let value = ldlj(&domain_signal(), 100.0).expect("a signal");
        assert!((value + 5.81636).abs() < 5e-6, "{value}");
    }

    /// Closed form: v = τ²(1−τ)² peaks at 1/16 and has ∫(v″)²dτ = 4/5, so that LDLJ = −ln(256·4/5) = −ln 204.8.
    #[test]
    fn ldlj_of_a_minimum_jerk_movement() {
        let count = 10_000;
        let profile: Vec<f64> = (0..count)
            .map(|k| {
                let tau = k as f64 / count as f64;
                tau * tau * (1.0 - tau) * (1.0 - tau)
            })
            .collect();
        // Duration 2 s: the value must not depend on it.
        let value = ldlj(&profile, count as f64 / 2.0).expect("a signal");
        // The second differences leave out two intervals at the ends, where (v″)² = 4 is five times its mean: 10/N of
        // the sum is missing. Everything else is of order 1/N².
        let expected = -libm::log(204.8) + 10.0 / count as f64;
        assert!(
            (value - expected).abs() < 100.0 / (count as f64 * count as f64),
            "{value} {expected}"
        );
    }

    #[test]
    fn two_bumps_are_less_smooth_than_one() {
        let bump = domain_signal();
        let twice: Vec<f64> = bump.iter().chain(&bump).copied().collect();
        let (one, two) = (sparc(&bump, 100.0), sparc(&twice, 100.0));
        assert!(two < one, "{two:?} {one:?}");
        let (one, two) = (ldlj(&bump, 100.0), ldlj(&twice, 100.0));
        assert!(two < one, "{two:?} {one:?}");
    }

    #[test]
    fn what_has_no_smoothness_has_no_value() {
        assert_eq!(sparc(&[], 100.0), None);
        assert_eq!(sparc(&[0.0; 50], 100.0), None);
        assert_eq!(sparc(&[f64::NAN; 50], 100.0), None);
        assert_eq!(sparc(&domain_signal(), 19.0), None);
        assert_eq!(ldlj(&[1.0, 2.0], 100.0), None);
        assert_eq!(ldlj(&[0.0; 50], 100.0), None);
        assert_eq!(ldlj(&[1.0, 2.0, 3.0, 4.0], 100.0), None);
        assert_eq!(ldlj(&[1.0, f64::NAN, 3.0, 4.0], 100.0), None);
    }

    proptest! {
        /// Both are dimensionless: the unit of speed, and for LDLJ the unit of time, must not matter. A factor of two
        /// changes no rounding, so SPARC stays the same to the bit.
        #[test]
        fn scale_does_not_matter(profile in prop::collection::vec(0.1..1.0f64, 8..100), exponent in -20..20i32) {
            let scaled: Vec<f64> = profile.iter().map(|value| libm::scalbn(*value, exponent)).collect();
            prop_assert_eq!(sparc(&profile, 100.0), sparc(&scaled, 100.0));
            let (a, b) = (ldlj(&profile, 100.0).expect("jerk"), ldlj(&scaled, 37.0).expect("jerk"));
            // Some ten roundings before the logarithm, the sum of 100 positive terms among them.
            prop_assert!((a - b).abs() < 200.0 * f64::EPSILON);
        }
    }
}
