//! How well a run follows the wall clock, and how long a motion is on its journey to the picture.

use microsim_message::{InputSample, InputTiming};
use std::collections::{BTreeMap, VecDeque};

/// Times that are remembered: those of eight seconds of ticks of 8 ms.
const MOST: usize = 1000;

/// The last of many times \[s\], the newest last.
#[derive(Clone, Debug, Default)]
pub struct Times(VecDeque<f64>);

impl Times {
    /// Another one.
    pub fn push(&mut self, time: f64) {
        if self.0.len() == MOST {
            self.0.pop_front();
        }
        self.0.push_back(time);
    }

    /// The smallest of them that a part `q` of them is not above.
    pub fn quantile(&self, q: f64) -> Option<f64> {
        let mut sorted: Vec<f64> = self.0.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let rank = (q * sorted.len() as f64).ceil() as usize;
        sorted.get(rank.saturating_sub(1).min(last)).copied()
    }
}

/// How well a run follows the wall clock.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    /// From the arrival of a sample of a tracker, or of a motion of mouse and keyboard, to the begin of its tick.
    pub waits: Times,
    /// From the begin of a tick to its snapshot.
    pub ticks: Times,
    /// Ticks that began late, by more than the tolerance of the station.
    pub late: u64,
    /// Ticks that began late by more than a tick.
    pub overdue: u64,
    /// Those of them that a tick that took longer than its length left behind: the others were not begun in time.
    pub overdue_by_work: u64,
    /// Ticks whose solver did not come to its tolerance, and those whose forces mean nothing.
    pub unconverged: u64,
    pub held: u64,
    /// Whether a tick took longer than its length, and the time has not been made up.
    lags: bool,
    /// Samples of a tracker; `None` without one.
    pub samples: Option<Samples>,
    /// The newest sample of each device, by its own clock \[s\].
    newest: BTreeMap<String, f64>,
}

/// What became of samples of a live tracker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Samples {
    /// They found no place in a queue.
    pub dropped: u64,
    /// They are older than one of the same device before them.
    pub late: u64,
}

impl Pace {
    /// Takes a tick of this length that began so much later than its time, and how long it took \[s\]. Whether it was overdue.
    pub fn add_tick(&mut self, length: f64, lateness: f64, duration: f64) -> bool {
        self.lags &= lateness > 0.0;
        let is_overdue = lateness > length;
        if is_overdue {
            self.overdue += 1;
            self.overdue_by_work += u64::from(self.lags);
        }
        self.lags |= duration > length;
        self.ticks.push(duration);
        is_overdue
    }

    /// Takes what a live source states of a tick.
    pub fn add(&mut self, timing: &InputTiming) {
        self.samples.get_or_insert_default().dropped += timing.dropped;
        timing.waits.iter().for_each(|wait| self.waits.push(*wait));
    }

    /// Takes a sample.
    pub fn add_sample(&mut self, sample: &InputSample) {
        // Where a connection ended the time is that of this machine.
        if !sample.visible {
            return;
        }
        let newest = self.newest.entry(sample.device.clone());
        let newest = newest.or_insert(f64::NEG_INFINITY);
        match sample.device_time < *newest {
            true => self.samples.get_or_insert_default().late += 1,
            false => *newest = sample.device_time,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::Pose;

    /// The ranks of the report: of a hundred times the fiftieth and the ninety-ninth; older ones than the last thousand are forgotten.
    #[test]
    fn quantiles_are_those_of_the_last_times() {
        let mut times = Times::default();
        assert_eq!(times.quantile(0.5), None);
        (1..=100).rev().for_each(|k| times.push(f64::from(k)));
        assert_eq!(
            (times.quantile(0.5), times.quantile(0.99)),
            (Some(50.0), Some(99.0))
        );
        (0..MOST).for_each(|_| times.push(7.0));
        assert_eq!(times.quantile(0.99), Some(7.0));
    }

    /// Ticks of 8 ms: one takes 30 ms, so that the next ones begin 22, 15 and 8 ms late; then one begins 9 ms late for no fault of a tick.
    #[test]
    fn an_overdue_tick_has_a_cause() {
        let mut pace = Pace::default();
        let ms = [
            (0.0, 30.0),
            (22.0, 1.0),
            (15.0, 1.0),
            (8.0, 1.0),
            (0.0, 1.0),
        ];
        for (lateness, duration) in ms.into_iter().chain([(9.0, 1.0), (2.0, 1.0)]) {
            pace.add_tick(8e-3, 1e-3 * lateness, 1e-3 * duration);
        }
        assert_eq!((pace.overdue, pace.overdue_by_work), (3, 2));
        assert_eq!(pace.ticks.quantile(1.0), Some(30e-3));
    }

    #[test]
    fn samples_of_a_tracker_are_dropped_or_late() {
        let mut pace = Pace::default();
        let sample = |device: &str, device_time, visible| InputSample {
            device: device.into(),
            device_time,
            visible,
            pose: Pose::default(),
            opening: None,
        };
        pace.add_sample(&sample("a", 2.0, true));
        pace.add_sample(&sample("b", 1.0, true));
        assert_eq!(pace.samples, None);
        pace.add(&InputTiming {
            waits: vec![0.003, 0.001],
            dropped: 2,
        });
        pace.add_sample(&sample("a", 1.5, true));
        pace.add_sample(&sample("a", 0.0, false));
        assert_eq!(
            pace.samples,
            Some(Samples {
                dropped: 2,
                late: 1
            })
        );
        assert_eq!(pace.waits.quantile(1.0), Some(0.003));
    }
}
