//! Samples that no hand makes, and those that one does.

use super::*;
use microsim_message::{InputSample, Pose};
use microsim_vocabulary::MotionLimit;
use std::f64::consts::TAU;

/// Those that `config/translator.toml` states.
const HAND: HandLimits = HandLimits {
    speed: 1.0,
    acceleration: 10.0,
    turn_rate: 30.0,
    opening_rate: 17.0,
    position_error: 2.5e-4,
    turn_error: 0.05,
    opening_error: 0.02,
    accept_after_s: 0.1,
};

/// The interval of usual devices `[s]`.
const INTERVAL_S: f64 = 0.016;
const STALE_AFTER_S: f64 = 0.1;

fn translator() -> Translator {
    let mapping = Mapping::identity("stylus", "forceps");
    Translator::new(vec![mapping], STALE_AFTER_S, HAND).unwrap()
}

fn at(time_s: f64, x: f64) -> InputSample {
    InputSample {
        visible: true,
        pose: Pose {
            position: [x, 0.0, 0.0],
            ..Pose::default()
        },
        opening: Some(0.5),
        ..InputSample::not_visible("stylus", time_s)
    }
}

/// Which samples count, fed as they are measured; what the others are beyond.
fn fed(translator: &mut Translator, samples: &[InputSample]) -> Vec<Option<MotionLimit>> {
    let fed = samples
        .iter()
        .map(|sample| match translator.feed(sample, sample.device_time) {
            Ok(_) => None,
            Err(Refusal {
                fault: SampleFault::Implausible(excess),
                ..
            }) => Some(excess.limit),
            Err(other) => panic!("{other}"),
        });
    fed.collect()
}

fn left_out(samples: &[InputSample]) -> usize {
    let fed = fed(&mut translator(), samples);
    fed.iter().flatten().count()
}

fn status(translator: &Translator, now_s: f64) -> ToolStatus {
    translator.status(&translator.tools()[0], now_s).0
}

fn x(translator: &Translator) -> f64 {
    let pose = translator.tools()[0].pose();
    pose.expect("seen").pose.position[0]
}

/// One 20 mm off and one 5 mm off: they alone are left out, the tool stands where it was and remains tracked.
#[test]
fn a_single_sample_elsewhere_is_left_out_alone() {
    for off in [0.5, 0.02, 0.005, -0.02] {
        let mut translator = translator();
        for index in 0..20 {
            let time_s = f64::from(index) * INTERVAL_S;
            let place = 1e-3 * time_s;
            let is_off = index == 10;
            let sample = at(time_s, place + if is_off { off } else { 0.0 });
            let fed = translator.feed(&sample, time_s);
            assert_eq!(fed.is_err(), is_off, "{off}, sample {index}");
            assert_eq!(status(&translator, time_s), ToolStatus::Tracked);
            assert!((x(&translator) - place).abs() < 2e-5, "sample {index}");
        }
        assert_eq!(translator.tools()[0].implausible(), 1);
        assert_eq!(translator.tools()[0].refused(), 0);
    }
}

/// By hand: 20 mm in 16 ms from rest, of which 4 · 0.25 mm may be error, are 19 mm / (16 ms)² = 74.2 m/s².
#[test]
fn what_is_left_out_is_said_with_its_number() {
    let mut translator = translator();
    for index in 0..3 {
        let time_s = f64::from(index) * INTERVAL_S;
        translator.feed(&at(time_s, 0.0), time_s).unwrap();
    }
    let refusal = translator.feed(&at(0.048, 0.02), 0.048).unwrap_err();
    assert_eq!(
        refusal.to_string(),
        "tool \"forceps\": the sample of device \"stylus\" at its time 0.048 s is refused: no hand makes a motion of \
         acceleration 74.219 m/s² (limit 10 m/s²)"
    );
    assert_eq!(refusal.count, 1);
    let lost = translator.lost(&at(0.048, 0.02)).unwrap();
    assert_eq!(
        (lost.tracked, lost.time, lost.pose.position[0]),
        (false, 0.048, 0.0)
    );
}

/// Just within and just beyond each limit, in closed form, at 62.5 Hz.
#[test]
fn each_limit_is_where_it_is_said_to_be() {
    let turned = |time_s: f64, angle: f64| {
        let mut sample = at(time_s, 0.0);
        sample.pose.orientation = [0.0, 0.0, libm::sin(angle / 2.0), libm::cos(angle / 2.0)];
        sample
    };
    let opened = |time_s: f64, opening: f64| InputSample {
        opening: Some(opening),
        ..at(time_s, 0.0)
    };
    let h = INTERVAL_S;
    type Samples<'a> = &'a dyn Fn(f64) -> Vec<InputSample>;
    let cases: [(MotionLimit, f64, Samples<'_>); 4] = [
        // Without a velocity before, only the speed counts.
        (MotionLimit::Speed, h + 5e-4, &|d| {
            vec![at(0.0, 0.0), at(h, d)]
        }),
        (MotionLimit::Acceleration, 10.0 * h * h + 1e-3, &|d| {
            vec![at(0.0, 0.0), at(h, 0.0), at(2.0 * h, d)]
        }),
        (MotionLimit::TurnRate, 30.0 * h + 0.1, &|d| {
            vec![turned(0.0, 0.0), turned(h, -d)]
        }),
        (MotionLimit::OpeningRate, 17.0 * h + 0.04, &|d| {
            vec![opened(0.0, 0.9), opened(h, 0.9 - d)]
        }),
    ];
    for (limit, most, samples) in cases {
        let last = |d| fed(&mut translator(), &samples(d)).pop().flatten();
        assert_eq!(last(most * (1.0 - 1e-9)), None, "{limit:?}");
        assert_eq!(last(most * (1.0 + 1e-9)), Some(limit), "{limit:?}");
    }
}

/// What hands do: fast reaches, tapping at 9.2 Hz, tremor three times the largest of hands, with the jitter of a poor tracker, at every rate.
#[test]
fn motions_of_hands_count_at_every_rate() {
    let mut state = 1_u64;
    let mut noise = |size: f64| {
        // A linear congruential generator (Knuth's MMIX): any numbers will do.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        size * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    for rate in [30.0, 62.5, 120.0, 250.0, 1000.0] {
        let samples: Vec<_> = (0..(4.0 * rate) as u32)
            .map(|index| {
                let t = f64::from(index) / rate;
                // 100 mm there and back at 1 Hz: 0.31 m/s, 2 m/s². 0.6 mm at 9 Hz: 1.9 m/s².
                let reach = 0.05 * libm::sin(TAU * t);
                let tremor = 0.6e-3 * libm::sin(TAU * 9.0 * t);
                let mut sample = at(t, reach + tremor + noise(2.5e-4));
                // Half of the opening, as fast as hands tap; 14 1/s.
                sample.opening = Some(0.5 + 0.25 * libm::sin(TAU * 9.2 * t) + noise(0.02));
                let angle = libm::sin(TAU * 2.0 * t) + noise(0.05);
                sample.pose.orientation =
                    [0.0, libm::sin(angle / 2.0), 0.0, libm::cos(angle / 2.0)];
                sample
            })
            .collect();
        assert_eq!(left_out(&samples), 0, "{rate} Hz");
    }
}

/// Samples that a network delivers together, stamped when they arrive; a clock of 10 ms; a clock that stands still; one that is set back.
#[test]
fn awkward_stamps_of_slow_motion_count() {
    let moved = |time_s: f64, index: u32| at(time_s, 5e-4 * f64::from(index));
    let bursts = (0..60).map(|index| {
        moved(
            f64::from(index / 6) * 0.096 + 1e-4 * f64::from(index % 6),
            index,
        )
    });
    assert_eq!(left_out(&bursts.collect::<Vec<_>>()), 0, "bursts");
    let coarse = (0..60).map(|index| {
        moved(
            f64::from(index) * 0.008 - f64::from(index % 5) * 0.002,
            index,
        )
    });
    assert_eq!(left_out(&coarse.collect::<Vec<_>>()), 0, "coarse");
    let still = (0..60).map(|index| moved(7.0, index));
    assert_eq!(left_out(&still.collect::<Vec<_>>()), 0, "still");
    let back = (0..60).map(|index| moved(f64::from((index + 30) % 60) * INTERVAL_S, index));
    assert_eq!(left_out(&back.collect::<Vec<_>>()), 0, "set back");
}

/// A tracker that sees something else at every sample for 0.8 s, in which a hand could come anywhere: the tool stands, is occluded from the time on
/// that makes it stale, and is tracked again with the first sample where it is.
#[test]
fn a_tracker_that_errs_moves_nothing() {
    let mut translator = translator();
    let feed = |translator: &mut Translator, index: u32, place: f64| {
        let time_s = f64::from(index) * INTERVAL_S;
        let counts = translator.feed(&at(time_s, place), time_s).is_ok();
        (counts, status(translator, time_s))
    };
    for index in 0..10 {
        assert!(feed(&mut translator, index, 0.0).0);
    }
    for index in 10..60 {
        // No two of them lie beside each other.
        let side = if index % 2 == 0 { 1.0 } else { -1.0 };
        let place = side * (0.012 + 0.04 * f64::from((index * 7) % 11) / 11.0);
        let is_old = f64::from(index - 9) * INTERVAL_S > STALE_AFTER_S;
        let expected = match is_old {
            true => ToolStatus::Occluded,
            false => ToolStatus::Tracked,
        };
        let found = feed(&mut translator, index, place);
        assert_eq!(found, (false, expected), "sample {index} at {place} m");
    }
    assert_eq!(x(&translator), 0.0);
    let found = feed(&mut translator, 60, 0.002);
    assert_eq!(found, (true, ToolStatus::Tracked));
    assert_eq!(translator.tools()[0].implausible(), 50);
}

/// A jump of 0.5 m that lasts: left out for 0.1 s, the tool is occluded once at least, and is then at the new place.
#[test]
fn a_jump_that_lasts_counts_after_a_gap() {
    for (rate, off) in [(62.5, 0.5), (62.5, 0.01), (1000.0, 0.5), (125.0, 0.02)] {
        let mut translator = translator();
        let mut before = ToolStatus::Tracked;
        let mut counted_again = None;
        for index in 0..rate as u32 {
            let time_s = f64::from(index) / rate;
            let is_off = time_s >= 0.5;
            let place = 1e-3 * time_s + if is_off { off } else { 0.0 };
            let counts = translator.feed(&at(time_s, place), time_s).is_ok();
            if is_off && counts && counted_again.is_none() {
                counted_again = Some(time_s);
                // Whoever moves the tool from where it was to where it is has seen a gap.
                assert_ne!(before, ToolStatus::Tracked, "{rate} Hz, {off} m");
            }
            assert_eq!(counts, !is_off || counted_again.is_some(), "at {time_s} s");
            before = status(&translator, time_s);
        }
        let counted_again = counted_again.expect("it lasts");
        assert!(
            (0.6..0.6 + 3.0 / rate + 0.02).contains(&counted_again),
            "{rate} Hz: {counted_again}"
        );
        assert!((x(&translator) - off).abs() < 2e-3);
    }
}

/// Several samples of a tick of 0.1 s arrive at its time: the tool is lost at the end of a tick all the same.
#[test]
fn a_jump_is_a_gap_of_a_tick_at_least() {
    let mut translator = translator();
    let mut before = ToolStatus::NeverSeen;
    let mut place = 0.0;
    for tick in 0..20 {
        let now_s = f64::from(tick) * 0.1;
        for index in 0..6 {
            let off = if tick < 8 { 0.0 } else { 0.3 };
            let _ = translator.feed(&at(now_s + f64::from(index) * INTERVAL_S, off), now_s);
        }
        let moved = (x(&translator) - place).abs();
        let now = status(&translator, now_s);
        assert!(
            moved < 1e-3 || before != ToolStatus::Tracked || now != ToolStatus::Tracked,
            "swept {moved} m in tick {tick}"
        );
        (before, place) = (now, x(&translator));
    }
    assert_eq!((before, place), (ToolStatus::Tracked, 0.3));
}

/// Occluded for 50 ms and found again beside where it was: it counts at once. Found 0.3 m away: only when that lasts.
#[test]
fn an_occluded_tool_counts_again_where_a_hand_can_have_brought_it() {
    for (place, counts) in [(0.005, true), (0.3, false)] {
        let mut translator = translator();
        for index in 0..5 {
            let time_s = f64::from(index) * INTERVAL_S;
            translator.feed(&at(time_s, 0.0), time_s).unwrap();
        }
        let hidden = InputSample::not_visible("stylus", 0.08);
        translator.feed(&hidden, 0.08).unwrap();
        assert_eq!(status(&translator, 0.08), ToolStatus::Occluded);
        let found = translator.feed(&at(0.128, place), 0.128);
        assert_eq!(found.is_ok(), counts);
        let expected = if counts {
            ToolStatus::Tracked
        } else {
            ToolStatus::Occluded
        };
        assert_eq!(status(&translator, 0.128), expected);
    }
}

/// Saved anywhere in a stretch of samples elsewhere and restored, it goes on the same.
#[test]
fn a_saved_state_goes_on_in_every_sample() {
    let sample = |index: u32| {
        let off = match index {
            12 => 0.02,
            30.. => 0.4,
            _ => 0.0,
        };
        at(f64::from(index) * INTERVAL_S, off)
    };
    let mut original = translator();
    for index in 0..60 {
        let bytes = serde_json::to_vec(original.state()).unwrap();
        let mut restored = translator();
        restored
            .restore(serde_json::from_slice(&bytes).unwrap())
            .unwrap();
        for next in index..60 {
            let _ = restored.feed(&sample(next), sample(next).device_time);
        }
        let mut went_on = original.clone();
        for next in index..60 {
            let _ = went_on.feed(&sample(next), sample(next).device_time);
        }
        assert_eq!(restored.state(), went_on.state(), "saved before {index}");
        let _ = original.feed(&sample(index), sample(index).device_time);
    }
    assert_eq!(status(&original, 59.0 * INTERVAL_S), ToolStatus::Tracked);
    assert_eq!(x(&original), 0.4);
}

/// No sample makes it panic, and none whose numbers overflow counts as a motion.
#[test]
fn numbers_without_bound_are_no_motion() {
    let huge = [1e308, -1e308, 1e200].map(|x| at(0.1, x));
    let mut translator = translator();
    fed(&mut translator, &[at(0.0, 0.0), at(0.016, 0.0)]);
    assert_eq!(fed(&mut translator, &huge).iter().flatten().count(), 3);
    assert_eq!(x(&translator), 0.0);
}

#[test]
fn limits_that_are_none_are_refused_in_words() {
    let with = |change: fn(&mut HandLimits)| {
        let mut hand = HAND;
        change(&mut hand);
        let mapping = Mapping::identity("stylus", "forceps");
        Translator::new(vec![mapping], 0.1, hand)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        with(|hand| hand.speed = 0.0),
        "speed of a hand is 0, expected a finite positive number"
    );
    assert_eq!(
        with(|hand| hand.turn_error = -1.0),
        "turn_error of a hand is -1, expected a finite positive number"
    );
}
