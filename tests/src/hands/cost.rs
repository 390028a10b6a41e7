//! CPU time of pictures, as a histogram that can be stored and added up.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The time of a picture \[s\].
pub const PICTURE: f64 = 16e-3;

/// Ratio of the bounds of a bin: percentiles are exact to 2 %.
const RATIO: f64 = 1.02;

/// How often pictures took how long.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Costs {
    /// Pictures by the number of their bin: the k-th ends at `RATIO` to the power of k \[µs\].
    bins: BTreeMap<i32, u64>,
    /// The longest \[ms\].
    pub most: f64,
}

impl Costs {
    /// Adds a picture that took so long \[ms\].
    pub fn add(&mut self, milliseconds: f64) {
        let microseconds = (1e3 * milliseconds).max(1.0);
        let bin = (libm::log(microseconds) / libm::log(RATIO)).ceil() as i32;
        *self.bins.entry(bin).or_default() += 1;
        self.most = self.most.max(milliseconds);
    }

    /// Adds all of another histogram.
    pub fn append(&mut self, other: &Self) {
        for (bin, count) in &other.bins {
            *self.bins.entry(*bin).or_default() += count;
        }
        self.most = self.most.max(other.most);
    }

    /// Number of pictures.
    pub fn count(&self) -> u64 {
        self.bins.values().sum()
    }

    /// What a fraction of the pictures does not exceed, by nearest rank \[ms\]: the upper bound of its bin. NaN without pictures.
    pub fn percentile(&self, fraction: f64) -> f64 {
        let rank = ((fraction * self.count() as f64).ceil() as u64).max(1);
        let mut below = 0;
        for (bin, count) in &self.bins {
            below += count;
            if below >= rank {
                let bound = libm::pow(RATIO, f64::from(*bin)) * 1e-3;
                return bound.min(self.most);
            }
        }
        f64::NAN
    }
}

#[cfg(test)]
mod tests {
    use super::Costs;

    /// Of 1 ms to 1000 ms the p-th permille is p ms, to 2 %; two halves together are the whole.
    #[test]
    fn percentiles_of_the_whole_numbers() {
        let (mut odd, mut even) = (Costs::default(), Costs::default());
        for ms in 1..=1000 {
            let half = if ms % 2 == 0 { &mut even } else { &mut odd };
            half.add(f64::from(ms));
        }
        odd.append(&even);
        assert_eq!((odd.count(), odd.most), (1000, 1000.0));
        for (fraction, expected) in [(0.5, 500.0), (0.99, 990.0), (0.999, 999.0), (1.0, 1000.0)] {
            let ratio = odd.percentile(fraction) / expected;
            assert!((0.999..=1.021).contains(&ratio), "{fraction}: {ratio}");
        }
        assert!(Costs::default().percentile(0.5).is_nan());
    }
}
