use std::f64::consts::FRAC_1_SQRT_2;

use crate::ToolStatus;
use microsim_message::Pose;

use super::*;

mod properties;

const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// A quarter turn about x: y goes to z.
const QUARTER_X: [f64; 4] = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
/// A quarter turn about z: x goes to y.
const QUARTER_Z: [f64; 4] = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];

/// Limits that nothing here is beyond.
const ANY: HandLimits = HandLimits {
    speed: 1e6,
    acceleration: 1e6,
    turn_rate: 1e6,
    opening_rate: 1e6,
    position_error: 1e6,
    turn_error: 1e6,
    opening_error: 1e6,
    accept_after_s: 0.1,
};

fn sample(time_s: f64, position: [f64; 3], orientation: [f64; 4]) -> InputSample {
    InputSample {
        visible: true,
        pose: Pose {
            position,
            orientation,
        },
        ..InputSample::not_visible("stylus", time_s)
    }
}

fn hidden(time_s: f64) -> InputSample {
    InputSample::not_visible("stylus", time_s)
}

fn translator(mapping: Mapping) -> Translator {
    Translator::new(vec![mapping], 0.5, ANY).unwrap()
}

fn translated(mapping: &Mapping, sample: &InputSample) -> ToolSample {
    translator(mapping.clone())
        .feed(sample, 0.0)
        .unwrap()
        .unwrap()
}

fn pose_of(mapping: &Mapping, sample: &InputSample) -> Pose {
    translated(mapping, sample).pose
}

fn close<const N: usize>(found: [f64; N], expected: [f64; N], tolerance: f64) -> bool {
    (0..N).all(|i| (found[i] - expected[i]).abs() <= tolerance)
}

/// The rotation matrix of a quaternion in its textbook form, as a reference independent of the translator's code.
fn turned(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let [x, y, z, w] = q;
    let rows = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    rows.map(|row| dot(row, v))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// By hand: (p − origin) = (1, 2, 3) mm; about z by a quarter turn (−2, 1, 3); halved (−1, 0.5, 1.5); plus the offset.
#[test]
fn position_by_hand() {
    let mapping = Mapping {
        device_origin: [0.010, 0.020, 0.030],
        field_offset: [0.100, 0.200, 0.300],
        field_from_device: QUARTER_Z,
        scale: 0.5,
        ..Mapping::identity("stylus", "forceps")
    };
    let tool = translated(&mapping, &sample(7.0, [0.011, 0.022, 0.033], IDENTITY));
    let expected = [0.099, 0.2005, 0.3015];
    assert!(
        close(tool.pose.position, expected, 4.0 * f64::EPSILON),
        "{tool:?}"
    );
    assert_eq!((tool.time, tool.tracked), (7.0, true));
}

/// By hand: the tool's x axis lies along the handle's y; the device turns that to z about its x; the field turns about z
/// and leaves it. The scale has no part in it.
#[test]
fn orientation_by_hand() {
    let mapping = Mapping {
        field_from_device: QUARTER_Z,
        body_from_tool: QUARTER_Z,
        scale: 0.125,
        ..Mapping::identity("stylus", "forceps")
    };
    let pose = pose_of(&mapping, &sample(0.0, [0.0; 3], QUARTER_X));
    let axis = |axis| turned(pose.orientation, axis);
    let rounding = 16.0 * f64::EPSILON;
    assert!(close(axis([1.0, 0.0, 0.0]), [0.0, 0.0, 1.0], rounding));
    // y of the tool: −x of the handle, −x of the device, −y of the field.
    assert!(close(axis([0.0, 1.0, 0.0]), [0.0, -1.0, 0.0], rounding));
}

#[test]
fn identity_mapping_changes_nothing() {
    let position = [0.1, -0.2, 0.3];
    let sample = InputSample {
        opening: Some(0.25),
        ..sample(1.0, position, QUARTER_X)
    };
    let tool = translated(&Mapping::identity("stylus", "forceps"), &sample);
    assert_eq!(tool.tool, "forceps");
    assert_eq!((tool.pose.position, tool.opening), (position, 0.25));
    assert!(close(tool.pose.orientation, QUARTER_X, 2.0 * f64::EPSILON));
}

#[test]
fn openings() {
    let opening = |opening, readings: &[Option<f64>]| -> Vec<f64> {
        let mut translator = translator(Mapping {
            opening,
            ..Mapping::identity("stylus", "forceps")
        });
        readings
            .iter()
            .map(|&opening| {
                let sample = InputSample {
                    opening,
                    ..sample(0.0, [0.0; 3], IDENTITY)
                };
                translator.feed(&sample, 0.0).unwrap().unwrap().opening
            })
            .collect()
    };
    assert_eq!(
        opening(Opening::Constant(0.5), &[None, Some(0.75)]),
        [0.5, 0.5]
    );
    // Without a reading: open at first, then as it was.
    assert_eq!(
        opening(Opening::DEVICE, &[None, Some(0.25), None]),
        [1.0, 0.25, 0.25]
    );
    // A handle that reads 0.75 closed and 0.25 open, linear between, and no further beyond.
    let handle = Opening::Device {
        closed: 0.75,
        open: 0.25,
    };
    assert_eq!(
        opening(
            handle,
            &[Some(0.75), Some(0.625), Some(0.25), Some(0.0), Some(1.0)]
        ),
        [0.0, 0.25, 1.0, 1.0, 0.0]
    );
}

/// One tool through all statuses. The device's clock is 100 s ahead of the session's, which plays no part.
#[test]
fn statuses_over_a_timeline() {
    use crate::ToolStatus::{NeverSeen, Occluded, Stale, Tracked};
    let mut translator = translator(Mapping::identity("stylus", "forceps"));
    let seen = |now_s: f64, x| Some(sample(now_s + 100.0, [x, 0.0, 0.0], IDENTITY));
    let lost = |now_s: f64| Some(hidden(now_s + 100.0));
    let broken = |now_s: f64| Some(sample(now_s + 100.0, [f64::NAN, 0.0, 0.0], IDENTITY));

    // Session time, the sample that arrives then, and what is reported afterwards: status, since when, x, refused.
    let timeline = [
        (0.0, None, (NeverSeen, 0.0, None, 0)),
        (1.0, lost(1.0), (NeverSeen, 0.0, None, 0)),
        (1.25, broken(1.25), (NeverSeen, 0.0, None, 1)),
        (9.0, None, (NeverSeen, 0.0, None, 1)),
        (10.0, seen(10.0, 1.0), (Tracked, 10.0, Some(1.0), 1)),
        (10.25, seen(10.25, 2.0), (Tracked, 10.0, Some(2.0), 1)),
        // Not longer than 0.5 s without a sample.
        (10.75, None, (Tracked, 10.0, Some(2.0), 1)),
        (10.75, lost(10.75), (Occluded, 10.75, Some(2.0), 1)),
        (11.0, broken(11.0), (Occluded, 10.75, Some(2.0), 2)),
        (11.25, seen(11.25, 3.0), (Tracked, 11.25, Some(3.0), 2)),
        (12.0, None, (Stale, 11.75, Some(3.0), 2)),
        (20.0, None, (Stale, 11.75, Some(3.0), 2)),
        (21.0, seen(21.0, 4.0), (Tracked, 21.0, Some(4.0), 2)),
        (21.25, broken(21.25), (Occluded, 21.25, Some(4.0), 3)),
        (22.0, None, (Stale, 21.75, Some(4.0), 3)),
        (23.0, lost(23.0), (Occluded, 23.0, Some(4.0), 3)),
    ];
    for (now_s, sample, expected) in timeline {
        if let Some(sample) = sample {
            // The refusals are looked at in a test of their own.
            let _ = translator.feed(&sample, now_s);
        }
        let [tool] = translator.tools() else {
            panic!("{:?}", translator.tools());
        };
        let (status, since_s) = translator.status(tool, now_s);
        let x = tool.pose().map(|at| at.pose.position[0]);
        assert_eq!(
            (status, since_s, x, tool.refused()),
            expected,
            "at {now_s} s"
        );
    }
}

#[test]
fn refusals_say_what_and_where() {
    let good = sample(2.5, [0.0; 3], IDENTITY);
    let cases = [
        (
            InputSample {
                device_time: f64::NAN,
                ..good.clone()
            },
            "at its time NaN s is refused: time is not finite",
        ),
        (
            InputSample {
                pose: Pose {
                    position: [0.0, f64::INFINITY, 0.0],
                    ..good.pose
                },
                ..good.clone()
            },
            "at its time 2.5 s is refused: position is not finite",
        ),
        (
            InputSample {
                pose: Pose {
                    orientation: [0.0; 4],
                    ..good.pose
                },
                ..good.clone()
            },
            "at its time 2.5 s is refused: quaternion is zero, expected a unit quaternion",
        ),
        (
            InputSample {
                pose: Pose {
                    orientation: [f64::NAN, 0.0, 0.0, 1.0],
                    ..good.pose
                },
                ..good.clone()
            },
            "at its time 2.5 s is refused: quaternion is not finite",
        ),
        (
            InputSample {
                pose: Pose {
                    orientation: [0.0, 0.0, 0.0, 2.0],
                    ..good.pose
                },
                ..good.clone()
            },
            "at its time 2.5 s is refused: quaternion has norm 2, expected 1 within 0.001",
        ),
        (
            InputSample {
                opening: Some(f64::NAN),
                ..good.clone()
            },
            "at its time 2.5 s is refused: opening is not finite",
        ),
    ];
    for (index, (bad, expected)) in cases.into_iter().enumerate() {
        let mut translator = translator(Mapping::identity("stylus", "forceps"));
        translator.feed(&good, 0.0).unwrap();
        let before = translator.tools()[0].pose().unwrap();
        let refusal = translator.feed(&bad, 0.25).unwrap_err();
        let expected = format!("tool \"forceps\": the sample of device \"stylus\" {expected}");
        assert_eq!(refusal.to_string(), expected, "case {index}");
        let tool = &translator.tools()[0];
        assert_eq!((tool.refused(), refusal.count), (1, 1), "case {index}");
        assert_eq!(tool.pose(), Some(before), "case {index}");
        let status = translator.status(tool, 0.25).0;
        assert_eq!(status, ToolStatus::Occluded, "case {index}");
        // What follows knows that the motion ends here, and where the tool was last.
        let lost = translator.lost(&bad).unwrap();
        assert_eq!((lost.tool.as_str(), lost.tracked), ("forceps", false));
        assert_eq!((lost.pose, lost.opening), (before.pose, before.opening));
        assert_eq!(lost.time.to_bits(), bad.device_time.to_bits());
    }
}

/// Values of a device that was not visible are not looked at.
#[test]
fn hidden_sample_may_hold_anything() {
    let mut translator = translator(Mapping::identity("stylus", "forceps"));
    let sample = InputSample {
        pose: Pose {
            position: [f64::NAN; 3],
            orientation: [0.0; 4],
        },
        ..hidden(0.0)
    };
    assert_eq!(translator.feed(&sample, 0.0), Ok(None));
    assert_eq!(translator.tools()[0].refused(), 0);
}

/// One recording drives forceps or scissors by its mapping alone; a device without a mapping drives nothing.
#[test]
fn devices_and_tools_meet_in_the_mapping() {
    let mappings = vec![
        Mapping::identity("other", "scissors"),
        Mapping::identity("stylus", "forceps"),
    ];
    let mut translator = Translator::new(mappings, 0.5, ANY).unwrap();
    translator
        .feed(&sample(0.0, [1.0; 3], IDENTITY), 0.0)
        .unwrap();
    let stranger = InputSample {
        device: "stranger".into(),
        ..sample(0.0, [1.0; 3], IDENTITY)
    };
    assert_eq!(translator.feed(&stranger, 0.0), Ok(None));
    let found: Vec<(&str, ToolStatus)> = translator
        .tools()
        .iter()
        .map(|tool| (tool.name(), translator.status(tool, 0.0).0))
        .collect();
    assert_eq!(
        found,
        [
            ("scissors", ToolStatus::NeverSeen),
            ("forceps", ToolStatus::Tracked)
        ]
    );
}

/// A translator that is saved, rebuilt and restored reports the same as one that went on, at every later moment.
#[test]
fn saved_state_goes_on() {
    let mapping = Mapping {
        field_from_device: QUARTER_Z,
        scale: 0.1,
        ..Mapping::identity("stylus", "forceps")
    };
    let mut original = translator(mapping.clone());
    original
        .feed(&sample(0.1, [0.1, 0.2, 0.3], QUARTER_X), 0.1)
        .unwrap();
    original
        .feed(&sample(0.2, [f64::NAN; 3], QUARTER_X), 0.2)
        .unwrap_err();

    let bytes = serde_json::to_vec(original.state()).unwrap();
    let mut restored = translator(mapping);
    restored
        .restore(serde_json::from_slice(&bytes).unwrap())
        .unwrap();
    for now_s in [0.2, 0.3, 0.9] {
        assert_eq!(
            restored.status(&restored.tools()[0], now_s),
            original.status(&original.tools()[0], now_s),
            "at {now_s} s"
        );
    }
    let next = sample(1.0, [0.3, 0.2, 0.1], QUARTER_X);
    assert_eq!(restored.feed(&next, 1.0), original.feed(&next, 1.0));
    assert_eq!(restored.state(), original.state());

    let mut other = translator(Mapping::identity("stylus", "scissors"));
    let error = other.restore(original.state().clone()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the saved state has the tools [forceps], expected [scissors]"
    );

    original.reset();
    let tool = &original.tools()[0];
    assert_eq!(original.status(tool, 2.0).0, ToolStatus::NeverSeen);
    assert_eq!(tool.refused(), 0);
}

#[test]
fn bad_mappings_are_refused_in_words() {
    let good = Mapping::identity("stylus", "forceps");
    let with = |change: fn(&mut Mapping)| {
        let mut mapping = good.clone();
        change(&mut mapping);
        vec![mapping]
    };
    let cases = [
        (
            vec![good.clone(), Mapping::identity("other", "forceps")],
            "the tool has two mappings, expected one",
        ),
        (
            vec![Mapping::identity("stylus", "scissors"), good.clone()],
            "device \"stylus\" drives another tool already",
        ),
        (
            with(|m| m.device_origin[1] = f64::NAN),
            "device_origin is not finite",
        ),
        (
            with(|m| m.field_offset[2] = f64::INFINITY),
            "field_offset is not finite",
        ),
        (
            with(|m| m.scale = 0.0),
            "scale is 0, expected a finite positive number",
        ),
        (
            with(|m| m.scale = f64::NAN),
            "scale is NaN, expected a finite positive number",
        ),
        (
            with(|m| m.field_from_device = [0.0; 4]),
            "field_from_device: quaternion is zero, expected a unit quaternion",
        ),
        (
            with(|m| m.body_from_tool = [3.0, 0.0, 4.0, 0.0]),
            "body_from_tool: quaternion has norm 5, expected 1 within 0.001",
        ),
        (
            with(|m| m.opening = Opening::Constant(2.0)),
            "opening is 2, expected 0 (closed) to 1 (open)",
        ),
        (
            with(|m| {
                m.opening = Opening::Device {
                    closed: 0.5,
                    open: 0.5,
                }
            }),
            "opening is closed at 0.5 and open at 0.5, expected two different finite numbers",
        ),
    ];
    for (mappings, expected) in cases {
        let error = Translator::new(mappings, 0.5, ANY).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("mapping of tool \"forceps\": {expected}")
        );
    }
    let error = Translator::new(vec![good], 0.0, ANY).unwrap_err();
    assert_eq!(
        error.to_string(),
        "tools are stale after 0 s, expected a finite positive number"
    );
}
