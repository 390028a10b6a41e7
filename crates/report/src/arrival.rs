//! How samples of live trackers came: how long they waited for their tick, how long its computation took, what was dropped or late.

use microsim_message::{InputSample, InputTiming};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Of times \[s\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeSpread {
    /// Half of them are not above it.
    pub p50: f64,
    /// Of a hundred 99 are not above it.
    pub p99: f64,
    /// The longest.
    pub longest: f64,
}

/// Samples between a live tracker and the snapshot of a tick. What comes behind, to the picture and the eye, is not in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArrivalRecord {
    /// Samples that reached a tick.
    pub samples: u64,
    /// Samples that were dropped as more came than a queue holds.
    pub dropped: u64,
    /// Poses that are older, by their device's clock, than one of the same device before them.
    pub late: u64,
    /// From the arrival of a sample to the tick that it counts in.
    pub wait: Option<TimeSpread>,
    /// From the begin of a tick to its snapshot.
    pub tick: Option<TimeSpread>,
}

impl TimeSpread {
    /// Of these times; `None` of none. A quantile is the smallest time that as many are not above.
    pub fn of(mut times: Vec<f32>) -> Option<Self> {
        times.sort_by(f32::total_cmp);
        let last = times.len().checked_sub(1)?;
        let at = |fraction: f64| {
            let rank = (fraction * times.len() as f64).ceil() as usize;
            f64::from(times[rank.saturating_sub(1).min(last)])
        };
        Some(Self {
            p50: at(0.5),
            p99: at(0.99),
            longest: at(1.0),
        })
    }
}

/// Gathers them.
#[derive(Default)]
pub(crate) struct ArrivalCollector {
    waits: Vec<f32>,
    dropped: u64,
    late: u64,
    samples: u64,
    is_live: bool,
    newest: BTreeMap<String, f64>,
}

impl ArrivalCollector {
    pub fn add(&mut self, timing: &InputTiming) {
        self.is_live = true;
        self.dropped += timing.dropped;
        self.waits
            .extend(timing.waits.iter().map(|wait| *wait as f32));
    }

    pub fn add_sample(&mut self, sample: &InputSample) {
        self.samples += 1;
        // Where a connection ended the time is that of this machine.
        if !sample.visible {
            return;
        }
        match self.newest.get_mut(&sample.device) {
            Some(newest) if sample.device_time < *newest => self.late += 1,
            Some(newest) => *newest = sample.device_time,
            None => {
                self.newest
                    .insert(sample.device.clone(), sample.device_time);
            }
        }
    }

    /// `None` where no tracker was live.
    pub fn finish(self, tick: Option<TimeSpread>) -> Option<ArrivalRecord> {
        self.is_live.then(|| ArrivalRecord {
            samples: self.samples,
            dropped: self.dropped,
            late: self.late,
            wait: TimeSpread::of(self.waits),
            tick,
        })
    }
}

impl ArrivalRecord {
    /// In a line.
    pub fn words(&self) -> String {
        let stage = |name: &str, spread: Option<TimeSpread>| {
            let spread = spread?;
            let [p50, p99] = [spread.p50, spread.p99].map(|time| 1e3 * time);
            Some(format!("{name} {p50:.1} ms (p50), {p99:.1} ms (p99)"))
        };
        let stages = [
            stage("to the tick", self.wait),
            stage("to its snapshot", self.tick),
        ];
        let stages: Vec<String> = stages.into_iter().flatten().collect();
        format!(
            "delay of {} samples: {}; {} dropped, {} late",
            self.samples,
            stages.join(", "),
            self.dropped,
            self.late
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Report;
    use crate::testing::{input, log};

    /// By hand: of 200 times 1, 2 … 200 ms the hundredth is the median and the 198th the 99th percentile.
    #[test]
    fn quantiles_are_those_of_the_ranks() {
        let times: Vec<f32> = (1..=200).rev().map(|n: u16| f32::from(n)).collect();
        let spread = TimeSpread::of(times).expect("times");
        assert_eq!(
            (spread.p50, spread.p99, spread.longest),
            (100.0, 198.0, 200.0)
        );
        assert_eq!(TimeSpread::of(Vec::new()), None);
        let one = TimeSpread::of(vec![0.5]).expect("one");
        assert_eq!((one.p50, one.p99), (0.5, 0.5));
    }

    #[test]
    fn what_is_dropped_or_late_is_counted() {
        let sample = |time| InputSample {
            visible: true,
            ..InputSample::not_visible("left", time)
        };
        let timing = |waits: &[f64], dropped| InputTiming {
            waits: waits.to_vec(),
            dropped,
        };
        let logs = [
            log(&[&sample(1.0), &sample(2.0), &timing(&[0.25, 0.5], 0)]),
            log(&[&sample(1.5), &sample(2.5), &timing(&[0.125, 0.5], 7)]),
        ];
        let ticks = logs
            .iter()
            .enumerate()
            .map(|(tick, log)| (tick as u64, &log[..]));
        let arrivals = Report::build(&input(), ticks)
            .arrivals
            .expect("a live tracker");
        assert_eq!(
            (arrivals.samples, arrivals.dropped, arrivals.late),
            (4, 7, 1)
        );
        let wait = arrivals.wait.expect("waits");
        assert_eq!((wait.p50, wait.longest, arrivals.tick), (0.25, 0.5, None));
        // Of a recording nothing is said: its samples wait for nobody.
        let recorded = log(&[&sample(1.0)]);
        assert_eq!(Report::build(&input(), [(0, &recorded[..])]).arrivals, None);
    }
}
