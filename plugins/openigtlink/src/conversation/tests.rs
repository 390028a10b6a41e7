//! Messages in, samples out.

use super::*;
use microsim_igtl::{Decoder, Matrix, Position, Text};
use microsim_settings::read_openigtlink;

const STRAIGHT: Matrix = Matrix {
    axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    translation: [1.0, 2.0, 3.0],
};

fn conversation(text: &str) -> Conversation {
    let config = read_openigtlink(text, "test").expect("a configuration");
    Conversation::new(config.settings)
}

/// As it comes over a wire at 7 s, from the device "Tracker".
fn receive(conversation: &mut Conversation, time: Timestamp, message: &Message) -> Arrived {
    let bytes = encode(1, "Tracker", time, message).expect("bytes");
    conversation.receive(decode(&bytes), 7.0)
}

fn decode(bytes: &[u8]) -> Received {
    let mut decoder = Decoder::new();
    decoder.push(bytes);
    let received = decoder.next_message().expect("a stream");
    received.expect("a message")
}

fn tool<Place>(name: &str, place: Place) -> Tracked<Place> {
    Tracked {
        name: name.to_owned(),
        kind: 2,
        place,
    }
}

/// Name, time and whether it is seen, of each sample.
fn seen(arrived: &Arrived) -> Vec<(&str, f64, bool)> {
    let samples = arrived.samples.iter();
    samples
        .map(|sample| (&sample.device[..], sample.device_time, sample.visible))
        .collect()
}

#[test]
fn places_become_samples_in_metres_with_the_trackers_time() {
    let mut own = conversation("[[device]]\nname = \"Tracker\"\ndevice = \"right\"");
    let arrived = receive(&mut own, Timestamp(5 << 32), &Message::Transform(STRAIGHT));
    assert_eq!(seen(&arrived), [("right", 5.0, true)]);
    let pose = arrived.samples[0].pose;
    assert_eq!(pose.orientation, [0.0, 0.0, 0.0, 1.0]);
    let expected = [0.001, 0.002, 0.003];
    assert!(
        pose.position
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12)
    );
    // Where the tracker has no time it is that of the arrival.
    let position = Position {
        position: [0.0; 3],
        orientation: Some([0.0, 1.0, 0.0, 0.0]),
    };
    let arrived = receive(&mut own, Timestamp::default(), &Message::Position(position));
    assert_eq!(seen(&arrived), [("right", 7.0, true)]);
    assert_eq!(arrived.samples[0].pose.orientation, [0.0, 1.0, 0.0, 0.0]);
}

/// A tracker leaves out what it does not see: without a sample the tool would seem to stand still.
#[test]
fn a_tool_that_is_left_out_is_not_seen() {
    let mut own = conversation("");
    let stream = |names: &[&str]| {
        let tools = names.iter().map(|name| tool(name, STRAIGHT));
        Message::Matrices(tools.collect())
    };
    let time = Timestamp(5 << 32);
    let arrived = receive(&mut own, time, &stream(&["left", "right"]));
    assert_eq!(seen(&arrived), [("left", 5.0, true), ("right", 5.0, true)]);
    let arrived = receive(&mut own, time, &stream(&["right"]));
    assert_eq!(seen(&arrived), [("right", 5.0, true), ("left", 5.0, false)]);
    let arrived = receive(&mut own, time, &stream(&[]));
    assert_eq!(
        seen(&arrived),
        [("left", 5.0, false), ("right", 5.0, false)]
    );
    let arrived = receive(&mut own, time, &stream(&["left", "right"]));
    assert_eq!(arrived.samples.len(), 2);
    // A device of its own is none of the stream.
    let arrived = receive(&mut own, time, &Message::Transform(STRAIGHT));
    assert_eq!(seen(&arrived), [("Tracker", 5.0, true)]);
    let arrived = receive(&mut own, time, &stream(&["left", "right"]));
    assert_eq!(arrived.samples.len(), 2);
    // With the connection all are gone, once.
    let lost = own.lost(9.0);
    let names: Vec<&str> = lost.iter().map(|sample| &sample.device[..]).collect();
    assert_eq!(names, ["Tracker", "left", "right"]);
    assert!(
        lost.iter()
            .all(|sample| !sample.visible && sample.device_time == 9.0)
    );
    assert_eq!(own.lost(10.0), []);
}

/// The other tool of the same message is not lost with it.
#[test]
fn a_tool_without_a_pose_is_named_once_and_not_seen() {
    let mut own = conversation("");
    let wrong = Matrix {
        axes: [[f32::NAN; 3]; 3],
        ..STRAIGHT
    };
    let message = Message::Matrices(vec![tool("left", wrong), tool("right", STRAIGHT)]);
    let arrived = receive(&mut own, Timestamp(1 << 32), &message);
    assert_eq!(seen(&arrived), [("left", 1.0, false), ("right", 1.0, true)]);
    assert_eq!(
        arrived.notes,
        [(true, "left: a number is not finite".to_owned())]
    );
    let again = receive(&mut own, Timestamp(1 << 32), &message);
    assert_eq!((again.samples.len(), again.notes.len()), (2, 0));
}

#[test]
fn a_client_asks_for_the_stream_of_its_configuration() {
    let asked = |text: &str| {
        let own = conversation(text);
        let message = |bytes: Vec<u8>| decode(&bytes).message.expect("a body").expect("a type");
        (own.begin().map(message), own.end().map(message))
    };
    let start = |interval| Start {
        interval,
        coordinates: String::new(),
    };
    let matrices = Stream::Matrices;
    assert_eq!(
        asked("interval = \"20 ms\""),
        (
            Some(Message::Start(matrices, start(20))),
            Some(Message::Stop(matrices))
        )
    );
    let quaternions = Stream::Quaternions;
    assert_eq!(
        asked("stream = \"QTDATA\""),
        (
            Some(Message::Start(quaternions, start(10))),
            Some(Message::Stop(quaternions))
        )
    );
    assert_eq!(asked("stream = \"none\""), (None, None));
    assert_eq!(asked("role = \"server\""), (None, None));
}

#[test]
fn queries_are_answered_in_the_version_of_the_peer() {
    let mut own = conversation("");
    let get = Message::Get("CAPABIL".into());
    for version in [1, 2] {
        let bytes = encode(version, "x", Timestamp::default(), &get).expect("bytes");
        let answer = own.receive(decode(&bytes), 0.0).answer.expect("an answer");
        let answer = decode(&answer);
        assert_eq!(answer.version, version);
        let types = Message::Capability(TYPES.map(str::to_owned).to_vec());
        assert_eq!(answer.message, Ok(Some(types)));
    }
    let refused = receive(
        &mut own,
        Timestamp::default(),
        &Message::Start(
            Stream::Matrices,
            Start {
                interval: 1,
                coordinates: String::new(),
            },
        ),
    );
    let answer = decode(&refused.answer.expect("an answer"));
    assert_eq!(
        answer.message,
        Ok(Some(Message::Started(Stream::Matrices, false)))
    );
    let unknown = receive(
        &mut own,
        Timestamp::default(),
        &Message::Get("IMAGE".into()),
    );
    assert_eq!(unknown, Arrived::default());
}

/// Line breaks and quotes of a peer do not end a line of the log.
#[test]
fn what_a_peer_reports_is_a_note_in_one_line() {
    let mut own = conversation("");
    let status = |code, text: &str| {
        Message::Status(Status {
            code,
            subcode: 0,
            name: "CAMERA".into(),
            text: text.into(),
        })
    };
    let note = |arrived: Arrived| arrived.notes;
    let bad = note(receive(
        &mut own,
        Timestamp::default(),
        &status(13, "a\n\"b\""),
    ));
    assert_eq!(
        bad,
        [(
            true,
            r#"Tracker: status 13 "CAMERA": "a\n\"b\"""#.to_owned()
        )]
    );
    let good = note(receive(&mut own, Timestamp::default(), &status(1, "")));
    assert_eq!(good, []);
    let text = Message::Text(Text::utf8("hallo\n"));
    let text = note(receive(&mut own, Timestamp::default(), &text));
    assert_eq!(text, [(false, r#"Tracker: "hallo\n""#.to_owned())]);
    let mut bytes = encode(1, "x", Timestamp::default(), &status(1, "")).expect("bytes");
    bytes[2..8].copy_from_slice(b"IMAGE\0");
    let image = note(own.receive(decode(&bytes), 0.0));
    assert_eq!(
        image,
        [(false, "messages of type IMAGE are not used".to_owned())]
    );
}

/// The protocol has no openings: one comes as the x coordinate of a device of its own, before or in the list of its tool, and is no sample itself.
#[test]
fn an_opening_comes_from_a_device_of_its_own() {
    let text = "[[device]]\nname = \"Left\"\ndevice = \"left\"\nopening = { name = \"Jaws\", closed = \"1 mm\", open = \"5 mm\" }";
    let mut own = conversation(text);
    let at = |x: f32| Matrix {
        translation: [x, 0.0, 0.0],
        ..STRAIGHT
    };
    let list = Message::Matrices(vec![tool("Left", STRAIGHT), tool("Jaws", at(2.0))]);
    let arrived = receive(&mut own, Timestamp(1 << 32), &list);
    assert_eq!(seen(&arrived), [("left", 1.0, true)]);
    // By hand: 2 mm are a quarter between 1 and 5 mm.
    let opening = arrived.samples[0].opening.expect("an opening");
    assert!((opening - 0.25).abs() < 1e-12, "{opening}");
    // It holds until another one comes, and is that of an end beyond it.
    let alone = Message::Matrices(vec![tool("Left", STRAIGHT)]);
    let arrived = receive(&mut own, Timestamp(2 << 32), &alone);
    assert_eq!(
        (seen(&arrived).len(), arrived.samples[0].opening),
        (1, Some(opening))
    );
    let wide = Message::Matrices(vec![tool("Jaws", at(9.0)), tool("Left", STRAIGHT)]);
    let arrived = receive(&mut own, Timestamp(3 << 32), &wide);
    assert_eq!(
        (seen(&arrived).len(), arrived.samples[0].opening),
        (1, Some(1.0))
    );
}

/// Of a marker the position counts, with an orientation, without one, or with one that is none.
#[test]
fn a_marker_has_a_position_alone() {
    let text = "marker = [\"left-1\", \"Tracker\"]";
    let mut own = conversation(text);
    let alone = Position {
        position: [1.0, 2.0, 3.0],
        orientation: None,
    };
    let arrived = receive(&mut own, Timestamp(1 << 32), &Message::Position(alone));
    assert_eq!(seen(&arrived), [("Tracker", 1.0, true)]);
    assert_eq!(arrived.samples[0].pose.orientation, [0.0, 0.0, 0.0, 1.0]);
    let broken = Matrix {
        axes: [[0.0; 3]; 3],
        ..STRAIGHT
    };
    let list = Message::Matrices(vec![tool("left-1", broken), tool("left", broken)]);
    let arrived = receive(&mut own, Timestamp(2 << 32), &list);
    assert_eq!(
        seen(&arrived),
        [("left-1", 2.0, true), ("left", 2.0, false)]
    );
    // A position that is none is not seen.
    let nowhere = Position {
        position: [f32::NAN, 0.0, 0.0],
        orientation: None,
    };
    let arrived = receive(&mut own, Timestamp(3 << 32), &Message::Position(nowhere));
    assert_eq!(seen(&arrived), [("Tracker", 3.0, false)]);
}

/// Where the sender's clock decides, times count from its first sample, exactly to the nanosecond; what has none, or comes from before, is left out and named.
#[test]
fn times_count_from_the_first_sample_where_the_senders_clock_decides() {
    let mut own = conversation("clock = \"device\"");
    let stamp = |nanoseconds| Timestamp::from_nanoseconds(nanoseconds);
    let transform = Message::Transform(STRAIGHT);
    for (nanoseconds, expected) in [
        (1_767_323_045_016_000_000, 0.0),
        (1_767_323_045_032_000_000, 0.016),
        (1_767_323_048_824_000_000, 3.808),
    ] {
        let arrived = receive(&mut own, stamp(nanoseconds), &transform);
        assert_eq!(seen(&arrived), [("Tracker", expected, true)]);
    }
    let before = receive(&mut own, stamp(1_767_323_045_000_000_000), &transform);
    assert_eq!((before.samples.len(), before.notes.len()), (0, 1));
    let without = receive(&mut own, Timestamp::default(), &transform);
    assert_eq!(without.samples, []);
    assert!(
        without.notes[0].1.contains("`clock` is \"device\""),
        "{without:?}"
    );
}
