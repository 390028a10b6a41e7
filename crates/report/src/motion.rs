//! How the tools moved in the field, and how long they were tracked.

use microsim_message::{ToolSample, ToolStates, ToolStatus};
use microsim_tracking::{RawStatistics, distance};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Motion of one tool: lists of equal length, one entry for each sample in which it was tracked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToolSeries {
    /// Tool slot of the level.
    pub tool: String,
    /// Simulated time since the session began \[s\].
    pub time: Vec<f64>,
    /// Number of the segment, from 0; a gap (as for the raw input) lies between two segments.
    pub segment: Vec<u32>,
    /// Position of the tip in the field \[m\].
    pub position: Vec<[f64; 3]>,
    /// Distance from the sample before over the time from it \[m/s\]; `None` for the first sample of a segment, and
    /// where the device's clock stood still.
    pub speed: Vec<Option<f64>>,
}

/// How long a tool was in each tracking state \[s\], simulated time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolPresence {
    /// Tool slot of the level.
    pub tool: String,
    /// Tool model, for example `forceps`.
    pub model: String,
    /// With a fresh, valid pose.
    pub tracked: f64,
    /// Not seen by the device.
    pub occluded: f64,
    /// With a last sample that is too old.
    pub stale: f64,
    /// Before its first sample.
    pub never_seen: f64,
}

impl ToolPresence {
    /// How long it was not tracked, after its first sample or before \[s\].
    pub fn lost(&self) -> f64 {
        self.occluded + self.stale + self.never_seen
    }
}

/// Gathers the samples of each tool, tools in the order of their first sample.
#[derive(Default)]
pub(crate) struct MotionCollector {
    tools: Vec<ToolSamples>,
}

struct ToolSamples {
    /// Simulated time − device time at the first sample \[s\].
    offset: f64,
    /// Until the threshold of gaps is known, `segment` is 1 where the tool was lost before the sample, and `speed` the distance from the
    /// sample before over the time from it, whatever that time is.
    series: ToolSeries,
    /// Times of the samples by the device's clock \[s\].
    times: Vec<f64>,
    lost: bool,
}

impl MotionCollector {
    pub fn add(&mut self, now: f64, sample: ToolSample) {
        // A sample without a time belongs nowhere.
        if !sample.time.is_finite() {
            return;
        }
        let at = self.tools.iter().position(|t| t.series.tool == sample.tool);
        let at = at.unwrap_or_else(|| {
            self.tools.push(ToolSamples {
                offset: now - sample.time,
                series: ToolSeries {
                    tool: sample.tool.clone(),
                    ..ToolSeries::default()
                },
                times: Vec::new(),
                lost: false,
            });
            self.tools.len() - 1
        });
        self.tools[at].add(&sample);
    }

    pub fn finish(self) -> Vec<ToolSeries> {
        self.tools.into_iter().map(ToolSamples::series).collect()
    }
}

impl ToolSamples {
    fn add(&mut self, sample: &ToolSample) {
        if !sample.tracked || !sample.pose.position.iter().all(|x| x.is_finite()) {
            self.lost = true;
            return;
        }
        let series = &mut self.series;
        let before = self.times.last().zip(series.position.last());
        let lost = std::mem::take(&mut self.lost) && before.is_some();
        let speed = before.and_then(|(time, position)| {
            let [from, to] = [*position, sample.pose.position].map(Vector3::from);
            let interval = sample.time - time;
            // A speed that no number states is none.
            let stated = distance(&to, &from) / interval;
            (interval > 0.0 && stated.is_finite()).then_some(stated)
        });
        series.time.push(sample.time + self.offset);
        series.segment.push(u32::from(lost));
        series.position.push(sample.pose.position);
        series.speed.push(speed);
        self.times.push(sample.time);
    }

    fn series(self) -> ToolSeries {
        // One definition of a gap for the raw input and the tools.
        let times = self.times.iter().map(|time| (*time, Some([0.0; 3])));
        let threshold = RawStatistics::of_path(times, None)
            .gap_threshold_s
            .unwrap_or(f64::INFINITY);
        let mut series = self.series;
        let mut segment = 0;
        for (index, pair) in (1..).zip(self.times.windows(2)) {
            if series.segment[index] > 0 || pair[1] - pair[0] > threshold {
                segment += 1;
                series.speed[index] = None;
            }
            series.segment[index] = segment;
        }
        series
    }
}

/// Adds up tracking states; a state holds until the next message.
#[derive(Default)]
pub(crate) struct PresenceCollector {
    /// Each tool with its ticks by state (tracked, occluded, stale, never seen).
    tools: Vec<(String, String, [u64; 4])>,
    /// Place in `tools` and state of each tool in the last message.
    current: Vec<(usize, ToolStatus)>,
    since: u64,
}

impl PresenceCollector {
    pub fn add(&mut self, tick: u64, states: ToolStates) {
        self.advance(tick);
        self.current.clear();
        for state in states.tools {
            let at = match self.tools.iter().position(|t| t.0 == state.tool) {
                Some(at) => at,
                None => {
                    self.tools.push((state.tool, state.model, [0; 4]));
                    self.tools.len() - 1
                }
            };
            self.current.push((at, state.status));
        }
    }

    fn advance(&mut self, tick: u64) {
        for &(at, status) in &self.current {
            let kind = match status {
                ToolStatus::Tracked => 0,
                ToolStatus::Occluded => 1,
                ToolStatus::Stale => 2,
                ToolStatus::NeverSeen => 3,
            };
            self.tools[at].2[kind] += tick.saturating_sub(self.since);
        }
        self.since = tick;
    }

    /// `end`: one past the last tick; `tick_s` \[s\].
    pub fn finish(mut self, end: u64, tick_s: f64) -> Vec<ToolPresence> {
        self.advance(end);
        self.tools
            .into_iter()
            .map(|(tool, model, ticks)| {
                let [tracked, occluded, stale, never_seen] = ticks.map(|n| n as f64 * tick_s);
                ToolPresence {
                    tool,
                    model,
                    tracked,
                    occluded,
                    stale,
                    never_seen,
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::Report;
    use crate::testing::{input, log};
    use microsim_message::{Pose, ToolSample, ToolState, ToolStates, ToolStatus};

    fn sample(time: f64, x: f64, tracked: bool) -> ToolSample {
        ToolSample {
            tool: "right".into(),
            time,
            tracked,
            pose: Pose {
                position: [x, 0.0, 0.0],
                ..Pose::default()
            },
            opening: 0.0,
        }
    }

    /// By hand, with dyadic numbers so that all is exact. Median interval 1/4, so that 1 is a gap and 1/2 is none; the
    /// sample that was not tracked ends a segment too. The device's clock starts at 100 in tick 4 of 1/8 s.
    #[test]
    fn no_speed_across_a_gap() {
        let points = [
            (100.0, 0.0, true),
            (100.25, 1.0, true),
            (100.5, 3.0, true),
            (101.5, 50.0, true), // 1 s later: a gap
            (101.75, 51.0, true),
            (102.0, 51.0, false), // not seen
            (102.25, 90.0, true),
            (102.75, 91.0, true), // twice the median: jitter
            (103.0, 93.0, true),
        ];
        let samples: Vec<_> = points.map(|(t, x, tracked)| sample(t, x, tracked)).into();
        let log = log(&samples.iter().map(|s| s as _).collect::<Vec<_>>());
        let report = Report::build(&input(), [(4, &log[..])]);
        let [series] = &report.series[..] else {
            panic!("{:?}", report.series)
        };
        assert_eq!(
            series.time,
            [0.5, 0.75, 1.0, 2.0, 2.25, 2.75, 3.25, 3.5],
            "first sample at its tick, distances by the device's clock"
        );
        assert_eq!(series.segment, [0, 0, 0, 1, 1, 2, 2, 2]);
        assert_eq!(
            series.speed,
            [
                None,
                Some(4.0),
                Some(8.0),
                None,
                Some(4.0),
                None,
                Some(2.0),
                Some(8.0)
            ]
        );
    }

    /// A clock that stands still gives no speed, and never an infinite one.
    #[test]
    fn no_speed_without_time() {
        let log = log(&[
            &sample(0.0, 0.0, true),
            &sample(1.0, 1.0, true),
            &sample(1.0, 2.0, true),
        ]);
        let report = Report::build(&input(), [(0, &log[..])]);
        assert_eq!(report.series[0].speed, [None, Some(1.0), None]);
    }

    /// Ticks of 1/8 s: never seen in ticks 0 and 1, tracked in 2 to 5 (no message in between), occluded in 6.
    #[test]
    fn states_hold_until_the_next_message() {
        let states = |status| {
            log(&[&ToolStates {
                tools: vec![ToolState {
                    tool: "right".into(),
                    model: "forceps".into(),
                    status,
                    pose: Pose::default(),
                    opening: 0.0,
                }],
            }])
        };
        let logs = [
            (0, states(ToolStatus::NeverSeen)),
            (2, states(ToolStatus::Tracked)),
            (6, states(ToolStatus::Occluded)),
        ];
        let report = Report::build(&input(), logs.iter().map(|(tick, log)| (*tick, &log[..])));
        let presence = &report.presence[0];
        assert_eq!(presence.model, "forceps");
        let times = [
            presence.never_seen,
            presence.tracked,
            presence.occluded,
            presence.stale,
        ];
        assert_eq!(times, [0.25, 0.5, 0.125, 0.0]);
    }
}
