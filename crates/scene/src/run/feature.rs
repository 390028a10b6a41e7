//! Features of a series: peaks, frequencies.

use microsim_settings::{Expect, Feature};

/// A crossing counts when the curve has been below the middle by this fraction of its range: ripples of higher modes do not.
const HYSTERESIS: f64 = 0.1;

/// A curve has had a peak when it has fallen by this fraction of its range: what an iteration leaves of the forces, and corrects in
/// the next step, is none.
const FALL: f64 = 1e-3;

/// What an expectation is about, from a series; `None` if the series does not hold it.
pub(super) fn find(expect: &Expect, time: &[f64], values: &[f64]) -> Option<f64> {
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let fall = FALL * (largest - smallest);
    let found = match expect.what {
        Feature::AtEnd => *values.last()?,
        Feature::Largest => largest,
        Feature::Spread => largest - smallest,
        Feature::FirstPeak => first_peak(time, values, expect.fall_time, fall)?.1,
        Feature::FirstPeakTime => first_peak(time, values, expect.fall_time, fall)?.0,
        Feature::Frequency => frequency(time, values, smallest, largest)?,
    };
    found.is_finite().then_some(found)
}

/// Time and value of the largest value before the curve has stayed below it for `rest_time` and has fallen by more than `least`;
/// between samples by the parabola through the three around it.
fn first_peak(time: &[f64], values: &[f64], rest_time: f64, least: f64) -> Option<(f64, f64)> {
    let (mut peak, mut lowest) = (0, f64::INFINITY);
    for now in 1..values.len() {
        lowest = lowest.min(values[now]);
        if values[now] > values[peak] {
            (peak, lowest) = (now, f64::INFINITY);
        } else if time[now] - time[peak] >= rest_time && peak > 0 && values[peak] - lowest > least {
            return Some(vertex(time, values, peak));
        }
    }
    None
}

/// Time and value of the vertex of the parabola through three samples at equal distances.
fn vertex(time: &[f64], values: &[f64], middle: usize) -> (f64, f64) {
    let [a, b, c] = [middle - 1, middle, middle + 1].map(|i| values[i]);
    let (slope, curvature) = (0.5 * (c - a), a - 2.0 * b + c);
    if curvature >= 0.0 {
        return (time[middle], b);
    }
    let offset = -slope / curvature;
    let width = time[middle + 1] - time[middle];
    (time[middle] + offset * width, b + 0.5 * slope * offset)
}

/// Upward crossings of the middle per time, from the first to the last; the times between samples by linear interpolation.
fn frequency(time: &[f64], values: &[f64], smallest: f64, largest: f64) -> Option<f64> {
    let middle = 0.5 * (smallest + largest);
    let low = middle - HYSTERESIS * (largest - smallest);
    let (mut armed, mut at) = (false, 0.0);
    let mut crossings: Vec<f64> = Vec::new();
    for (index, value) in values.iter().enumerate() {
        if *value < low {
            armed = true;
        }
        if index > 0 && armed && *value >= middle && values[index - 1] < middle {
            let fraction = (middle - values[index - 1]) / (value - values[index - 1]);
            at = time[index - 1] + fraction * (time[index] - time[index - 1]);
            crossings.push(at);
            armed = false;
        }
    }
    let first = crossings.first()?;
    (crossings.len() > 1).then(|| (crossings.len() - 1) as f64 / (at - first))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expect(what: Feature) -> Expect {
        Expect {
            regression: false,
            probe: String::new(),
            what,
            value: 0.0,
            tolerance: 0.0,
            scale: None,
            fall_time: 0.05,
            source: String::new(),
        }
    }

    /// 1 − cos ωt with a ripple of 2 % at 11 times the frequency, sampled every 1 ms.
    fn swing(omega: f64, ripple: f64) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..=1000).map(|i| f64::from(i) * 1e-3).collect();
        let value = |t: &f64| 1.0 - libm::cos(omega * t) + ripple * libm::sin(11.0 * omega * t);
        let values = time.iter().map(value).collect();
        (time, values)
    }

    #[test]
    fn a_peak_is_found_between_samples_and_behind_ripples() {
        let omega = 21.7;
        let (time, values) = swing(omega, 0.0);
        let get = |what, values: &[f64]| find(&expect(what), &time, values).expect("found");
        // The parabola through three samples of a cosine at distance h errs by (ωh)⁴/32 < 1e-8 of its height at most and by
        // less than h (ωh)²/12 < 1e-7 s in time.
        assert!((get(Feature::FirstPeak, &values) - 2.0).abs() < 1e-8);
        let pi = std::f64::consts::PI;
        assert!((get(Feature::FirstPeakTime, &values) - pi / omega).abs() < 1e-7);
        // Linear interpolation near the middle of a cosine errs by h (ωh)²/8 · ωh at most: 1e-9 s in 1 s.
        let frequency = get(Feature::Frequency, &values);
        assert!((frequency - omega / (2.0 * pi)).abs() < 1e-5, "{frequency}");

        // A ripple has several local peaks; the largest one before 50 ms of fall is within 2 % of the top.
        let (_, rippled) = swing(omega, 0.02);
        let peak = get(Feature::FirstPeak, &rippled);
        assert!((1.98..=2.02).contains(&peak), "{peak}");
        assert!((get(Feature::Frequency, &rippled) - omega / (2.0 * pi)).abs() < 2e-2);
    }

    #[test]
    fn what_a_series_does_not_hold_is_not_found() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        let rising = time.clone();
        for what in [
            Feature::FirstPeak,
            Feature::FirstPeakTime,
            Feature::Frequency,
        ] {
            assert_eq!(find(&expect(what), &time, &rising), None, "{what:?}");
            assert_eq!(find(&expect(what), &[0.0], &[0.0]), None, "{what:?}");
        }
        // What comes to rest with the last digits of an iteration has no peak; what overshoots by 1 % has one.
        for (rest, peak) in [(1.0 - 1e-6, None), (0.99, Some(1.0))] {
            let resting: Vec<f64> = [0.0, 1.0].into_iter().chain([rest; 98]).collect();
            let found = find(&expect(Feature::FirstPeakTime), &time, &resting);
            assert_eq!(found.map(f64::round), peak, "{rest}");
        }
        assert_eq!(find(&expect(Feature::AtEnd), &time, &rising), Some(99.0));
        assert_eq!(find(&expect(Feature::Spread), &time, &rising), Some(99.0));
        assert_eq!(find(&expect(Feature::AtEnd), &[0.0], &[f64::NAN]), None);
    }
}
