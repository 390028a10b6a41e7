//! Pseudo-random numbers for tests, examples and start vectors: the same seed gives the same numbers on every machine.
//!
//! What is not here: the random streams of a session, which are saved and restored (`microsim_sdk::RandomStream`), and
//! those of the synthetic trainees.
#![forbid(unsafe_code)]

use nalgebra::Vector3;

/// The generator SplitMix64 (Steele, Lea & Flood 2014), made from a seed. Good bits in every place.
///
/// ```
/// use microsim_random::SplitMix64;
///
/// let mut random = SplitMix64(7);
/// assert!((-1.0..1.0).contains(&random.number()));
/// assert!(random.below(6) < 6);
/// ```
#[derive(Clone, Debug)]
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// One of 0..`count`; `count` above 0.
    pub fn below(&mut self, count: u64) -> u64 {
        self.bits() % count
    }

    /// Uniform in [−1, 1).
    pub fn number(&mut self) -> f64 {
        signed_unit(self.bits())
    }

    /// Uniform in [−1, 1) on each axis.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.number(), self.number(), self.number())
    }
}

/// A linear congruential generator (Knuth's MMIX constants), made from a seed. Its upper bits are used; its lower bits
/// have short periods.
#[derive(Clone, Debug)]
pub struct Congruential(pub u64);

impl Congruential {
    /// Uniform in [−1, 1).
    pub fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        signed_unit(self.0)
    }

    /// One of 0..`count`; `count` above 0.
    pub fn below(&mut self, count: usize) -> usize {
        (((self.number() + 1.0) / 2.0 * count as f64) as usize).min(count - 1)
    }

    /// Uniform in [−1, 1) on each axis.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.number(), self.number(), self.number())
    }
}

/// The upper 53 bits as a number in [−1, 1).
fn signed_unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs for seed 1234567 of the authors' reference implementation (splitmix64.c of Vigna).
    #[test]
    fn splitmix_is_that_of_its_authors() {
        let mut random = SplitMix64(1_234_567);
        assert_eq!(random.bits(), 6_457_827_717_110_365_317);
        assert_eq!(random.bits(), 3_203_168_211_198_807_973);
        assert_eq!(random.bits(), 9_817_491_932_198_370_423);
    }

    /// Mean 0 and variance 1/3 of n uniform numbers in −1..1, within six standard errors (√(1/(3n)), √(4/(45n))).
    #[test]
    fn numbers_are_uniform() {
        let n = 20_000;
        let mut mix = SplitMix64(3);
        let mut congruential = Congruential(3);
        let series: [Vec<f64>; 2] = [
            (0..n).map(|_| mix.number()).collect(),
            (0..n).map(|_| congruential.number()).collect(),
        ];
        for numbers in series {
            let mean = numbers.iter().sum::<f64>() / f64::from(n);
            let variance = numbers.iter().map(|x| x * x).sum::<f64>() / f64::from(n);
            assert!(mean.abs() < 6.0 / (3.0 * f64::from(n)).sqrt(), "{mean}");
            assert!(
                (variance - 1.0 / 3.0).abs() < 6.0 * (4.0 / (45.0 * f64::from(n))).sqrt(),
                "{variance}"
            );
            assert!(numbers.iter().all(|x| (-1.0..1.0).contains(x)));
        }
    }
}
