//! The exponential of one number or of four, without branches and tables.
//!
//! q = n ln 2 + r with a whole n and |r| ≤ ½ ln 2 (Cody & Waite 1980), eʳ − 1 as its Taylor polynomial of degree 13 and 2ⁿ by the bits of
//! the exponent. What the polynomial leaves out, r¹⁴/14! and more, is below 2⁻⁵⁷ of eʳ, a twentieth of a last digit.

use crate::number::{Number, WHOLE};

/// The first 33 bits of ln 2, so that n times it is exact, and the rest (as in `fdlibm`).
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// e^q − 1 and e^q for 0 ≤ q ≤ 700, both right to two units in the last place.
#[inline(always)]
pub(super) fn exponential<N: Number>(q: N) -> [N; 2] {
    let of = N::of;
    let turns = (q * of(std::f64::consts::LOG2_E) + of(WHOLE)) - of(WHOLE);
    let r = (q - turns * of(LN_2[0])) - turns * of(LN_2[1]);
    // Σ rᵏ/(k + 2)! in pairs, pairs of pairs and so on (Estrin), short chains of sums.
    let pair = |k: usize| of(FACTORS[k]) + of(FACTORS[k + 1]) * r;
    let square = r * r;
    let fourth = square * square;
    let low = pair(0) + pair(2) * square;
    let middle = pair(4) + pair(6) * square;
    let high = pair(8) + pair(10) * square;
    let growth = r + square * (low + fourth * (middle + fourth * high));
    let scale = turns.power_of_two();
    [growth * scale + (scale - of(1.0)), growth * scale + scale]
}

/// 1/2!, 1/3! and so on to 1/13!.
const FACTORS: [f64; 12] = {
    let mut factors = [0.0; 12];
    let (mut factorial, mut k) = (1.0, 0);
    while k < 12 {
        factorial *= (k + 2) as f64;
        factors[k] = 1.0 / factorial;
        k += 1;
    }
    factors
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Lanes;

    /// Against `libm`, whose values are right to one unit in the last place; with two of these the difference is at most three units, each
    /// at most ε of the value.
    #[test]
    fn it_is_that_of_the_library() {
        for k in 0..=20_000 {
            // Over all of the range, and where e^q − 1 is small.
            for q in [
                0.035 * f64::from(k),
                1e-7 * f64::from(k),
                1e-16 * f64::from(k),
            ] {
                let expected = [libm::expm1(q), libm::exp(q)];
                for (value, expected) in exponential(q).into_iter().zip(expected) {
                    let difference = (value - expected).abs();
                    assert!(difference <= 3.0 * f64::EPSILON * expected, "{q}: {value}");
                }
            }
        }
    }

    #[test]
    fn four_are_those_of_each_by_itself() {
        let q = [0.0, 0.3, 11.9, 5e-9];
        let [growth, exp] = exponential(Lanes(q));
        for (lane, q) in q.into_iter().enumerate() {
            assert_eq!([growth.0[lane], exp.0[lane]], exponential(q));
        }
    }
}
