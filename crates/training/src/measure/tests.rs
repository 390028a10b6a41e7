use super::*;
use crate::motion::tests::recording;
use microsim_message::Pose;
use proptest::prelude::*;
use std::f64::consts::PI;

const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

fn at(time: f64, position: [f64; 3], orientation: [f64; 4]) -> ToolPose {
    ToolPose {
        pose: Pose {
            position,
            orientation,
        },
        opening: 1.0,
        time,
    }
}

/// A log at `rate` \[Hz\] from `begin` over `seconds`, both ends included.
fn log(begin: f64, seconds: f64, rate: f64, position: impl Fn(f64) -> [f64; 3]) -> MotionLog {
    let mut log = MotionLog::new();
    extend(&mut log, begin, seconds, rate, position);
    log
}

fn extend(
    log: &mut MotionLog,
    begin: f64,
    seconds: f64,
    rate: f64,
    position: impl Fn(f64) -> [f64; 3],
) {
    for k in 0..=(seconds * rate).round() as usize {
        let t = k as f64 / rate;
        log.push(at(begin + t, position(t), UPRIGHT))
            .expect("a valid sample");
    }
}

fn measure(logs: &[(&str, &MotionLog)]) -> Vec<Measurement> {
    motion_metrics(logs, 10.0, Some(1e-3), &MetricParameters::default()).expect("legal parameters")
}

fn of_run(logs: &[(&str, &MotionLog)], metric: &str) -> MetricValue {
    let measurements = measure(logs);
    let of_run = |line: &&Measurement| line.metric == metric && line.tool.is_none();
    measurements
        .iter()
        .find(of_run)
        .expect("in the catalogue")
        .value
        .clone()
}

fn number(logs: &[(&str, &MotionLog)], metric: &str) -> f64 {
    of_run(logs, metric)
        .number()
        .unwrap_or_else(|| panic!("{metric} has a value"))
}

fn reason(logs: &[(&str, &MotionLog)], metric: &str) -> NotApplicable {
    match of_run(logs, metric) {
        MetricValue::NotApplicable(reason) => reason,
        MetricValue::Value(value) => panic!("{metric} = {value}"),
    }
}

/// Movements of 4 mm along x, one a second, each of minimum jerk and 0.5 s long.
fn movements(t: f64) -> [f64; 3] {
    let tau = (2.0 * (t - t.floor())).min(1.0);
    let fraction = tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau);
    [4e-3 * (t.floor() + fraction), 0.0, 0.0]
}

#[test]
fn the_order_is_that_of_the_catalogue_then_tool_by_tool() {
    let (left, right, unseen) = (
        log(0.0, 3.0, 60.0, movements),
        log(0.0, 3.0, 60.0, movements),
        MotionLog::new(),
    );
    let names = |measurements: Vec<Measurement>| {
        measurements
            .into_iter()
            .map(|line| (line.metric, line.tool))
            .collect::<Vec<_>>()
    };
    let catalogue: Vec<_> = MOTION_METRICS
        .iter()
        .map(|metric| (metric.id.to_string(), None))
        .collect();
    assert_eq!(
        names(measure(&[("left", &left), ("none", &unseen)])),
        catalogue
    );
    let both = names(measure(&[("right", &right), ("left", &left)]));
    assert_eq!(both[..catalogue.len()], catalogue);
    let tools: Vec<_> = both[catalogue.len()..]
        .iter()
        .map(|(_, tool)| tool.as_deref().expect("a tool"))
        .collect();
    assert_eq!(tools, [["right"; 8], ["left"; 8]].concat());
}

#[test]
fn sums_inside_segments() {
    // Two stretches of 1 mm each, 1 m apart; joined over the gap it would be 1.002 m.
    let mut one = log(0.0, 1.0, 60.0, |t| [1e-3 * t, 0.0, 0.0]);
    extend(&mut one, 2.0, 1.0, 60.0, |t| [1.0, 1e-3 * t, 0.0]);
    // Round-off of coordinates near 1 m, 60 steps.
    let tolerance = 60.0 * f64::EPSILON;
    assert!((number(&[("a", &one)], id::PATH_LENGTH) - 2e-3).abs() < tolerance);
    assert!((number(&[("a", &one)], id::ECONOMY) - 0.5).abs() < tolerance / 1e-3);
    // The same without a gap in time, but marked.
    let mut marked = log(0.0, 1.0, 60.0, |t| [1e-3 * t, 0.0, 0.0]);
    marked.mark_gap();
    extend(&mut marked, 1.01, 1.0, 60.0, |t| [1.0, 1e-3 * t, 0.0]);
    assert!((number(&[("a", &marked)], id::PATH_LENGTH) - 2e-3).abs() < tolerance);
    // Two tools add up.
    assert!(
        (number(&[("a", &one), ("b", &marked)], id::PATH_LENGTH) - 4e-3).abs() < 2.0 * tolerance
    );
}

#[test]
fn angular_path_of_a_known_rotation() {
    // 90 steps of 2° there and back about an axis that is none of the frame's.
    let mut turning = MotionLog::new();
    for k in 0..=90u32 {
        let half = (f64::from(k.min(90 - k)) * 2.0).to_radians() / 2.0;
        let (sin, cos) = (libm::sin(half), libm::cos(half));
        let orientation = [0.6 * sin, 0.0, 0.8 * sin, cos];
        let sample = at(f64::from(k) / 60.0, [0.0; 3], orientation);
        turning.push(sample).expect("a valid sample");
    }
    let found = number(&[("a", &turning)], id::ANGULAR_PATH);
    assert!((found - PI).abs() < 90.0 * 4e-15, "90 · 2° = π: {found}");
    assert_eq!(
        number(&[("a", &turning)], id::PATH_LENGTH),
        0.0,
        "turned on the spot: measured, and 0"
    );
    assert_eq!(
        reason(&[("a", &turning)], id::ECONOMY),
        NotApplicable::NoMotion
    );
}

#[test]
fn working_volume_is_that_of_the_box() {
    // To opposite corners of 2 × 3 × 4 mm, seen in two segments.
    let mut a = log(0.0, 1.0, 60.0, |t| [2e-3 * t, 0.0, 0.0]);
    extend(&mut a, 5.0, 1.0, 60.0, |t| [1e-3, 3e-3 * t, 4e-3 * t]);
    let one = number(&[("a", &a)], id::WORKING_VOLUME);
    assert!((one / 24e-9 - 1.0).abs() < 1e-14);
    let b = log(0.0, 1.0, 60.0, |t| [1.0 + 1e-3 * t, 1e-3 * t, 1e-3 * t]);
    let two = number(&[("a", &a), ("b", &b)], id::WORKING_VOLUME);
    // Box by box, not the box around both, a metre wide. Coordinates near 1 m are good to 10⁻¹⁶ m of 10⁻³ m.
    assert!((two / 25e-9 - 1.0).abs() < 1e-12);
}

#[test]
fn idle_share_of_a_tool_that_rests_half_the_time() {
    let a = log(0.0, 20.0, 60.0, |t| [1e-3 * t.min(10.0), 0.0, 0.0]);
    // The Gaussian reaches 3 · 0.08 s across the moment of stopping.
    let idle = number(&[("a", &a)], id::IDLE_FRACTION);
    assert!((idle - 0.5).abs() < 0.24 / 20.0 + 1.0 / 1200.0, "{idle}");
}

/// DOMAIN 1: tremor has up to 200 µm, its peak between 6 and 12 Hz. A·2πf·exp(−2π²σ²f²) is largest at the lowest frequency: beyond
/// f = 1/(2πσ) = 2 Hz the exponential wins. Where a segment ends there is less to smooth with: 3 · 0.08 s at either end of 10 s are left out.
#[test]
fn a_hand_that_only_trembles_is_idle_and_a_slow_one_that_trembles_is_not() {
    let parameters = MetricParameters::default();
    let left = |amplitude: f64, f: f64, sigma: f64| {
        let w = 2.0 * PI * f;
        amplitude * w * libm::exp(-0.5 * (w * sigma) * (w * sigma))
    };
    let worst = left(200e-6, 6.0, parameters.idle_smoothing_s);
    assert!(worst < parameters.idle_speed_m_s, "{worst}");
    assert!(left(200e-6, 6.0, 0.05) > parameters.idle_speed_m_s);
    let ends = 2.0 * 0.24 / 10.0;
    for f in [6.0, 8.0, 10.0, 12.0] {
        let tremor = move |t: f64| 200e-6 * libm::sin(2.0 * PI * f * t);
        let still = log(0.0, 10.0, 62.5, |t| [0.0, tremor(t), 0.0]);
        assert!(number(&[("a", &still)], id::IDLE_FRACTION) > 1.0 - ends);
        // Fine work: 0.3 mm/s, across the tremor.
        let working = log(0.0, 10.0, 62.5, |t| [3e-4 * t, tremor(t), 0.0]);
        assert!(number(&[("a", &working)], id::IDLE_FRACTION) < ends);
        let pair = |a, b| number(&[("a", a), ("b", b)], id::BIMANUAL_FRACTION);
        assert!(pair(&working, &still) < ends, "{f} Hz");
        assert!(pair(&working, &working) > 1.0 - ends, "{f} Hz");
    }
}

/// One movement of minimum jerk in one second from 1 s on, at rest before and behind it.
fn one_movement(t: f64) -> [f64; 3] {
    let tau = (t - 1.0).clamp(0.0, 1.0);
    [
        8e-3 * tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau),
        0.0,
        0.0,
    ]
}

/// Over a whole run SPARC measured the rhythm of movement and rest: ten movements were "less smooth" than one of them. Now a
/// movement has the value that its speed has by itself, 30·(τ² − 2τ³ + τ⁴), however often it comes and however long the rests are; only
/// the length of its feet differs, which the smoothing sets.
#[test]
fn smoothness_is_that_of_a_movement_and_not_of_the_rhythm() {
    let profile: Vec<f64> = (0..60)
        .map(|k| (f64::from(k) + 0.5) / 60.0)
        .map(|tau| 30.0 * tau * tau * (1.0 - tau) * (1.0 - tau))
        .collect();
    let expected = sparc(&profile, 60.0).expect("a bell");
    let one = log(0.0, 3.0, 60.0, one_movement);
    let of_one = number(&[("a", &one)], id::SPARC);
    // The spectrum of padded values is that of unpadded ones; the number of bins along the arc differs with the padded length.
    assert!(
        (of_one / expected - 1.0).abs() < 0.01,
        "{of_one} {expected}"
    );
    let cycle = |period: f64| {
        move |t: f64| {
            let [x, ..] = one_movement(t - period * (t / period).floor());
            [x + 8e-3 * (t / period).floor(), 0.0, 0.0]
        }
    };
    for period in [3.0, 5.0] {
        let ten = log(0.0, 10.0 * period, 60.0, cycle(period));
        let of_ten = number(&[("a", &ten)], id::SPARC);
        assert!((of_ten / of_one - 1.0).abs() < 1e-6, "{of_ten} {of_one}");
        let calm = signal::speed(
            &signal::resample(ten.samples(), 0.0, 10.0 * period, 60.0),
            60.0,
        );
        let whole = sparc(&calm, 60.0).expect("motion");
        assert!(whole < 2.0 * of_one, "over the whole run: {whole}");
    }
    // A halting movement is less smooth, and counts as one movement among others, by number and not by length.
    let halting = log(0.0, 4.0, 60.0, |t| {
        let u = (t - 1.0).clamp(0.0, 2.0);
        [
            4e-3 * (u - 0.8 * libm::sin(4.0 * PI * u) / (4.0 * PI)),
            0.0,
            0.0,
        ]
    });
    let of_halting = number(&[("a", &halting)], id::SPARC);
    assert!(of_halting < of_one - 0.5, "{of_halting} {of_one}");
    let both = number(&[("a", &one), ("b", &halting)], id::SPARC);
    assert!((both - 0.5 * (of_one + of_halting)).abs() < 1e-12);
}

/// What begins before the tool is seen, or does not come to rest, has no whole profile.
#[test]
fn a_movement_that_the_segment_cuts_has_no_smoothness() {
    let late = log(0.0, 2.0, 60.0, |t| one_movement(t + 1.5));
    assert_eq!(reason(&[("a", &late)], id::SPARC), NotApplicable::NoMotion);
    let early = log(0.0, 1.5, 60.0, one_movement);
    assert_eq!(reason(&[("a", &early)], id::SPARC), NotApplicable::NoMotion);
    let restless = log(0.0, 70.0, 60.0, |t| {
        [4e-3 * libm::sin(t), 4e-3 * libm::cos(t), 0.0]
    });
    assert_eq!(
        reason(&[("a", &restless)], id::SPARC),
        NotApplicable::NoMotion
    );
}

#[test]
fn movements_are_counted_and_tremor_is_not() {
    let calm = log(0.0, 7.0, 62.5, movements);
    assert_eq!(number(&[("a", &calm)], id::MOVEMENTS), 7.0);
    // 50 µm at 9 Hz, 2.8 mm/s at its fastest and so far above v_th: the filter leaves 1.8 % of it.
    let shaking = log(0.0, 7.0, 62.5, |t| {
        let [x, y, z] = movements(t);
        [x, y + 50e-6 * libm::sin(2.0 * PI * 9.0 * t), z]
    });
    assert_eq!(number(&[("a", &shaking)], id::MOVEMENTS), 7.0);
    // Over two segments they add up.
    let mut twice = log(0.0, 7.0, 62.5, movements);
    extend(&mut twice, 20.0, 3.0, 62.5, movements);
    assert_eq!(number(&[("a", &twice)], id::MOVEMENTS), 10.0);
}

#[test]
fn tremor_of_a_known_vibration() {
    // A/√2 (see the tests of `tremor`); at 240 Hz each fourth sample lies on the new grid: nothing is damped.
    let shake = |t: f64| [2e-3 * t, 80e-6 * libm::sin(2.0 * PI * 10.0 * t), 0.0];
    let exact = 80e-6 / 2.0f64.sqrt();
    let found = number(&[("a", &log(0.0, 8.0, 240.0, shake))], id::TREMOR);
    assert!((found / exact - 1.0).abs() < 1e-3, "{found}");
    // At 62.5 Hz the linear interpolation damps by sinc²(10/62.5) = 0.918 on average, within the extremes 1 (on a
    // sample) and cos(10π/62.5) = 0.876 (between two).
    let found = number(&[("a", &log(0.0, 8.0, 62.5, shake))], id::TREMOR);
    let x = PI * 10.0 / 62.5;
    let damping = (libm::sin(x) / x) * (libm::sin(x) / x);
    assert!((found / exact - damping).abs() < 0.01, "{}", found / exact);
}

#[test]
fn means_over_segments_are_weighted_by_duration() {
    let long = |t: f64| [1e-2 * libm::sin(t), 1e-3 * libm::sin(7.0 * t), 0.0];
    let short = |t: f64| [0.0, 5e-3 * libm::sin(3.0 * t), 2e-3 * libm::sin(11.0 * t)];
    // Powers of two, so that both begin on the same times in either log.
    let (a, b) = (log(0.0, 6.0, 64.0, long), log(16.0, 2.0, 64.0, short));
    let mut both = a.clone();
    extend(&mut both, 16.0, 2.0, 64.0, short);
    for metric in [id::LDLJ, id::TREMOR, id::IDLE_FRACTION] {
        let expected =
            (6.0 * number(&[("a", &a)], metric) + 2.0 * number(&[("a", &b)], metric)) / 8.0;
        let found = number(&[("a", &both)], metric);
        assert!(
            (found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(),
            "{metric}: {found} {expected}"
        );
        // As two tools they are combined alike.
        let found = number(&[("a", &a), ("b", &b)], metric);
        assert!(
            (found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(),
            "{metric}: {found} {expected}"
        );
    }
    // A stretch too short for a spectrum does not change the mean of the others.
    extend(&mut both, 32.0, 0.5, 64.0, short);
    let expected =
        (6.0 * number(&[("a", &a)], id::LDLJ) + 2.0 * number(&[("a", &b)], id::LDLJ)) / 8.0;
    assert!(
        (number(&[("a", &both)], id::LDLJ) - expected).abs() <= 4.0 * f64::EPSILON * expected.abs()
    );
}

#[test]
fn what_cannot_be_formed_is_not_applicable() {
    let spectral = [id::SPARC, id::LDLJ, id::TREMOR];
    let nothing = MotionLog::new();
    for metric in TOOL_METRICS {
        assert_eq!(
            reason(&[("a", &nothing)], metric),
            NotApplicable::NoSamples,
            "{metric}"
        );
        let single = log(0.0, 0.0, 60.0, movements);
        assert_eq!(
            reason(&[("a", &single)], metric),
            NotApplicable::SegmentTooShort,
            "{metric}"
        );
    }
    for metric in spectral {
        let short = log(0.0, 0.9, 60.0, movements);
        assert_eq!(
            reason(&[("a", &short)], metric),
            NotApplicable::SegmentTooShort,
            "{metric}"
        );
        let mut slow = log(0.0, 5.0, 59.0, movements);
        assert_eq!(
            reason(&[("a", &slow)], metric),
            NotApplicable::SampleRateTooLow,
            "{metric}"
        );
        extend(&mut slow, 6.0, 0.5, 120.0, movements);
        assert_eq!(
            reason(&[("a", &slow)], metric),
            NotApplicable::SampleRateTooLow,
            "{metric}: came further"
        );
    }
    let slow = log(0.0, 5.0, 59.0, movements);
    assert_eq!(
        number(&[("a", &slow)], id::MOVEMENTS),
        5.0,
        "what needs no spectrum is formed all the same"
    );

    // 60 samples a second in microseconds, as devices write them: 100 intervals in 1.666667 s are 59.99999 Hz.
    let mut nominal = MotionLog::new();
    for k in 0..=100 {
        let time = (f64::from(k) / 60.0 * 1e6).round() / 1e6;
        nominal
            .push(at(time, movements(time), UPRIGHT))
            .expect("a valid sample");
    }
    number(&[("a", &nominal)], id::TREMOR);

    let still = log(0.0, 5.0, 60.0, |_| [0.1, 0.2, 0.3]);
    assert_eq!(reason(&[("a", &still)], id::SPARC), NotApplicable::NoMotion);
    assert_eq!(reason(&[("a", &still)], id::LDLJ), NotApplicable::NoMotion);

    let parameters = MetricParameters::default();
    let lines = motion_metrics(&[("a", &still)], 0.0, None, &parameters).expect("legal parameters");
    assert_eq!(
        lines[0].value,
        MetricValue::NotApplicable(NotApplicable::NotMeasured),
        "no time has passed"
    );
    assert_eq!(
        lines[2].value,
        MetricValue::NotApplicable(NotApplicable::NoShortestPath)
    );
    let absurd = log(0.0, 1.0, 60.0, |t| [1e200 * t, 0.0, 0.0]);
    assert_eq!(
        reason(&[("a", &absurd)], id::PATH_LENGTH),
        NotApplicable::Overflow
    );
    assert!(
        motion_metrics(
            &[],
            1.0,
            None,
            &MetricParameters {
                gap_s: -1.0,
                ..parameters
            }
        )
        .is_err()
    );
}

#[test]
fn two_hands() {
    let both_metrics = [
        id::BIMANUAL_FRACTION,
        id::SPEED_CORRELATION,
        id::PATH_ASYMMETRY,
    ];
    let wave = |sign: f64| move |t: f64| [0.0, 2e-3 * t + sign * 1e-3 * libm::sin(t), 0.0];
    let a = log(0.0, 8.0, 60.0, wave(1.0));
    for metric in both_metrics {
        assert_eq!(reason(&[("a", &a)], metric), NotApplicable::NotTwoHands);
        assert_eq!(
            reason(&[("a", &a), ("b", &MotionLog::new())], metric),
            NotApplicable::NotTwoHands
        );
        assert_eq!(
            reason(&[("a", &a), ("b", &a), ("c", &a)], metric),
            NotApplicable::NotTwoHands
        );
        assert_eq!(reason(&[], metric), NotApplicable::NoSamples);
    }

    // Speeds 2 ± cos t mm/s along a line: one follows the other, or opposes it. The filter is linear, and the same for
    // both: what is left is round-off of 10⁻¹⁷ m · 60 Hz against 10⁻³ m/s, squared sums of 480 values.
    let opposed = log(0.0, 8.0, 60.0, wave(-1.0));
    assert!((number(&[("a", &a), ("b", &a)], id::SPEED_CORRELATION) - 1.0).abs() < 1e-12);
    assert!((number(&[("a", &a), ("b", &opposed)], id::SPEED_CORRELATION) + 1.0).abs() < 1e-9);
    assert_eq!(number(&[("a", &a), ("b", &a)], id::BIMANUAL_FRACTION), 1.0);
    assert_eq!(number(&[("a", &a), ("b", &a)], id::PATH_ASYMMETRY), 0.0);
    let even = log(0.0, 8.0, 60.0, |t| [1e-3 * t, 0.0, 0.0]);
    assert_eq!(
        reason(&[("a", &a), ("b", &even)], id::SPEED_CORRELATION),
        NotApplicable::NoMotion
    );

    // Seen from 2 s on, moving from 5 s on, 3 m against 1 m of path; other rate, other begin.
    let fast = log(0.0, 8.0, 62.5, |t| [3e-3 * t, 0.0, 0.0]);
    let late = log(2.0, 6.0, 60.0, |t| [8e-3 * (t - 3.0).max(0.0), 0.0, 0.0]);
    let fraction = number(&[("a", &fast), ("b", &late)], id::BIMANUAL_FRACTION);
    assert!(
        (fraction - 0.5).abs() < (0.24 + 1.0 / 60.0) / 6.0,
        "of the common 6 s, by the reach of the filter: {fraction}"
    );
    let third = log(0.0, 8.0, 60.0, |t| [1e-3 * t, 0.0, 0.0]);
    let asymmetry = number(&[("a", &fast), ("b", &third)], id::PATH_ASYMMETRY);
    assert!(
        (asymmetry - 0.5).abs() < 1e-12,
        "(24 − 8)/(24 + 8): {asymmetry}"
    );

    let afterwards = log(20.0, 5.0, 60.0, wave(1.0));
    for metric in [id::BIMANUAL_FRACTION, id::SPEED_CORRELATION] {
        assert_eq!(
            reason(&[("a", &a), ("b", &afterwards)], metric),
            NotApplicable::NotTogether
        );
    }
    number(&[("a", &a), ("b", &afterwards)], id::PATH_ASYMMETRY);
}

proptest! {
    /// Where the field frame lies must not matter to any metric of one tool but the box.
    #[test]
    fn the_frame_does_not_matter(
        amplitudes in prop::collection::vec(prop::array::uniform3(-5e-3..5e-3f64), 4),
        shift in prop::array::uniform3(-0.05..0.05f64), angle in 0.0..6.3f64,
    ) {
        let position = |t: f64| {
            let mut point = [0.0; 3];
            for (k, amplitude) in amplitudes.iter().enumerate() {
                for axis in 0..3 {
                    point[axis] += amplitude[axis] * libm::sin((k as f64 + 1.0) * 2.3 * t + axis as f64);
                }
            }
            point
        };
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let turned = |t: f64| {
            let [x, y, z] = position(t);
            [cos * x - sin * z + shift[0], y + shift[1], sin * x + cos * z + shift[2]]
        };
        let (a, b) = (log(0.0, 4.0, 62.5, position), log(0.0, 4.0, 62.5, turned));
        // Positions carry round-off of 10⁻¹⁷ m. Relative to a path of millimetres that is 10⁻¹³ over 250 steps; the
        // second differences of LDLJ see it (60 Hz)³ times as large, 10⁻¹² m/s³ … against jerks of 10⁻² m/s³.
        for (metric, tolerance) in [(id::PATH_LENGTH, 1e-11), (id::LDLJ, 1e-8), (id::TREMOR, 1e-9)] {
            let (a, b) = (number(&[("a", &a)], metric), number(&[("a", &b)], metric));
            prop_assert!((a - b).abs() <= tolerance * a.abs(), "{}: {} {}", metric, a, b);
        }
    }
}

/// The shipped recording, against a second implementation of DOMAIN 2 in another language, with direct sums in place of
/// the fast transform and relative quaternions in place of chords. Both round differently: 10⁻¹¹ is left to that.
#[test]
fn recording_of_a_real_hand() {
    let log = recording();
    let expected = [
        (id::PATH_LENGTH, 1.109962618375232),
        (id::ANGULAR_PATH, 9.60602693723165),
        (id::WORKING_VOLUME, 7.45134626592543e-4),
        (id::IDLE_FRACTION, 0.00573340186669828),
        (id::MOVEMENTS, 19.0),
        (id::SPARC, -2.697615281439572),
        (id::LDLJ, -17.435833414117912),
        (id::TREMOR, 2.28062884248577e-05),
    ];
    for (metric, expected) in expected {
        let found = number(&[("stylus", &log)], metric);
        assert!(
            (found / expected - 1.0).abs() < 1e-11,
            "{metric}: {found} {expected}"
        );
    }
}
