//! Levers, filters and clutches of the translator.

use super::*;
use crate::{Mapping, OneEuro};

const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// A quarter turn about z.
const QUARTER_Z: [f64; 4] = [
    0.0,
    0.0,
    std::f64::consts::FRAC_1_SQRT_2,
    std::f64::consts::FRAC_1_SQRT_2,
];
const STALE_AFTER_S: f64 = 0.1;
/// Limits that nothing here reaches.
const ANY: HandLimits = HandLimits {
    speed: 1e9,
    acceleration: 1e12,
    turn_rate: 1e9,
    opening_rate: 1e9,
    position_error: 0.0,
    turn_error: 0.0,
    opening_error: 0.0,
    accept_after_s: 0.1,
};
const SMOOTH: OneEuro = OneEuro {
    min_cutoff: 2.0,
    beta: 0.0,
    turn_beta: 0.0,
    derivative_cutoff: 1.0,
    predict_s: 0.0,
};

fn sample(device: &str, time: f64, x: f64) -> InputSample {
    InputSample {
        visible: true,
        pose: Pose {
            position: [x, 0.0, 0.0],
            orientation: IDENTITY,
        },
        ..InputSample::not_visible(device, time)
    }
}

fn translator(scale: f64) -> Translator {
    let mapping = Mapping {
        scale,
        ..Mapping::identity("hand", "right")
    };
    Translator::new(vec![mapping], STALE_AFTER_S, ANY).expect("a translator")
}

/// Where the tip is after a sample.
fn x(translator: &mut Translator, sample: &InputSample) -> f64 {
    let fed = translator
        .feed(sample, sample.device_time)
        .expect("a sample that counts");
    fed.expect("a tool").pose.position[0]
}

fn with_pedal(scale: f64) -> Translator {
    let clutch = Clutch {
        device: "pedal".into(),
        tools: vec!["right".into()],
    };
    translator(scale)
        .with_motion(Vec::new(), vec![clutch])
        .expect("a clutch")
}

/// By hand: the tip is 100 mm along the handle's x, which a quarter turn about z takes to y; scaled by one half.
#[test]
fn the_lever_goes_from_the_tracked_point_to_the_tip() {
    let mapping = Mapping {
        tip: [0.1, 0.0, 0.0],
        scale: 0.5,
        ..Mapping::identity("hand", "right")
    };
    let mut translator = Translator::new(vec![mapping], STALE_AFTER_S, ANY).expect("a translator");
    let mut turned = sample("hand", 0.0, 0.02);
    turned.pose.orientation = QUARTER_Z;
    let tool = translator
        .feed(&turned, 0.0)
        .expect("counts")
        .expect("a tool");
    let rounding = 4.0 * f64::EPSILON;
    for (found, expected) in tool.pose.position.iter().zip([0.01, 0.05, 0.0]) {
        assert!((found - expected).abs() < rounding, "{tool:?}");
    }
}

/// A hand that only turns about the tip moves the tracked point, and not the tip: no limit of a hand is reached by the lever.
#[test]
fn limits_of_a_hand_are_those_of_the_tip() {
    let mapping = Mapping {
        tip: [0.0, 0.0, -0.13],
        ..Mapping::identity("hand", "right")
    };
    let hand = HandLimits { speed: 0.01, ..ANY };
    let mut translator = Translator::new(vec![mapping], STALE_AFTER_S, hand).expect("a translator");
    for step in 0..50 {
        let angle = 0.02 * f64::from(step);
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let mut turning = sample("hand", 0.01 * f64::from(step), 0.13 * sine);
        turning.pose.position[2] = 0.13 * cosine;
        turning.pose.orientation = [0.0, libm::sin(angle / 2.0), 0.0, libm::cos(angle / 2.0)];
        let tool = translator
            .feed(&turning, turning.device_time)
            .expect("counts")
            .expect("a tool");
        assert!(
            tool.pose.position.iter().all(|x| x.abs() < 1e-15),
            "{tool:?}"
        );
    }
}

/// By hand: pressed at 10 mm, the hand goes to 50 mm and back to 0, released; from there the tip goes on from 10 mm. Scaled by one half throughout.
#[test]
fn a_clutch_holds_the_tip_and_leaves_the_offset() {
    let mut tool = with_pedal(0.5);
    assert_eq!(x(&mut tool, &sample("hand", 0.00, 0.02)), 0.01);
    assert_eq!(tool.feed(&sample("pedal", 0.01, 0.0), 0.01), Ok(None));
    assert_eq!(x(&mut tool, &sample("hand", 0.02, 0.05)), 0.01);
    assert_eq!(x(&mut tool, &sample("hand", 0.03, 0.0)), 0.01);
    assert_eq!(
        tool.feed(&InputSample::not_visible("pedal", 0.04), 0.04),
        Ok(None)
    );
    // Where the hand is at the release the tip stands; a motion of 20 mm is one of 10 mm from there.
    assert_eq!(x(&mut tool, &sample("hand", 0.05, 0.0)), 0.01);
    assert!((x(&mut tool, &sample("hand", 0.06, 0.02)) - 0.02).abs() < f64::EPSILON);
    // Pressed once more: the offsets add up.
    assert_eq!(tool.feed(&sample("pedal", 0.07, 0.0), 0.07), Ok(None));
    assert!((x(&mut tool, &sample("hand", 0.08, -0.02)) - 0.02).abs() < f64::EPSILON);
    assert_eq!(
        tool.feed(&InputSample::not_visible("pedal", 0.09), 0.09),
        Ok(None)
    );
    x(&mut tool, &sample("hand", 0.10, -0.02));
    assert!((x(&mut tool, &sample("hand", 0.11, 0.0)) - 0.03).abs() < f64::EPSILON);
}

/// While the tip stands, orientation and opening follow; a pedal with an opening is pressed from one half on.
#[test]
fn a_clutch_holds_nothing_but_the_tip() {
    let mut tool = with_pedal(1.0);
    x(&mut tool, &sample("hand", 0.0, 0.01));
    let pedal = |time, opening| InputSample {
        opening: Some(opening),
        ..sample("pedal", time, 0.0)
    };
    tool.feed(&pedal(0.01, 0.4), 0.01).expect("a pedal");
    assert_eq!(x(&mut tool, &sample("hand", 0.02, 0.02)), 0.02);
    tool.feed(&pedal(0.03, 0.5), 0.03).expect("a pedal");
    let mut turned = sample("hand", 0.04, 0.07);
    (turned.pose.orientation, turned.opening) = (QUARTER_Z, Some(0.25));
    let found = tool.feed(&turned, 0.04).expect("counts").expect("a tool");
    assert_eq!((found.pose.position[0], found.opening), (0.02, 0.25));
    assert!(
        (found.pose.orientation[2] - QUARTER_Z[2]).abs() < 1e-15,
        "{found:?}"
    );
}

/// A tool that no clutch has held has the pose of its hand to the bit, and one without filters has no state of any.
#[test]
fn without_filters_and_clutches_nothing_is_changed() {
    let mut plain = translator(0.2);
    let mut held = with_pedal(0.2);
    for step in 0..100 {
        let time = 0.01 * f64::from(step);
        let sample = sample("hand", time, 0.1 * libm::sin(7.0 * time));
        assert_eq!(plain.feed(&sample, time), held.feed(&sample, time));
    }
    assert_eq!(plain.motion_state(), None);
    assert_eq!(plain.state(), held.state());
}

/// The filter acts on the tip in the device's frame: scaled it is the filtered position by the scale. A sample that no hand makes does not reach it, and what
/// was lost starts again.
#[test]
fn a_filter_smooths_what_counts_and_joins_no_gap() {
    let filtered = |hand| {
        let mapping = Mapping {
            scale: 0.5,
            ..Mapping::identity("hand", "right")
        };
        let translator = Translator::new(vec![mapping], STALE_AFTER_S, hand).expect("a translator");
        translator
            .with_motion(vec![("hand".into(), SMOOTH)], Vec::new())
            .expect("a filter")
    };
    let mut memory = None;
    let mut tool = filtered(HandLimits { speed: 1.0, ..ANY });
    for (time, place) in [(0.0, 0.0), (0.01, 0.004), (0.02, 0.003)] {
        let expected = SMOOTH
            .step(&mut memory, time, [place, 0.0, 0.0], IDENTITY, 1.0)
            .0[0];
        assert_eq!(x(&mut tool, &sample("hand", time, place)), 0.5 * expected);
    }
    // 100 mm in 10 ms: left out, and the next one goes on from before.
    assert!(tool.feed(&sample("hand", 0.03, 0.1), 0.03).is_err());
    let expected = SMOOTH
        .step(&mut memory, 0.04, [0.005, 0.0, 0.0], IDENTITY, 1.0)
        .0[0];
    assert_eq!(x(&mut tool, &sample("hand", 0.04, 0.005)), 0.5 * expected);
    // Lost, then elsewhere within the reach of a hand: there at once.
    tool.feed(&InputSample::not_visible("hand", 0.05), 0.05)
        .expect("lost");
    assert_eq!(x(&mut tool, &sample("hand", 0.06, 0.02)), 0.01);
    // After a longer pause too.
    assert_eq!(x(&mut tool, &sample("hand", 0.20, 0.04)), 0.02);
}

/// What filters and clutches remember goes on from a saved state, which another translator refuses.
#[test]
fn motion_goes_on_from_a_saved_state() {
    let make = || {
        let clutch = Clutch {
            device: "pedal".into(),
            tools: vec!["right".into()],
        };
        let made = translator(1.0).with_motion(vec![("hand".into(), SMOOTH)], vec![clutch]);
        made.expect("a translator")
    };
    let mut first = make();
    x(&mut first, &sample("hand", 0.0, 0.01));
    first
        .feed(&sample("pedal", 0.01, 0.0), 0.01)
        .expect("a pedal");
    x(&mut first, &sample("hand", 0.02, 0.05));
    let mut second = make();
    second
        .restore(first.state().clone())
        .expect("the same tools");
    assert!(second.restore_motion(first.motion_state().expect("some").clone()));
    for (device, time, place) in [
        ("hand", 0.03, 0.06),
        ("pedal", 0.04, 0.0),
        ("hand", 0.05, 0.02),
    ] {
        let sample = match device {
            "pedal" => InputSample::not_visible(device, time),
            _ => sample(device, time, place),
        };
        assert_eq!(first.feed(&sample, time), second.feed(&sample, time));
    }
    assert!(!with_pedal(1.0).restore_motion(MotionState::default()));
    first.reset();
    assert_eq!(first.motion_state(), make().motion_state());
}

#[test]
fn names_that_fit_nothing_are_refused() {
    let clutch = |device: &str, tool: &str| Clutch {
        device: device.into(),
        tools: vec![tool.into()],
    };
    let with = |filters, clutches| translator(1.0).with_motion(filters, clutches).map(|_| ());
    assert_eq!(
        with(vec![("other".into(), SMOOTH)], vec![]),
        Err(TranslatorError::Unknown("other".into()))
    );
    let wrong = OneEuro {
        min_cutoff: 0.0,
        ..SMOOTH
    };
    assert_eq!(
        with(vec![("hand".into(), wrong)], vec![]),
        Err(TranslatorError::Filter("hand".into(), "min_cutoff", 0.0))
    );
    assert_eq!(
        with(vec![], vec![clutch("hand", "right")]),
        Err(TranslatorError::ClutchDevice("hand".into()))
    );
    assert_eq!(
        with(vec![], vec![clutch("pedal", "left")]),
        Err(TranslatorError::Unknown("left".into()))
    );
    let twice = vec![clutch("pedal", "right"), clutch("pedal", "right")];
    assert_eq!(
        with(vec![], twice),
        Err(TranslatorError::ClutchDevice("pedal".into()))
    );
}
