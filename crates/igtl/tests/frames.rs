//! Messages of real peers, decoded and encoded: the C++ library OpenIGTLink 1.11 and pyigtl 0.3 (`peers/`, with the programs that wrote them).

use microsim_igtl::{
    DecodeError, Decoder, EncodeError, Matrix, Message, Position, Received, Start, Status, Stream,
    Text, Timestamp, Tracked, encode,
};
use proptest::prelude::*;

/// What `peers/frames.cxx` and `peers/frames.py` set.
const TURNED: Matrix = Matrix {
    axes: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    translation: [1.5, -2.25, 300.0],
};
const STRAIGHT: Matrix = Matrix {
    axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    translation: [-7.0, 8.0, 0.125],
};
const POSITION: Position = Position {
    position: [1.5, -2.25, 300.0],
    orientation: Some([0.0, 0.0, 0.6, 0.8]),
};
/// 2026-01-02 03:04:05.75 UTC.
const TIME_NS: u64 = 1_767_323_045_750_000_000;

/// Names and bytes of a file.
fn frames(text: &str) -> Vec<(&str, Vec<u8>)> {
    text.lines()
        .map(|line| {
            let (name, hex) = line.split_once(' ').expect("a name and bytes");
            let byte = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).expect("a byte");
            (name, (0..hex.len()).step_by(2).map(byte).collect())
        })
        .collect()
}

fn of_library() -> Vec<(&'static str, Vec<u8>)> {
    frames(include_str!("peers/openigtlink-1.11.txt"))
}

fn of_pyigtl() -> Vec<(&'static str, Vec<u8>)> {
    frames(include_str!("peers/pyigtl-0.3.txt"))
}

/// All messages of a stream that is there as a whole.
fn decoded(bytes: &[u8]) -> Result<Vec<Received>, DecodeError> {
    let mut decoder = Decoder::new();
    decoder.push(bytes);
    let mut found = Vec::new();
    while let Some(message) = decoder.next_message()? {
        found.push(message);
    }
    Ok(found)
}

fn one(bytes: &[u8]) -> Received {
    let found = decoded(bytes).expect("a message");
    assert_eq!(found.len(), 1);
    found.into_iter().next().expect("one")
}

fn tool<Place>(name: &str, kind: u8, place: Place) -> Tracked<Place> {
    Tracked {
        name: name.to_owned(),
        kind,
        place,
    }
}

fn expected(name: &str) -> Message {
    let start = Start {
        interval: 20,
        coordinates: "Field".to_owned(),
    };
    match name {
        "TRANSFORM" | "TRANSFORM-20" | "TRANSFORM-1" | "TRANSFORM-2" => Message::Transform(TURNED),
        "POSITION" => Message::Position(POSITION),
        "TDATA" => Message::Matrices(vec![tool("left", 2, TURNED), tool("right", 4, STRAIGHT)]),
        "TDATA-0" => Message::Matrices(Vec::new()),
        "QTDATA" => Message::Quaternions(vec![tool("left", 2, POSITION)]),
        "STT_TDATA" => Message::Start(Stream::Matrices, start),
        "STT_QTDATA" => Message::Start(Stream::Quaternions, start),
        "STP_TDATA" => Message::Stop(Stream::Matrices),
        "STP_QTDATA" => Message::Stop(Stream::Quaternions),
        "RTS_TDATA" => Message::Started(Stream::Matrices, true),
        "RTS_QTDATA" => Message::Started(Stream::Quaternions, false),
        "GET_TRANS" => Message::Get("TRANS".to_owned()),
        "STRING" => Message::Text(Text::utf8("Grün")),
        "STRING-1" | "STRING-2" | "STRING-metadata" => Message::Text(Text {
            encoding: 3,
            bytes: b"Gruen".to_vec(),
        }),
        "STATUS" => Message::Status(Status {
            code: 13,
            subcode: -3,
            name: "CAMERA".to_owned(),
            text: "warming up".to_owned(),
        }),
        "CAPABILITY" => Message::Capability(
            ["TRANSFORM", "TDATA", "STT_TDATA"]
                .map(str::to_owned)
                .into(),
        ),
        other => panic!("nothing is expected of {other}"),
    }
}

fn device(name: &str) -> &'static str {
    match name {
        "TRANSFORM-20" => "ABCDEFGHIJKLMNOPQRST",
        _ => "Forceps",
    }
}

/// Every value that the peers set comes out, and every byte that the C++ library wrote is written.
#[test]
fn messages_of_the_library_are_read_and_written_to_the_byte() {
    let all = of_library();
    assert_eq!(all.len(), 16);
    for (name, bytes) in all {
        let found = one(&bytes);
        assert_eq!(found.message, Ok(Some(expected(name))), "{name}");
        assert_eq!((found.version, &found.device[..]), (1, device(name)));
        assert_eq!(found.time.nanoseconds(), Some(TIME_NS), "{name}");
        let written = encode(1, device(name), found.time, &expected(name));
        assert_eq!(written.as_ref(), Ok(&bytes), "{name}");
    }
}

/// With either version of the header, and with metadata, which has no place in ours.
#[test]
fn messages_of_pyigtl_are_read_and_written_to_the_byte() {
    let all = of_pyigtl();
    assert_eq!(all.len(), 5);
    for (name, bytes) in all {
        let found = one(&bytes);
        assert_eq!(found.message, Ok(Some(expected(name))), "{name}");
        assert_eq!(found.time.nanoseconds(), Some(TIME_NS), "{name}");
        if name != "STRING-metadata" {
            let written = encode(found.version, device(name), found.time, &expected(name));
            assert_eq!(written.as_ref(), Ok(&bytes), "{name}");
        }
    }
}

/// Byte by byte, all in one, and with an image and one of an unknown type between them.
#[test]
fn pieces_of_any_length_give_the_same_messages() {
    let mut bytes = Vec::new();
    let mut names = Vec::new();
    for (name, frame) in of_library().into_iter().chain(of_pyigtl()) {
        bytes.extend(frame);
        names.push(name);
    }
    let foreign = of_another_type(&bytes.clone());
    bytes.extend(&foreign);
    bytes.extend(
        encode(
            1,
            "last",
            Timestamp::default(),
            &Message::Stop(Stream::Matrices),
        )
        .expect("bytes"),
    );
    let whole = decoded(&bytes).expect("messages");
    assert_eq!(whole.len(), names.len() + 2);
    assert_eq!(whole[names.len()].kind, "IMAGE");
    assert_eq!(whole[names.len()].message, Ok(None));
    assert_eq!(whole[names.len() + 1].device, "last");
    for length in [1, 7, 58, 59, 1000] {
        let mut decoder = Decoder::new();
        let mut found = Vec::new();
        for piece in bytes.chunks(length) {
            decoder.push(piece);
            while let Some(message) = decoder.next_message().expect("a message") {
                found.push(message);
            }
        }
        assert_eq!(found, whole, "{length}");
    }
}

/// A message of a type that is skipped, with some body and its checksum.
fn of_another_type(body: &[u8]) -> Vec<u8> {
    let text = Text {
        encoding: 0,
        bytes: body[..body.len().min(60_000)].to_vec(),
    };
    let message = Message::Text(text);
    let mut bytes = encode(1, "camera", Timestamp::default(), &message).expect("bytes");
    bytes[2..14].copy_from_slice(b"IMAGE\0\0\0\0\0\0\0");
    bytes
}

/// A body that does not fit its type costs its message alone.
#[test]
fn a_body_of_another_length_is_named_and_the_next_message_read() {
    let last = encode(
        1,
        "",
        Timestamp::default(),
        &Message::Stop(Stream::Matrices),
    );
    let last = last.expect("bytes");
    for (kind, length, part) in [
        ("TRANSFORM", 47, "48 bytes"),
        ("POSITION", 27, "12, 24 or 28"),
        ("TDATA", 71, "70 bytes for each"),
        ("QTDATA", 49, "50 bytes for each"),
        ("STT_TDATA", 35, "36 bytes"),
        ("STRING", 3, "as many as they say"),
        ("STATUS", 29, "30 bytes"),
        ("CAPABILITY", 13, "12 bytes for each"),
        ("RTS_TDATA", 0, "a byte"),
    ] {
        let mut bytes = of_another_type(&vec![0; length + 60]);
        bytes.truncate(58 + length);
        bytes[2..14].fill(0);
        bytes[2..2 + kind.len()].copy_from_slice(kind.as_bytes());
        set_body(&mut bytes);
        bytes.extend(&last);
        let found = decoded(&bytes).expect("a stream that goes on");
        let error = found[0].message.clone().expect_err(kind).to_string();
        assert!(error.starts_with(kind) && error.contains(part), "{error}");
        assert!(error.contains(&format!("{length} bytes")), "{error}");
        assert_eq!(found.len(), 2, "{kind}");
    }
}

/// Sets length and checksum to what the body is.
fn set_body(bytes: &mut [u8]) {
    let length = bytes.len() as u64 - 58;
    bytes[42..50].copy_from_slice(&length.to_be_bytes());
    let sum = bytes[58..].iter().fold(0u64, |sum, byte| {
        // Bit by bit, from the polynomial.
        (0..8).fold(sum ^ (u64::from(*byte) << 56), |sum, _| {
            (sum << 1)
                ^ if sum >> 63 == 1 {
                    0x42F0_E1EB_A9EA_3693
                } else {
                    0
                }
        })
    });
    bytes[50..58].copy_from_slice(&sum.to_be_bytes());
}

/// The shorter forms of POSITION (protocol specification): the fourth number follows from the length 1.
#[test]
fn positions_may_leave_out_what_follows_or_is_unknown() {
    let whole = encode(1, "", Timestamp::default(), &Message::Position(POSITION));
    let whole = whole.expect("bytes");
    for (length, orientation) in [(12, None), (24, POSITION.orientation)] {
        let mut bytes = whole[..58 + length].to_vec();
        set_body(&mut bytes);
        let Ok(Some(Message::Position(found))) = one(&bytes).message else {
            panic!("no position");
        };
        assert_eq!(found.position, POSITION.position);
        match (found.orientation, orientation) {
            (Some(found), Some(expected)) => {
                let pairs = found.iter().zip(expected);
                assert!(
                    pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6),
                    "{found:?}"
                );
            }
            (found, expected) => assert_eq!(found, expected),
        }
    }
}

/// Nothing behind these can be found again; no header makes the decoder take the memory that it asks for.
#[test]
fn what_ends_a_stream_is_named() {
    let frame = of_library().remove(0).1;
    let with = |at: usize, new: &[u8]| {
        let mut bytes = frame.clone();
        bytes[at..at + new.len()].copy_from_slice(new);
        decoded(&bytes)
    };
    assert_eq!(with(0, &[0, 0]), Err(DecodeError::Version(0)));
    assert_eq!(with(0, b"GE"), Err(DecodeError::Version(0x4745)));
    let long = with(42, &u64::MAX.to_be_bytes());
    let text = long.expect_err("too long").to_string();
    assert!(
        text.starts_with("TRANSFORM: ") && text.contains(&u64::MAX.to_string()),
        "{text}"
    );
    assert_eq!(
        with(60, &[1]),
        Err(DecodeError::Checksum("TRANSFORM".into()))
    );
    let mut image = of_another_type(&[1; 100]);
    image[70] ^= 1;
    assert_eq!(decoded(&image), Err(DecodeError::Checksum("IMAGE".into())));
    // An extended header that reaches beyond its body.
    let mut second = of_pyigtl().remove(1).1;
    second[62..66].copy_from_slice(&100u32.to_be_bytes());
    set_body(&mut second);
    let error = DecodeError::ExtendedHeader("TRANSFORM".into());
    assert_eq!(decoded(&second), Err(error.clone()));
    // The same error again, whatever comes.
    let mut decoder = Decoder::new();
    decoder.push(&second);
    assert_eq!(decoder.next_message(), Err(error.clone()));
    decoder.push(&frame);
    assert_eq!(decoder.next_message(), Err(error));
}

#[test]
fn what_has_no_place_in_a_message_is_not_cut() {
    let long = "a name of 21 bytes...";
    let name = |message: &Message| encode(1, "", Timestamp::default(), message);
    let error = Err(EncodeError::Name(long.into(), 20));
    assert_eq!(
        encode(1, long, Timestamp::default(), &expected("TRANSFORM")),
        error
    );
    assert_eq!(name(&Message::Matrices(vec![tool(long, 2, TURNED)])), error);
    let nul = Message::Capability(vec!["A\0B".into()]);
    assert_eq!(name(&nul), Err(EncodeError::Name("A\0B".into(), 12)));
    let text = Message::Text(Text::utf8(&"x".repeat(65_536)));
    assert_eq!(name(&text), Err(EncodeError::Text(65_536)));
    let third = encode(3, "", Timestamp::default(), &expected("TRANSFORM"));
    assert_eq!(third, Err(EncodeError::Version(3)));
}

proptest! {
    /// Of a message with some bytes changed the decoder gives the message, an error or nothing, and no panic; a change in the body alone is always noticed.
    #[test]
    fn damaged_messages_are_errors_or_messages(
        frame in 0..21usize,
        damage in prop::collection::vec((0..400usize, 1..=255u8), 1..4),
        cut in 0..400usize,
    ) {
        let all: Vec<_> = of_library().into_iter().chain(of_pyigtl()).collect();
        let mut bytes = all[frame].1.clone();
        let length = bytes.len();
        let places: Vec<usize> = damage.iter().map(|(at, _)| at % length).collect();
        for (at, (_, flip)) in places.iter().zip(&damage) {
            bytes[*at] ^= flip;
        }
        let changed = bytes != all[frame].1;
        let found = decoded(&bytes);
        if changed && places.iter().all(|at| *at >= 58) {
            prop_assert!(matches!(found, Err(DecodeError::Checksum(_))));
        }
        bytes.truncate(cut);
        let _ = decoded(&bytes);
    }

    /// Bytes of any kind, in pieces.
    #[test]
    fn noise_is_no_reason_to_panic(pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..200), 0..5)) {
        let mut decoder = Decoder::new();
        for piece in pieces {
            decoder.push(&piece);
            while let Ok(Some(_)) = decoder.next_message() {}
        }
    }

    /// Bodies of any kind with right checksums: the type decides, nothing panics, and what is decoded is encoded to the same bytes where all of it was meant.
    #[test]
    fn any_body_with_its_checksum_is_decoded_or_refused(
        kind in prop::sample::select(vec!["TRANSFORM", "POSITION", "TDATA", "QTDATA", "STT_TDATA", "RTS_QTDATA", "STRING", "STATUS", "CAPABILITY", "GET_STATUS"]),
        version in 1..=3u16,
        body in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let mut bytes = encode(1, "x", Timestamp(7), &Message::Stop(Stream::Matrices)).expect("bytes");
        bytes[..2].copy_from_slice(&version.to_be_bytes());
        bytes[2..14].fill(0);
        bytes[2..2 + kind.len()].copy_from_slice(kind.as_bytes());
        bytes.extend(body);
        set_body(&mut bytes);
        if let Ok(found) = decoded(&bytes) {
            prop_assert_eq!(found.len(), 1);
            let numbers_alone = matches!(kind, "TRANSFORM" | "POSITION");
            if let (true, 1, Ok(Some(message))) = (numbers_alone, version, &found[0].message)
                && bytes.len() != 58 + 24
            {
                prop_assert_eq!(encode(1, "x", Timestamp(7), message), Ok(bytes));
            }
        }
    }
}
