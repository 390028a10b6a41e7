//! What a recording holds, measured on the raw samples of one device in its own frame, before any translation.
//!
//! These numbers describe the input, so that a reader of a report can assess it; the trainee's metrics are elsewhere.

use microsim_message::InputSample;
use nalgebra::Vector3;

/// Without a stated threshold an interval of more than this many median intervals is a gap. The median is not moved by
/// the gaps themselves, and at three intervals a single lost sample still counts as jitter.
pub const DEFAULT_GAP_INTERVALS: f64 = 3.0;

/// Raw figures of one device. A *segment* is a run of visible samples without a gap. A *gap* lies between two
/// neighbouring visible samples if the interval between them exceeds the threshold, or if the device reported in
/// between that it was not visible. Nothing is joined across a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawStatistics {
    /// Number of visible samples.
    pub samples: usize,
    /// Number of segments; a lone sample between two gaps is one.
    pub segments: usize,
    /// Number of gaps.
    pub gaps: usize,
    /// Length of the path inside the segments, Σ|p_{k+1} − p_k|, in the device frame `[m]`.
    pub path_m: f64,
    /// From the first to the last visible sample, gaps included `[s]`.
    pub duration_s: f64,
    /// Inside the segments `[s]`.
    pub tracked_s: f64,
    /// Intervals per second inside the segments `[1/s]`; `None` if no segment has two samples.
    pub rate_hz: Option<f64>,
    /// The longest gap `[s]`; 0 if there is none.
    pub longest_gap_s: f64,
    /// The threshold used `[s]`; `None` if none was given and there are fewer than two visible samples to derive it from.
    pub gap_threshold_s: Option<f64>,
}

impl RawStatistics {
    /// Measures the samples of one device, in the order of their times. An interval longer than `gap_s` \[s\] is a gap;
    /// without it the threshold is [`DEFAULT_GAP_INTERVALS`] times the median interval.
    pub fn of<'a>(samples: impl IntoIterator<Item = &'a InputSample>, gap_s: Option<f64>) -> Self {
        let path = samples.into_iter().map(|sample| {
            let position = sample.visible.then_some(sample.pose.position);
            (sample.device_time, position)
        });
        Self::of_path(path, gap_s)
    }

    /// Measures a path of times \[s\] and positions \[m\], `None` where the position is not known; else as [`Self::of`].
    pub fn of_path(
        path: impl IntoIterator<Item = (f64, Option<[f64; 3]>)>,
        gap_s: Option<f64>,
    ) -> Self {
        // Visible samples, each with the interval since the one before and whether the device was lost in between.
        let mut steps: Vec<Step> = Vec::new();
        let mut count = 0;
        let mut first_time = 0.0;
        let mut duration = 0.0;
        let mut before: Option<(f64, Vector3<f64>)> = None;
        let mut lost = false;
        for (time, position) in path {
            // A number that is none says nothing of the others.
            if !time.is_finite() {
                lost = true;
                continue;
            }
            let position = position.map(Vector3::from);
            let Some(position) = position.filter(|x| x.iter().all(|x| x.is_finite())) else {
                lost = true;
                continue;
            };
            match before {
                None => first_time = time,
                Some((time_before, position_before)) => steps.push(Step {
                    interval_s: time - time_before,
                    length_m: distance(&position, &position_before),
                    lost,
                }),
            }
            duration = time - first_time;
            count += 1;
            lost = false;
            before = Some((time, position));
        }

        let gap_threshold_s =
            gap_s.or_else(|| median_interval(&steps).map(|median| DEFAULT_GAP_INTERVALS * median));
        let mut statistics = Self {
            samples: count,
            segments: usize::from(count > 0),
            gaps: 0,
            path_m: 0.0,
            duration_s: duration,
            tracked_s: 0.0,
            rate_hz: None,
            longest_gap_s: 0.0,
            gap_threshold_s,
        };
        for step in &steps {
            if step.lost || gap_threshold_s.is_some_and(|threshold| step.interval_s > threshold) {
                statistics.gaps += 1;
                statistics.segments += 1;
                statistics.longest_gap_s = statistics.longest_gap_s.max(step.interval_s);
            } else {
                statistics.path_m += step.length_m;
                statistics.tracked_s += step.interval_s;
            }
        }
        if statistics.tracked_s > 0.0 {
            let intervals = steps.len() - statistics.gaps;
            statistics.rate_hz = Some(intervals as f64 / statistics.tracked_s);
        }
        statistics
    }
}

/// Distance of two points; finite where it can be stated, although the square of a large one cannot.
pub fn distance(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let difference = a - b;
    let plain = difference.norm();
    if plain.is_finite() {
        return plain;
    }
    let size = difference.amax();
    size * (difference / size).norm()
}

/// From one visible sample to the next.
struct Step {
    interval_s: f64,
    length_m: f64,
    lost: bool,
}

/// Median interval between neighbouring visible samples `[s]`; of an even number the mean of the middle two.
fn median_interval(steps: &[Step]) -> Option<f64> {
    let mut intervals: Vec<f64> = steps.iter().map(|step| step.interval_s).collect();
    intervals.sort_by(f64::total_cmp);
    let middle = intervals.len() / 2;
    let upper = *intervals.get(middle)?;
    let lower = if intervals.len().is_multiple_of(2) {
        intervals[middle - 1]
    } else {
        upper
    };
    Some((lower + upper) / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::Pose;

    /// Samples at whole metres on the x axis; `None` is one at which the device was not visible.
    fn samples(points: &[(f64, Option<f64>)]) -> Vec<InputSample> {
        points
            .iter()
            .map(|&(time_s, x)| {
                let sample = InputSample::not_visible("stylus", time_s);
                match x {
                    Some(x) => InputSample {
                        visible: true,
                        pose: Pose {
                            position: [x, 0.0, 0.0],
                            ..sample.pose
                        },
                        ..sample
                    },
                    None => sample,
                }
            })
            .collect()
    }

    /// By hand, with dyadic numbers so that all sums are exact: intervals 1/4, 1/4, 1 (the gap), 1/4, 1/2 (no gap).
    #[test]
    fn gap_by_interval() {
        let samples = samples(&[
            (0.0, Some(0.0)),
            (0.25, Some(1.0)),
            (0.5, Some(3.0)),
            (1.5, Some(10.0)),
            (1.75, Some(9.0)),
            (2.25, Some(9.0)),
        ]);
        let expected = RawStatistics {
            samples: 6,
            segments: 2,
            gaps: 1,
            path_m: 4.0,
            duration_s: 2.25,
            tracked_s: 1.25,
            rate_hz: Some(4.0 / 1.25),
            longest_gap_s: 1.0,
            gap_threshold_s: Some(0.75),
        };
        assert_eq!(RawStatistics::of(&samples, None), expected);
    }

    /// Two intervals, 1/4 and 1: the median is 5/8, three times that more than either.
    #[test]
    fn median_of_an_even_number() {
        let samples = samples(&[(0.0, Some(0.0)), (0.25, Some(1.0)), (1.25, Some(2.0))]);
        let statistics = RawStatistics::of(&samples, None);
        assert_eq!(statistics.gap_threshold_s, Some(1.875));
        assert_eq!(statistics.gaps, 0);
    }

    /// The threshold itself is not yet a gap; a stated threshold replaces the derived one.
    #[test]
    fn stated_threshold() {
        let samples = samples(&[(0.0, Some(0.0)), (0.25, Some(1.0)), (1.25, Some(2.0))]);
        assert_eq!(RawStatistics::of(&samples, Some(1.0)).gaps, 0);
        assert_eq!(RawStatistics::of(&samples, Some(0.5)).gaps, 1);
        assert_eq!(RawStatistics::of(&samples, Some(0.125)).segments, 3);
    }

    /// A device that reports itself as not visible ends the segment, however short the interval; at either end of the
    /// recording there is nothing to join, so that is no gap.
    #[test]
    fn gap_by_visibility() {
        let samples = samples(&[
            (0.0, None),
            (0.25, Some(0.0)),
            (0.5, Some(1.0)),
            (0.75, None),
            (1.0, Some(5.0)),
            (1.25, Some(6.0)),
            (1.5, Some(7.0)),
            (1.75, None),
        ]);
        let statistics = RawStatistics::of(&samples, None);
        assert_eq!(
            (statistics.samples, statistics.segments, statistics.gaps),
            (5, 2, 1)
        );
        assert_eq!(statistics.path_m, 3.0);
        assert_eq!(statistics.duration_s, 1.25);
        assert_eq!(statistics.longest_gap_s, 0.5);
    }

    /// One sample without numbers is one that was not seen; a distance whose square overflows is a distance.
    #[test]
    fn a_sample_that_is_not_finite_spoils_no_figure() {
        let samples = samples(&[
            (0.0, Some(0.0)),
            (0.25, Some(1.0)),
            (0.5, Some(f64::NAN)),
            (0.75, Some(1.0)),
            (1.0, Some(2.0)),
            (f64::NAN, Some(3.0)),
        ]);
        let statistics = RawStatistics::of(&samples, None);
        assert_eq!((statistics.samples, statistics.gaps), (4, 1));
        assert_eq!((statistics.path_m, statistics.tracked_s), (2.0, 0.5));
        assert_eq!(statistics.rate_hz, Some(4.0));
        let far = Vector3::new(1e300, 1e300, 0.0);
        let length = distance(&far, &Vector3::zeros());
        assert!((length / 1e300 - 2f64.sqrt()).abs() < 1e-12, "{length}");
    }

    #[test]
    fn too_few_samples_have_no_rate() {
        let none = RawStatistics::of(&samples(&[(1.0, None)]), None);
        assert_eq!((none.samples, none.segments, none.rate_hz), (0, 0, None));
        let one = RawStatistics::of(&samples(&[(1.0, Some(2.0))]), None);
        assert_eq!((one.samples, one.segments, one.duration_s), (1, 1, 0.0));
        assert_eq!((one.rate_hz, one.gap_threshold_s), (None, None));
    }
}
