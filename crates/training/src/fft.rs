//! A radix-2 fast Fourier transform with the same bits on every machine.
//!
//! Published transforms choose their instructions at run time, and so their rounding; this one does not. It is the plain
//! iterative form of Cooley & Tukey (1965), with each twiddle factor from `libm` rather than from a recurrence.

use std::f64::consts::PI;

/// A complex number: real part, imaginary part.
pub type Complex = [f64; 2];

/// Transforms in place: X_k = Σ x_n·exp(−2πi·k·n/N), unscaled.
///
/// # Panics
/// If the length is not a power of two: the callers pad.
pub fn transform(values: &mut [Complex]) {
    let length = values.len();
    assert!(
        length.is_power_of_two(),
        "transform of {length} values: not a power of two"
    );
    if length == 1 {
        return;
    }

    // Bit reversal: afterwards each butterfly works on neighbours.
    let unused_bits = usize::BITS - length.trailing_zeros();
    for index in 0..length {
        let mirrored = index.reverse_bits() >> unused_bits;
        if index < mirrored {
            values.swap(index, mirrored);
        }
    }

    let twiddles: Vec<Complex> = (0..length / 2)
        .map(|k| {
            let angle = -2.0 * PI * k as f64 / length as f64;
            [libm::cos(angle), libm::sin(angle)]
        })
        .collect();

    let mut half = 1;
    while half < length {
        let stride = length / (2 * half);
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for k in 0..half {
                let [c, s] = twiddles[k * stride];
                let [re, im] = high[k];
                let turned = [c * re - s * im, c * im + s * re];
                let [low_re, low_im] = low[k];
                low[k] = [low_re + turned[0], low_im + turned[1]];
                high[k] = [low_re - turned[0], low_im - turned[1]];
            }
        }
        half *= 2;
    }
}

/// |X_k|² for k = 0 ..= size/2 of real values, padded with zeros to `size`.
///
/// # Panics
/// If `size` is not a power of two, or smaller than the number of values.
pub fn power_spectrum(values: &[f64], size: usize) -> Vec<f64> {
    assert!(
        values.len() <= size,
        "{} values do not fit a transform of {size}",
        values.len()
    );
    let mut buffer = vec![[0.0, 0.0]; size];
    for (slot, &value) in buffer.iter_mut().zip(values) {
        slot[0] = value;
    }
    transform(&mut buffer);
    buffer[..=size / 2]
        .iter()
        .map(|[re, im]| re * re + im * im)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the definition, summed term by term.
    #[test]
    fn agrees_with_the_sum_that_it_stands_for() {
        for length in [1usize, 2, 4, 8, 64] {
            let input: Vec<Complex> = (0..length)
                .map(|n| {
                    [
                        ((n * n * 7 + 3) % 11) as f64 - 5.0,
                        ((n * 5 + 1) % 7) as f64 - 3.0,
                    ]
                })
                .collect();
            let mut output = input.clone();
            transform(&mut output);
            for (k, found) in output.iter().enumerate() {
                let mut expected = [0.0, 0.0];
                for (n, [re, im]) in input.iter().enumerate() {
                    // The angle is reduced in integers, so that it is as exact as the twiddles.
                    let angle = -2.0 * PI * ((k * n) % length) as f64 / length as f64;
                    let (c, s) = (libm::cos(angle), libm::sin(angle));
                    expected[0] += c * re - s * im;
                    expected[1] += c * im + s * re;
                }
                // Values below 8, 64 terms, round-off 2⁻⁵³ in each of a few operations per term.
                for part in 0..2 {
                    assert!((found[part] - expected[part]).abs() < 64.0 * 8.0 * 8.0 * f64::EPSILON);
                }
            }
        }
    }

    /// Parseval: Σ|x|² = Σ|X|²/N, here from the half spectrum.
    #[test]
    fn power_is_conserved() {
        let values: Vec<f64> = (0..50).map(|n| ((n * 37) % 19) as f64 - 9.0).collect();
        let power = power_spectrum(&values, 128);
        let mirrored: f64 = power[1..64].iter().sum();
        let found = (power[0] + 2.0 * mirrored + power[64]) / 128.0;
        let expected: f64 = values.iter().map(|value| value * value).sum();
        assert!((found / expected - 1.0).abs() < 1e-13);
    }
}
