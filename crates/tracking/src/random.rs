//! Random numbers : one stream for each purpose, so that one does not shift another.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::PI;

/// A stream of random numbers, the same on every machine.
pub(crate) struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of this number of a seed.
    pub fn new(seed: u64, number: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(number);
        Self(generator)
    }

    /// Evenly in \[0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Exponential, mean 1.
    pub fn exponential(&mut self) -> f64 {
        // 1 − u is above 0.
        -libm::log(1.0 - self.unit())
    }

    /// Normal, mean 0, standard deviation 1 (Box and Muller 1958, one of the two).
    pub fn normal(&mut self) -> f64 {
        let length = (2.0 * self.exponential()).sqrt();
        length * libm::cos(2.0 * PI * self.unit())
    }

    /// Half-normal, mean 1.
    pub fn half_normal(&mut self) -> f64 {
        // The mean of |N(0, 1)| is √(2/π).
        self.normal().abs() * (0.5 * PI).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means and variances of 20 000 numbers against the closed forms, within four standard errors: σ/√n for a mean (σ = 1 for
    /// the normal and the exponential, √(π/2 − 1) for the half-normal of mean 1), √(2/n) for the normal's variance.
    #[test]
    fn moments() {
        let n = 20_000;
        let mut stream = Stream::new(5, 3);
        let normal: Vec<f64> = (0..n).map(|_| stream.normal()).collect();
        let exponential: Vec<f64> = (0..n).map(|_| stream.exponential()).collect();
        let half: Vec<f64> = (0..n).map(|_| stream.half_normal()).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / n as f64;
        let error = 4.0 / f64::from(n).sqrt();
        assert!(mean(&normal).abs() < error);
        let squares: Vec<f64> = normal.iter().map(|x| x * x).collect();
        assert!((mean(&squares) - 1.0).abs() < 2.0_f64.sqrt() * error);
        assert!((mean(&exponential) - 1.0).abs() < error);
        assert!((mean(&half) - 1.0).abs() < (0.5 * PI - 1.0).sqrt() * error);
    }

    #[test]
    fn streams_of_a_seed_differ_and_come_back() {
        let first = |seed, number| Stream::new(seed, number).unit();
        assert_eq!(first(1, 0), first(1, 0));
        assert_ne!(first(1, 0), first(1, 1));
        assert_ne!(first(1, 0), first(2, 0));
    }
}
