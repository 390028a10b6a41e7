//! From a segment of samples to evenly spaced positions and speeds.
//!
//! Limitations: positions between samples are interpolated linearly, which damps a vibration of frequency f by
//! sinc²(f/f_source) on average (8 % at 10 Hz from 62.5 samples a second) where the new times fall between the old ones;
//! and a source faster than the new rate is not filtered first, so that its noise above half the new rate folds down.

use crate::motion::distance;
use microsim_message::ToolPose;
use std::ops::Range;

/// Slack in the number of samples that fit a duration, in samples: keeps the last one in spite of rounded times.
const COUNT_SLACK: f64 = 1e-6;

/// Half width of the smoothing window in standard deviations; 0.3 % of the Gaussian lies outside.
const SMOOTHING_REACH: f64 = 3.0;

/// Positions \[m\] at `start`, `start` + 1/`rate`, … up to `end` \[s\], interpolated linearly.
///
/// `segment` is contiguous and covers `start` ..= `end`; an empty one gives nothing.
pub fn resample(segment: &[ToolPose], start: f64, end: f64, rate: f64) -> Vec<[f64; 3]> {
    let Some(last) = segment.last() else {
        return Vec::new();
    };
    let count = ((end - start) * rate + COUNT_SLACK).floor() as usize + 1;
    let mut next = 0;
    (0..count)
        .map(|k| {
            let time = start + k as f64 / rate;
            while next < segment.len() && segment[next].time < time {
                next += 1;
            }
            let Some(after) = segment.get(next) else {
                return last.pose.position;
            };
            let Some(before) = next.checked_sub(1).map(|index| &segment[index]) else {
                return after.pose.position;
            };
            let fraction = (time - before.time) / (after.time - before.time);
            [0, 1, 2].map(|axis| {
                before.pose.position[axis]
                    + fraction * (after.pose.position[axis] - before.pose.position[axis])
            })
        })
        .collect()
}

/// Speed \[m/s\] by forward differences, |p_{k+1} − p_k|·rate: one value per interval, their sum over rate is the path.
pub fn speed(positions: &[[f64; 3]], rate: f64) -> Vec<f64> {
    positions
        .windows(2)
        .map(|pair| distance(pair[0], pair[1]) * rate)
        .collect()
}

/// Positions smoothed with a Gaussian of standard deviation `sigma` \[s\], without delay; 0 leaves them as they are.
///
/// A vibration of frequency f is damped by exp(−2π²σ²f²); a straight even motion is not changed, at the ends neither,
/// where the motion is continued by reflection in the end point (2·p_0 − p_k).
pub fn smooth(positions: &[[f64; 3]], rate: f64, sigma: f64) -> Vec<[f64; 3]> {
    let width = sigma * rate;
    let Some(last) = positions.len().checked_sub(1) else {
        return Vec::new();
    };
    let reach = ((SMOOTHING_REACH * width).ceil() as usize).min(last);
    if reach == 0 {
        return positions.to_vec();
    }
    let mut weights: Vec<f64> = (0..=reach)
        .map(|k| {
            let distance = k as f64 / width;
            libm::exp(-0.5 * distance * distance)
        })
        .collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    weights.iter_mut().for_each(|weight| *weight /= total);

    let before = |index: usize, k: usize, axis: usize| match index.checked_sub(k) {
        Some(earlier) => positions[earlier][axis],
        None => 2.0 * positions[0][axis] - positions[k - index][axis],
    };
    let after = |index: usize, k: usize, axis: usize| match positions.get(index + k) {
        Some(later) => later[axis],
        None => 2.0 * positions[last][axis] - positions[2 * last - index - k][axis],
    };
    (0..=last)
        .map(|index| {
            let mut position = [0.0; 3];
            for (axis, value) in position.iter_mut().enumerate() {
                *value = weights[0] * positions[index][axis];
                for (k, weight) in weights.iter().enumerate().skip(1) {
                    *value += weight * (before(index, k, axis) + after(index, k, axis));
                }
            }
            position
        })
        .collect()
}

/// The movements (ICSAD idea, DOMAIN 2) as ranges of indices: from where the speed rises through `threshold`, after having been below
/// half of it, to where it falls below half of it. A segment that begins above the threshold begins with a movement, and the last one
/// may last to its end.
pub fn movements(speed: &[f64], threshold: f64) -> Vec<Range<usize>> {
    let mut movements: Vec<Range<usize>> = Vec::new();
    let mut begin = None;
    for (index, &value) in speed.iter().enumerate() {
        if begin.is_none() && value >= threshold {
            begin = Some(index);
        } else if value < 0.5 * threshold {
            movements.extend(begin.take().map(|begin| begin..index));
        }
    }
    movements.extend(begin.map(|begin| begin..speed.len()));
    movements
}

/// The [`movements`] that are whole, each with its feet: from the last minimum of the speed before it rises through half of `threshold` to
/// the first one after it has fallen below that, so that the profile has no edge where a threshold cuts it. One that the segment's begin
/// or end cuts off is left out.
pub fn whole_movements(speed: &[f64], threshold: f64) -> Vec<Range<usize>> {
    let low = |value: &f64| *value < 0.5 * threshold;
    let with_feet = |movement: Range<usize>| {
        let mut first = speed[..movement.start].iter().rposition(low)?;
        let mut last = movement.end;
        speed.get(last)?;
        while first > 0 && speed[first - 1] < speed[first] {
            first -= 1;
        }
        while last + 1 < speed.len() && speed[last + 1] < speed[last] {
            last += 1;
        }
        Some(first..last + 1)
    };
    let movements = movements(speed, threshold).into_iter();
    movements.filter_map(with_feet).collect()
}

/// Pearson's correlation of two series of equal length, −1..1; `None` if one of them deviates by no more than `floor`
/// (root mean square, in their unit) from its mean: what does not vary does not correlate.
pub fn correlation(a: &[f64], b: &[f64], floor: f64) -> Option<f64> {
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let mean_a = a.iter().sum::<f64>() / count as f64;
    let mean_b = b.iter().sum::<f64>() / count as f64;
    let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        aa += (x - mean_a) * (x - mean_a);
        ab += (x - mean_a) * (y - mean_b);
        bb += (y - mean_b) * (y - mean_b);
    }
    let smallest = floor * floor * count as f64;
    (count > 0 && aa > smallest && bb > smallest)
        .then(|| (ab / (aa.sqrt() * bb.sqrt())).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::Pose;
    use std::f64::consts::PI;

    #[test]
    fn resampling_a_straight_line_is_exact() {
        // Uneven times on a line: linear interpolation has no error there but rounding.
        let segment: Vec<ToolPose> = [0.0, 0.013, 0.05, 0.081, 0.1]
            .iter()
            .map(|&time| ToolPose {
                pose: Pose {
                    position: [2.0 * time, 1.0, -time],
                    ..Pose::default()
                },
                opening: 1.0,
                time: 7.0 + time,
            })
            .collect();
        let positions = resample(&segment, 7.0, 7.1, 100.0);
        assert_eq!(
            positions.len(),
            11,
            "both ends included in spite of rounding in 7.1 − 7.0"
        );
        for (k, position) in positions.iter().enumerate() {
            let time = k as f64 * 0.01;
            for (found, expected) in position.iter().zip([2.0 * time, 1.0, -time]) {
                // Times near 7 s carry 2⁻⁵¹ s of round-off, at 2 m/s.
                assert!((found - expected).abs() < 1e-14, "{k}: {found} {expected}");
            }
        }
        // Forward differences of an even motion: √5 m/s everywhere.
        for value in speed(&positions, 100.0) {
            assert!((value - 5.0f64.sqrt()).abs() < 1e-11);
        }
    }

    #[test]
    fn smoothing_keeps_a_straight_line_and_damps_as_said() {
        let rate = 60.0;
        let line: Vec<[f64; 3]> = (0..100).map(|k| [k as f64, 3.0, -2.0 * k as f64]).collect();
        for (found, expected) in smooth(&line, rate, 0.05).iter().zip(&line) {
            for axis in 0..3 {
                assert!((found[axis] - expected[axis]).abs() < 1e-12);
            }
        }

        // Closed form exp(−2π²σ²f²) for a Gaussian; the tails cut off at 3σ hold 0.27 % of the weight.
        let (sigma, frequency) = (0.05, 3.0);
        let wave: Vec<[f64; 3]> = (0..=600)
            .map(|k| {
                [
                    libm::cos(2.0 * PI * frequency * (k as f64 - 300.0) / rate),
                    0.0,
                    0.0,
                ]
            })
            .collect();
        let expected = libm::exp(-2.0 * PI * PI * sigma * sigma * frequency * frequency);
        let found = smooth(&wave, rate, sigma)[300][0];
        assert!(
            (found - expected).abs() < 2.0 * 0.0027,
            "{found} {expected}"
        );

        // Shorter than the window, and no window at all.
        assert_eq!(smooth(&line[..1], rate, 0.05), line[..1]);
        assert_eq!(smooth(&line[..2], rate, 0.05), line[..2]);
        assert_eq!(smooth(&line, rate, 0.0), line);
        assert!(smooth(&[], rate, 0.05).is_empty());
    }

    #[test]
    fn movements_of_synthetic_profiles() {
        let count = |speed: &[f64], threshold| movements(speed, threshold).len();
        for bumps in [0, 1, 7] {
            let profile: Vec<f64> = (0..bumps * 100)
                .map(|k| {
                    let s = libm::sin(PI * k as f64 / 100.0);
                    3.0 * s * s
                })
                .collect();
            assert_eq!(
                count(&profile, 1.0),
                bumps,
                "{bumps} bumps of 3, threshold 1"
            );
        }
        assert_eq!(
            count(&[0.0, 1.1, 0.6, 1.1, 0.6, 1.1], 1.0),
            1,
            "dips above half do not end a movement"
        );
        assert_eq!(count(&[0.0, 1.1, 0.4, 1.1], 1.0), 2, "dips below half do");
        assert_eq!(count(&[0.9, 0.99, 0.0], 1.0), 0);
        assert_eq!(count(&[2.0, 2.0, 0.0, 2.0], 1.0), 2, "begins in motion");
    }

    #[test]
    fn whole_movements_have_their_feet_and_are_not_cut() {
        //             0    1    2    3    4    5    6    7    8    9    10   11
        let speed = [0.1, 0.0, 0.2, 0.7, 0.6, 1.2, 0.8, 0.4, 0.1, 0.3, 1.1, 0.4];
        assert_eq!(whole_movements(&speed, 1.0), [1..9, 8..12]);
        let only = |speed: &[f64]| match &whole_movements(speed, 1.0)[..] {
            [one] => Some(one.clone()),
            _ => None,
        };
        assert_eq!(only(&speed[..11]), Some(1..9), "cut by the end");
        assert_eq!(only(&speed[3..]), Some(5..9), "cut by the begin");
        assert!(whole_movements(&[], 1.0).is_empty());
    }

    #[test]
    fn correlation_of_known_series() {
        let a = [1.0, 2.0, 4.0, 3.0];
        let scaled = a.map(|value| 5.0 * value + 1.0);
        let opposed = a.map(|value| 10.0 - value);
        assert!((correlation(&a, &scaled, 0.0).expect("varies") - 1.0).abs() < 4.0 * f64::EPSILON);
        assert!((correlation(&a, &opposed, 0.0).expect("varies") + 1.0).abs() < 4.0 * f64::EPSILON);
        assert_eq!(
            correlation(&[1.0, -1.0, 1.0, -1.0], &[1.0, 1.0, -1.0, -1.0], 0.0),
            Some(0.0)
        );
        assert_eq!(correlation(&a, &[2.0; 4], 0.0), None);
        assert_eq!(correlation(&a, &[2.0, 2.0, 2.0, 2.1], 0.1), None);
        assert_eq!(correlation(&[], &[], 0.0), None);
    }
}
