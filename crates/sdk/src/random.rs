//! Named random streams: one seed per run, one stream per name, so that a new consumer does not shift the others.

use microsim_bus::kind_id;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// A stream of random numbers (ChaCha with 8 rounds, the same on every machine); saved as its place in the stream.
///
/// ```
/// use microsim_sdk::RandomStream;
///
/// let mut places = RandomStream::new(7, "my-module.places");
/// let x = places.between(-5e-3, 5e-3);
/// assert!((-5e-3..5e-3).contains(&x));
/// // The same seed and name give the same numbers, from any saved place on.
/// let mut again = RandomStream::restore(&places.save());
/// assert_eq!(again.bits(), places.bits());
/// ```
#[derive(Clone, Debug)]
pub struct RandomStream {
    seed: [u8; 32],
    generator: ChaCha8Rng,
}

/// A stream's place, for `save` and `restore`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RandomState {
    seed: [u8; 32],
    word: [u64; 2],
}

impl RandomStream {
    /// The stream `name` of a run with seed `seed`.
    pub fn new(seed: u64, name: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&kind_id(name).to_le_bytes());
        Self {
            seed: key,
            generator: ChaCha8Rng::from_seed(key),
        }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// A number in \[0, 1) with 53 random bits.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A number in \[low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The stream's place.
    pub fn save(&self) -> RandomState {
        let word = self.generator.get_word_pos();
        RandomState {
            seed: self.seed,
            word: [word as u64, (word >> 64) as u64],
        }
    }

    /// The stream at a saved place.
    pub fn restore(state: &RandomState) -> Self {
        let mut generator = ChaCha8Rng::from_seed(state.seed);
        generator.set_word_pos(u128::from(state.word[0]) | u128::from(state.word[1]) << 64);
        Self {
            seed: state.seed,
            generator,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_reproducible_apart_and_restorable() {
        let mut a = RandomStream::new(7, "places");
        let mut b = RandomStream::new(7, "places");
        let mut other = RandomStream::new(7, "colours");
        let first: Vec<u64> = (0..5).map(|_| a.bits()).collect();
        assert_eq!(first, (0..5).map(|_| b.bits()).collect::<Vec<_>>());
        assert_ne!(first[0], other.bits());
        let mut c = RandomStream::restore(&a.save());
        assert_eq!(a.bits(), c.bits());
        // Mean of n uniform numbers: 1/2 with standard deviation 1/sqrt(12 n); 6 of them bound the test.
        let n = 10_000;
        let mean = (0..n).map(|_| a.unit()).sum::<f64>() / f64::from(n);
        assert!(
            (mean - 0.5).abs() < 6.0 / (12.0 * f64::from(n)).sqrt(),
            "mean {mean}"
        );
    }
}
