//! What came in, device by device, raw: so that a reader can assess the input before the trainee.

use microsim_message::InputSample;
use microsim_tracking::RawStatistics;
use serde::{Deserialize, Serialize};

/// Raw figures of one device, in its own frame and by its own clock. A *segment* is a run of visible samples without a
/// gap; a *gap* is an interval longer than `gap_threshold_s`, or one in which the device did not see the instrument.
/// Nothing is joined across a gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeviceRecord {
    /// Name of the device.
    pub device: String,
    /// Samples in which the instrument was visible.
    pub samples: usize,
    /// Samples in which it was not.
    pub occluded_samples: usize,
    /// Number of segments.
    pub segments: usize,
    /// Number of gaps.
    pub gaps: usize,
    /// Length of the path inside the segments, before any translation \[mm\].
    pub path_mm: f64,
    /// Samples per second inside the segments; `None` if no segment has two samples.
    pub rate_hz: Option<f64>,
    /// From the first to the last visible sample, gaps included \[s\].
    pub duration_s: f64,
    /// Inside the segments \[s\].
    pub tracked_s: f64,
    /// The longest gap \[s\]; 0 if there is none.
    pub longest_gap_s: f64,
    /// Intervals longer than this are gaps \[s\]: three median intervals; `None` with fewer than two visible samples.
    pub gap_threshold_s: Option<f64>,
}

/// Time \[s\] and position \[m\] of a sample, `None` where the device did not see the instrument: no more than is measured, as a long session has many.
type Sample = (f64, Option<[f64; 3]>);

/// Gathers the samples of each device, devices in the order of their first sample.
#[derive(Default)]
pub(crate) struct DeviceCollector {
    devices: Vec<(String, Vec<Sample>)>,
}

impl DeviceCollector {
    pub fn add(&mut self, sample: InputSample) {
        let at = self.devices.iter().position(|d| d.0 == sample.device);
        let at = at.unwrap_or_else(|| {
            self.devices.push((sample.device, Vec::new()));
            self.devices.len() - 1
        });
        let position = sample.visible.then_some(sample.pose.position);
        self.devices[at].1.push((sample.device_time, position));
    }

    pub fn finish(self) -> Vec<DeviceRecord> {
        self.devices
            .into_iter()
            .map(|(device, samples)| {
                let raw = RawStatistics::of_path(samples.iter().copied(), None);
                DeviceRecord {
                    device,
                    samples: raw.samples,
                    occluded_samples: samples.len() - raw.samples,
                    segments: raw.segments,
                    gaps: raw.gaps,
                    path_mm: raw.path_m * 1e3,
                    rate_hz: raw.rate_hz,
                    duration_s: raw.duration_s,
                    tracked_s: raw.tracked_s,
                    longest_gap_s: raw.longest_gap_s,
                    gap_threshold_s: raw.gap_threshold_s,
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::Report;
    use crate::testing::{input, log};
    use microsim_message::{InputSample, Pose};

    /// The real recording, fed as the input messages of a session. Expected: DOMAIN section 4 (12 segments have 11 gaps
    /// between them). The path is the sum of some 3450 distances between positions given to 1e-6 mm: the stated figure has
    /// three decimals, so that half a unit of the last one is the tolerance.
    #[test]
    fn the_recording_has_its_known_figures() {
        let path = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../assets/recordings/cataract-stylus/stylus.csv"
        );
        let mut reader = csv::Reader::from_path(path).expect("the recording is shipped");
        let ticks: Vec<(u64, Vec<u8>)> = reader
            .deserialize::<[f64; 8]>()
            .enumerate()
            .map(|(tick, row)| {
                let [t, x, y, z, qx, qy, qz, qw] = row.expect("eight numbers");
                let sample = InputSample {
                    device: "stylus".into(),
                    device_time: t,
                    visible: true,
                    pose: Pose {
                        position: [x / 1e3, y / 1e3, z / 1e3],
                        orientation: [qx, qy, qz, qw],
                    },
                    opening: None,
                };
                (tick as u64, log(&[&sample]))
            })
            .collect();
        let report = Report::build(&input(), ticks.iter().map(|(tick, log)| (*tick, &log[..])));
        let [device] = &report.input[..] else {
            panic!("{:?}", report.input)
        };
        assert_eq!(
            (device.samples, device.segments, device.gaps),
            (3466, 12, 11)
        );
        assert!((device.path_mm - 1109.963).abs() <= 5e-4, "{device:?}");
        assert_eq!(device.occluded_samples, 0);
    }

    /// Counted by hand; devices keep apart and stand in the order in which their first samples arrived.
    #[test]
    fn devices_are_kept_apart() {
        let sample = |device: &str, device_time, visible| InputSample {
            device: device.into(),
            device_time,
            visible,
            pose: Pose::default(),
            opening: None,
        };
        let log = log(&[
            &sample("right", 0.0, true),
            &sample("left", 0.0, true),
            &sample("right", 0.5, false),
            &sample("right", 1.0, true),
        ]);
        let report = Report::build(&input(), [(0, &log[..])]);
        let counts: Vec<_> = report
            .input
            .iter()
            .map(|d| (&d.device[..], d.samples, d.occluded_samples, d.gaps))
            .collect();
        assert_eq!(counts, [("right", 2, 1, 1), ("left", 1, 0, 0)]);
    }
}
