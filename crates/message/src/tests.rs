use crate::*;
use microsim_bus::Frames;
use proptest::prelude::*;
use std::collections::BTreeSet;

fn sample(t: f64, position: [f64; 3], opening: Option<f64>) -> InputSample {
    InputSample {
        device: "stylus".into(),
        device_time: t,
        visible: true,
        pose: Pose {
            position,
            ..Pose::default()
        },
        opening,
    }
}

#[test]
fn kinds_have_names_and_ids_of_their_own() {
    let kinds = core_kinds();
    let ids: BTreeSet<u64> = kinds.iter().map(microsim_bus::KindInfo::id).collect();
    assert_eq!(ids.len(), kinds.len());
    assert!(kinds.iter().all(|k| k.name.contains('.') && k.version > 0));
}

#[test]
fn a_message_is_readable_by_people_without_its_type() {
    let mut bytes = Vec::new();
    push(&mut bytes, &sample(1.5, [0.25, 0.0, -1.0], None));
    let frame = Frames::new(&bytes).next().expect("a frame").expect("whole");
    let json = to_json(frame.payload).expect("readable");
    assert_eq!(json["device"], "stylus");
    assert_eq!(
        json["pose"]["position"],
        serde_json::json!([0.25, 0.0, -1.0])
    );
    assert!(json["opening"].is_null());
}

/// Saved states hold it, and their hashes are compared: its fields lie side by side, in this order.
#[test]
fn a_tool_pose_is_flat_on_the_wire() {
    #[derive(serde::Serialize)]
    struct Flat {
        position: [f64; 3],
        orientation: [f64; 4],
        opening: f64,
        sample_time_s: f64,
    }
    let flat = Flat {
        position: [0.5, -0.0, 1e-300],
        orientation: [0.0, 0.6, 0.0, 0.8],
        opening: 0.25,
        sample_time_s: 7.5,
    };
    let at = ToolPose {
        pose: Pose {
            position: flat.position,
            orientation: flat.orientation,
        },
        opening: flat.opening,
        time: flat.sample_time_s,
    };
    assert_eq!(encode(&at), encode(&flat));
    assert_eq!(decode_bytes::<ToolPose>(&encode(&flat)), Ok(at));
    let sample = ToolSample::new("left", true, at);
    assert_eq!((sample.at(), sample.time), (at, 7.5));
}

#[test]
fn another_kind_is_none_and_another_version_an_error() {
    let mut bytes = Vec::new();
    push(&mut bytes, &LevelControl::Start);
    let frame = Frames::new(&bytes).next().expect("a frame").expect("whole");
    assert!(decode::<InputSample>(&frame).is_none());
    assert_eq!(
        decode::<LevelControl>(&frame),
        Some(Ok(LevelControl::Start))
    );
    let mut newer = frame;
    newer.header.version = 2;
    let error = decode::<LevelControl>(&newer)
        .expect("its kind")
        .expect_err("its version");
    assert!(
        error.0.contains("\"level.control\" in version 2"),
        "{error}"
    );
    let mut torn = frame;
    torn.payload = &frame.payload[..frame.payload.len() - 1];
    assert!(decode::<LevelControl>(&torn).expect("its kind").is_err());
}

proptest! {
    /// Replay rests on it: what comes out of the wire is what went in, to the bit.
    #[test]
    fn numbers_cross_the_wire_to_the_bit(
        t in any::<f64>(), p in any::<[f64; 3]>(), opening in any::<Option<f64>>()
    ) {
        let mut bytes = Vec::new();
        push(&mut bytes, &sample(t, p, opening));
        let frame = Frames::new(&bytes).next().unwrap().unwrap();
        let back = decode::<InputSample>(&frame).unwrap().unwrap();
        prop_assert_eq!(back.device_time.to_bits(), t.to_bits());
        prop_assert_eq!(back.pose.position.map(f64::to_bits), p.map(f64::to_bits));
        prop_assert_eq!(back.opening.map(f64::to_bits), opening.map(f64::to_bits));
    }

    #[test]
    fn any_payload_is_safe(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = to_json(&bytes);
        let _ = decode_bytes::<TrainingResult>(&bytes);
        let _ = decode_bytes::<Setup>(&bytes);
    }
}
