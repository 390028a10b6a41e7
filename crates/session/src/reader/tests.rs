//! Whole files, cut ones and damaged ones.

use proptest::prelude::*;

use super::*;
use crate::writer::Writer;

/// Kind, tick and payload of each frame of the small file that the tests cut and damage.
const FRAMES: [(u8, u64, &[u8]); 5] = [
    (1, 0, b"configuration"),
    (2, 1, b""),
    (2, 1, b"\0\0\0\0"),
    (9, 250, b"a longer payload, so that cuts fall inside"),
    (KIND_END, 251, b"!"),
];

/// The file, and the offset at which each of its frames begins, with the file's length at last.
fn small_file() -> (Vec<u8>, Vec<usize>) {
    let mut writer = Writer::create(Vec::new()).unwrap();
    let mut boundaries = vec![PRELUDE_LENGTH];
    for (kind, tick, payload) in FRAMES {
        writer.append(kind, tick, payload).unwrap();
        boundaries.push(boundaries[boundaries.len() - 1] + HEADER_LENGTH + payload.len());
    }
    (writer.into_inner(), boundaries)
}

fn assert_first_frames(frames: &[Frame], count: usize, boundaries: &[usize], context: &str) {
    assert_eq!(frames.len(), count, "{context}");
    for (index, frame) in frames.iter().enumerate() {
        let (kind, tick, payload) = FRAMES[index];
        let expected = Frame {
            offset: boundaries[index],
            kind,
            sequence: index as u64,
            tick,
            payload,
        };
        assert_eq!(*frame, expected, "{context}");
    }
}

#[test]
fn what_was_written_is_read() {
    let (bytes, boundaries) = small_file();
    let reading = read(&bytes).unwrap();
    assert_first_frames(&reading.frames, FRAMES.len(), &boundaries, "whole file");
    assert_eq!(reading.ending, Ending::Clean);
    assert_eq!(reading.frames.last().map(|frame| frame.tick), Some(251));
}

/// From each frame on, the rest is read as it is from the beginning, with the same end.
#[test]
fn reading_goes_on_at_any_frame() {
    let (bytes, boundaries) = small_file();
    for (index, begin) in boundaries[..FRAMES.len()].iter().enumerate() {
        let mut reader = Reader::at(&bytes[*begin..], *begin, index as u64);
        for (number, (kind, tick, payload)) in FRAMES.into_iter().enumerate().skip(index) {
            let expected = Frame {
                offset: boundaries[number],
                kind,
                sequence: number as u64,
                tick,
                payload,
            };
            assert_eq!(reader.next_frame().unwrap(), Some(expected));
        }
        assert_eq!(reader.next_frame().unwrap(), None);
        assert_eq!(reader.ending(), Some(Ending::Clean));
        assert!(reader.into_source().is_empty());
    }
    let mut elsewhere = Reader::at(&bytes[boundaries[2]..], boundaries[2], 1);
    assert_eq!(elsewhere.next_frame().unwrap(), None);
    assert!(matches!(
        elsewhere.ending(),
        Some(Ending::Damaged {
            what: Damage::Sequence {
                expected: 1,
                found: 2
            },
            ..
        })
    ));
}

/// Every cut: all frames that were complete before it are recovered, and the ending names what it was.
#[test]
fn every_prefix_gives_its_complete_frames() {
    let (bytes, boundaries) = small_file();
    for cut in 0..bytes.len() {
        let context = format!("cut at byte {cut}");
        let reading = match read(&bytes[..cut]) {
            Ok(reading) => reading,
            Err(error) => {
                assert!(cut < PRELUDE_LENGTH, "{context}: {error}");
                assert_eq!(error, NotASession::TooShort(cut));
                continue;
            }
        };
        let complete = boundaries
            .iter()
            .filter(|&&boundary| boundary <= cut)
            .count()
            - 1;
        assert_first_frames(&reading.frames, complete, &boundaries, &context);
        let expected = if boundaries[complete] == cut {
            Ending::Open
        } else {
            Ending::Torn {
                offset: boundaries[complete],
                after_tick: complete.checked_sub(1).map(|index| FRAMES[index].1),
                bytes_lost: cut - boundaries[complete],
            }
        };
        assert_eq!(reading.ending, expected, "{context}");
    }
}

/// Every flipped bit: noticed, placed at the start of the frame that holds it, and never taken for a tear.
#[test]
fn every_flipped_bit_is_noticed_and_placed() {
    let (mut bytes, boundaries) = small_file();
    let length = bytes.len();
    for bit in 0..8 * length {
        let context = format!("bit {} of byte {}", bit % 8, bit / 8);
        bytes[bit / 8] ^= 1 << (bit % 8);
        match read(&bytes) {
            Err(error) => {
                let expected = if bit / 8 < MAGIC.len() {
                    NotASession::Magic
                } else {
                    NotASession::Version(FORMAT_VERSION ^ (1 << (bit - 8 * MAGIC.len())))
                };
                assert_eq!(error, expected, "{context}");
            }
            Ok(reading) => {
                let hit = boundaries
                    .iter()
                    .filter(|&&boundary| boundary <= bit / 8)
                    .count()
                    - 1;
                assert_first_frames(&reading.frames, hit, &boundaries, &context);
                let what = if bit / 8 < boundaries[hit] + HEADER_LENGTH {
                    Damage::Header
                } else {
                    Damage::Payload
                };
                let expected = Ending::Damaged {
                    offset: boundaries[hit],
                    after_tick: hit.checked_sub(1).map(|index| FRAMES[index].1),
                    bytes_lost: length - boundaries[hit],
                    what,
                };
                assert_eq!(reading.ending, expected, "{context}");
            }
        }
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn a_missing_frame_is_noticed() {
    let (mut bytes, boundaries) = small_file();
    bytes.drain(boundaries[1]..boundaries[2]);
    let reading = read(&bytes).unwrap();
    assert_first_frames(&reading.frames, 1, &boundaries, "without frame 1");
    let Ending::Damaged { offset, what, .. } = reading.ending else {
        panic!("{:?}", reading.ending);
    };
    assert_eq!(offset, boundaries[1]);
    assert_eq!(
        what,
        Damage::Sequence {
            expected: 1,
            found: 2
        }
    );
}

#[test]
fn a_repeated_end_is_noticed() {
    let (mut bytes, boundaries) = small_file();
    bytes.extend_from_within(boundaries[4]..);
    let reading = read(&bytes).unwrap();
    assert_first_frames(&reading.frames, 5, &boundaries, "end twice");
    assert_eq!(
        reading.ending.to_string(),
        format!(
            "the session is damaged at byte {}, after tick 251: bytes follow the end of the session; 30 bytes \
             from there on are not read",
            boundaries[5]
        )
    );
}

/// A length beyond the limit, with checksums that are right, is refused before it is followed.
#[test]
fn an_oversized_length_is_damage() {
    let (mut bytes, boundaries) = small_file();
    let start = boundaries[0];
    let length = MAX_PAYLOAD as u32 + 1;
    bytes[start..start + 4].copy_from_slice(&length.to_le_bytes());
    let checksum = crc32fast::hash(&bytes[start..start + HEADER_CHECKED]);
    bytes[start + HEADER_CHECKED..start + HEADER_LENGTH].copy_from_slice(&checksum.to_le_bytes());
    let reading = read(&bytes).unwrap();
    assert!(reading.frames.is_empty());
    assert_eq!(
        reading.ending,
        Ending::Damaged {
            offset: start,
            after_tick: None,
            bytes_lost: bytes.len() - start,
            what: Damage::Length(length),
        }
    );
}

#[test]
fn other_files_are_refused_in_words() {
    let error = read(b"t_s,x_mm,y_mm,z_mm").unwrap_err();
    assert_eq!(
        error.to_string(),
        "not a session file: it does not begin with the line \"MicroSim session\""
    );
    let error = read(b"MicroSim session\n\x07\0\0\0").unwrap_err();
    assert_eq!(
        error.to_string(),
        "a session file of format version 7; this program reads version 1"
    );
}

proptest! {
    /// Whatever follows a valid beginning: no panic, the beginning is read, and all bytes are accounted for.
    #[test]
    fn any_bytes_are_read_without_panic(
        keep in 0_usize..250,
        noise in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let (file, boundaries) = small_file();
        let keep = keep.min(file.len());
        let mut bytes = file[..keep].to_vec();
        bytes.extend_from_slice(&noise);
        if let Ok(reading) = read(&bytes) {
            let complete = boundaries.iter().filter(|&&boundary| boundary <= keep).count().saturating_sub(1);
            prop_assert!(reading.frames.len() >= complete);
            let end = reading
                .frames
                .last()
                .map_or(PRELUDE_LENGTH, |frame| frame.offset + HEADER_LENGTH + frame.payload.len());
            match reading.ending {
                Ending::Clean | Ending::Open => prop_assert_eq!(end, bytes.len()),
                Ending::Torn { offset, bytes_lost, .. } | Ending::Damaged { offset, bytes_lost, .. } => {
                    prop_assert_eq!(offset, end);
                    prop_assert_eq!(offset + bytes_lost, bytes.len());
                }
            }
        } else {
            prop_assert!(keep < PRELUDE_LENGTH);
        }
    }
}
