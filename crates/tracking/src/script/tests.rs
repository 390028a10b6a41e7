use std::f64::consts::PI;

use super::*;

const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

fn about_z(angle: f64) -> [f64; 4] {
    [0.0, 0.0, libm::sin(angle / 2.0), libm::cos(angle / 2.0)]
}

fn keyframe(time_s: f64, x: f64) -> Keyframe {
    Keyframe {
        time_s,
        position: [x, 0.0, 0.0],
        orientation: IDENTITY,
        opening: 1.0,
        visible: true,
    }
}

fn script(keyframes: Vec<Keyframe>, interpolation: Interpolation) -> Script {
    let track = ScriptTrack {
        device: "forceps".into(),
        keyframes,
    };
    Script::new(vec![track], interpolation).unwrap()
}

fn x_at(script: &Script, t: f64) -> f64 {
    script.sample("forceps", t).unwrap().pose.position[0]
}

/// Flash & Hogan 1985: from rest to rest. Near an end the polynomial is 10τ³ plus higher terms, so after a fraction h of
/// the time the displacement is between 10h³(1 − 1.5h) and 10h³: no term in h (speed) and none in h² (acceleration).
#[test]
fn minimum_jerk_rests_at_both_ends() {
    let script = script(
        vec![keyframe(1.0, 0.0), keyframe(3.0, 1.0)],
        Interpolation::MinimumJerk,
    );
    // Dyadic, so that times are exact and the displacement left at the far end is rounded to one ulp of 1 only.
    for h in [1.0 / 16.0, 1.0 / 64.0, 1.0 / 256.0] {
        let cubic = 10.0 * h * h * h;
        for path in [
            x_at(&script, 1.0 + 2.0 * h),
            1.0 - x_at(&script, 3.0 - 2.0 * h),
        ] {
            let rounding = 4.0 * f64::EPSILON;
            assert!(path <= cubic + rounding, "h {h}: {path}");
            assert!(path >= cubic * (1.0 - 1.5 * h) - rounding, "h {h}: {path}");
        }
    }
}

/// Closed forms: half the displacement at half the time, there with 15/8 of the mean speed; at τ = 1/4 it is 53/512.
#[test]
fn minimum_jerk_closed_forms() {
    let script = script(
        vec![keyframe(0.0, 0.0), keyframe(2.0, 1.0)],
        Interpolation::MinimumJerk,
    );
    assert_eq!(x_at(&script, 1.0), 0.5);
    assert_eq!(x_at(&script, 0.5), 53.0 / 512.0);
    assert_eq!(x_at(&script, 1.5), 459.0 / 512.0);
    let h = 1.0 / 1024.0;
    let speed = (x_at(&script, 1.0 + h) - x_at(&script, 1.0 - h)) / (2.0 * h);
    // Third derivative at the middle: -30 per T³ with T = 2 s; a central difference errs by h²/6 of it.
    let truncation = h * h / 6.0 * 30.0 / 8.0;
    assert!((speed - 15.0 / 16.0).abs() <= 1.01 * truncation, "{speed}");
}

#[test]
fn linear_has_steady_speed() {
    let script = script(
        vec![keyframe(0.0, 1.0), keyframe(4.0, 3.0)],
        Interpolation::Linear,
    );
    for (t, x) in [
        (0.0, 1.0),
        (1.0, 1.5),
        (2.0, 2.0),
        (3.0, 2.5),
        (4.0, 3.0),
        (9.0, 3.0),
    ] {
        assert_eq!(x_at(&script, t), x);
    }
}

/// A pose is held by a second keyframe.
#[test]
fn holds_stay_and_then_leave() {
    let keyframes = vec![keyframe(1.0, 5.0), keyframe(3.0, 5.0), keyframe(4.0, 7.0)];
    let script = script(keyframes, Interpolation::Linear);
    for (t, x) in [(1.0, 5.0), (2.0, 5.0), (3.0, 5.0), (3.5, 6.0), (4.0, 7.0)] {
        assert_eq!(x_at(&script, t), x, "at {t} s");
    }
    assert_eq!(script.duration(), 4.0);
}

/// The orientation turns at the same fraction as the position, the opening changes with time alone.
#[test]
fn orientation_and_opening() {
    let to = Keyframe {
        orientation: about_z(PI / 2.0),
        opening: 0.0,
        ..keyframe(1.0, 1.0)
    };
    let script = script(vec![keyframe(0.0, 0.0), to], Interpolation::MinimumJerk);
    let sample = script.sample("forceps", 0.25).unwrap();
    assert_eq!(sample.opening, Some(0.75));
    let expected = about_z(53.0 / 512.0 * PI / 2.0);
    for (found, expected) in sample.pose.orientation.iter().zip(expected) {
        assert!((found - expected).abs() <= 8.0 * f64::EPSILON);
    }
}

#[test]
fn visibility_lasts_from_keyframe_to_keyframe() {
    let hidden = Keyframe {
        visible: false,
        ..keyframe(2.0, 0.0)
    };
    let script = script(
        vec![keyframe(1.0, 0.0), hidden, keyframe(3.0, 0.0)],
        Interpolation::Linear,
    );
    let seen =
        [0.5, 1.0, 1.9, 2.0, 2.9, 3.0, 9.0].map(|t| script.sample("forceps", t).unwrap().visible);
    assert_eq!(seen, [false, true, true, false, false, true, true]);
    assert_eq!(script.sample("scissors", 1.0), None);
}

#[test]
fn samples_cover_the_script_in_order() {
    let track = |device: &str, end_s| ScriptTrack {
        device: device.into(),
        keyframes: vec![keyframe(0.0, 0.0), keyframe(end_s, 1.0)],
    };
    let script = Script::new(
        vec![track("left", 0.25), track("right", 0.6)],
        Interpolation::Linear,
    )
    .unwrap();
    let samples: Vec<InputSample> = script.samples(4.0).collect();
    let found: Vec<(&str, f64, f64)> = samples
        .iter()
        .map(|sample| (&*sample.device, sample.device_time, sample.pose.position[0]))
        .collect();
    // 0.6 s at 4 Hz: the last at 0.75 s, where both have arrived.
    assert_eq!(found.len(), 8);
    assert_eq!(
        found[..4],
        [
            ("left", 0.0, 0.0),
            ("right", 0.0, 0.0),
            ("left", 0.25, 1.0),
            ("right", 0.25, 0.25 / 0.6)
        ]
    );
    assert_eq!(found[6..], [("left", 0.75, 1.0), ("right", 0.75, 1.0)]);
    let devices: Vec<&str> = script.devices().map(|device| &**device).collect();
    assert_eq!(devices, ["left", "right"]);
}

/// Each rule, with the whole text of its error.
#[test]
fn bad_scripts_are_refused_with_the_keyframe() {
    let good = keyframe(1.0, 0.0);
    let cases: [(Vec<Keyframe>, &str); 8] = [
        (vec![], "device \"forceps\": expected at least one keyframe"),
        (
            vec![keyframe(-1.0, 0.0)],
            "device \"forceps\", keyframe 0 (the first is 0): time is -1 s, expected a finite number from 0 on",
        ),
        (
            vec![good, keyframe(f64::NAN, 0.0)],
            "device \"forceps\", keyframe 1 (the first is 0): time is NaN s, expected a finite number from 0 on",
        ),
        (
            vec![good, good],
            "device \"forceps\", keyframe 1 (the first is 0): time 1 s does not come after 1 s, that of the keyframe \
             before",
        ),
        (
            vec![good, keyframe(2.0, f64::INFINITY)],
            "device \"forceps\", keyframe 1 (the first is 0): position is not finite",
        ),
        (
            vec![Keyframe {
                orientation: [0.0; 4],
                ..good
            }],
            "device \"forceps\", keyframe 0 (the first is 0): quaternion is zero, expected a unit quaternion",
        ),
        (
            vec![Keyframe {
                orientation: [0.0, f64::NAN, 0.0, 1.0],
                ..good
            }],
            "device \"forceps\", keyframe 0 (the first is 0): quaternion is not finite",
        ),
        (
            vec![Keyframe {
                opening: 1.5,
                ..good
            }],
            "device \"forceps\", keyframe 0 (the first is 0): opening is 1.5, expected 0 (closed) to 1 (open)",
        ),
    ];
    for (keyframes, expected) in cases {
        let track = ScriptTrack {
            device: "forceps".into(),
            keyframes,
        };
        let error = Script::new(vec![track], Interpolation::Linear).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }

    let track = ScriptTrack {
        device: "forceps".into(),
        keyframes: vec![good],
    };
    let error = Script::new(vec![track.clone(), track], Interpolation::Linear).unwrap_err();
    assert_eq!(
        error.to_string(),
        "device \"forceps\": it has two tracks, expected one"
    );
}
