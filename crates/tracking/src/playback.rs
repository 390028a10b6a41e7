//! Samples that are known beforehand, given out as time goes by.

use crate::Sample;

/// Plays samples in the order of their times; the first one is due at time 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Playback {
    samples: Vec<Sample>,
    next: usize,
}

impl Playback {
    /// A playback of `samples`, which are in the order of their times.
    pub fn new(samples: Vec<Sample>) -> Self {
        Self { samples, next: 0 }
    }

    /// The samples that have become due by `now_s` `[s]` since the last call.
    pub fn due(&mut self, now_s: f64) -> &[Sample] {
        let first = self.next;
        let start = self.samples.first().map_or(0.0, |s| s.time_s);
        let due = |s: &&Sample| s.time_s - start <= now_s;
        self.next += self.samples[first..].iter().take_while(due).count();
        &self.samples[first..self.next]
    }

    /// Whether all samples have been given out.
    pub fn is_over(&self) -> bool {
        self.next == self.samples.len()
    }

    /// Number of samples given out: all that changes.
    pub fn position(&self) -> usize {
        self.next
    }

    /// Goes to a saved position; one behind the end counts as the end.
    pub fn seek(&mut self, position: usize) {
        self.next = position.min(self.samples.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_comes_once_at_its_time() {
        let at = |t| Sample::not_visible("d".into(), t);
        let mut playback = Playback::new(vec![at(5.0), at(5.1), at(5.2), at(9.0)]);
        let times = |s: &[Sample]| s.iter().map(|s| s.time_s).collect::<Vec<_>>();
        assert_eq!(times(playback.due(0.0)), [5.0]);
        assert_eq!(times(playback.due(0.15)), [5.1]);
        let saved = playback.position();
        assert_eq!(times(playback.due(1.0)), [5.2]);
        assert!(!playback.is_over());
        playback.seek(saved);
        assert_eq!(times(playback.due(4.0)), [5.2, 9.0]);
        assert!(playback.is_over() && playback.due(100.0).is_empty());
    }
}
