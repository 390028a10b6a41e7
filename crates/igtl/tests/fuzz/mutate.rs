//! Mutations of real frames, and what has to hold for whatever the decoder is given: `tests/mutated.rs` runs a sample of them, `tests/examples/soak_igtl.rs` of the workspace as many as there is
//! time for.

use microsim_igtl::{Decoder, Message, Timestamp, encode};

/// Frames of the C++ library and of pyigtl, as `tests/peers` has them.
const CORPUS: [&str; 2] = [
    include_str!("../peers/openigtlink-1.11.txt"),
    include_str!("../peers/pyigtl-0.3.txt"),
];
/// Length of a header; the body's length and checksum are its last 16 bytes.
const HEADER: usize = 58;
/// Polynomial of the checksum (DOMAIN 3).
const POLYNOMIAL: u64 = 0x42F0_E1EB_A9EA_3693;
/// Most bytes of one stream.
const MOST_BYTES: usize = 1 << 16;

/// Numbers that look random (Steele, Lea & Flood 2014: SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `end`, which is not 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

/// The frames of the corpus.
pub fn corpus() -> Vec<Vec<u8>> {
    let lines = CORPUS.iter().flat_map(|text| text.lines());
    let frames = lines.filter_map(|line| line.split_whitespace().nth(1));
    let byte = |pair: &[u8]| {
        let digits = std::str::from_utf8(pair).expect("digits");
        u8::from_str_radix(digits, 16).expect("hexadecimal")
    };
    frames
        .map(|frame| frame.as_bytes().chunks(2).map(byte).collect())
        .collect()
}

fn checksum(body: &[u8]) -> u64 {
    let mut sum = 0_u64;
    for byte in body {
        sum ^= u64::from(*byte) << 56;
        for _ in 0..8 {
            sum = (sum << 1) ^ if sum >> 63 == 1 { POLYNOMIAL } else { 0 };
        }
    }
    sum
}

/// Makes length and checksum those of the body, so that what is inside is reached.
fn repair(frame: &mut [u8]) {
    if let Some((header, body)) = frame.split_at_mut_checked(HEADER) {
        header[42..50].copy_from_slice(&(body.len() as u64).to_be_bytes());
        header[50..58].copy_from_slice(&checksum(body).to_be_bytes());
    }
}

/// Numbers at the ends of ranges.
const EDGES: [u64; 8] = [0, 1, 0x7F, 0x80, 0xFFFF, 0x7FFF_FFFF, 0xFFFF_FFFF, u64::MAX];

fn mutate(frame: &mut Vec<u8>, other: &[u8], numbers: &mut Numbers) {
    for _ in 0..=numbers.below(4) {
        if frame.is_empty() {
            return;
        }
        let at = numbers.below(frame.len());
        match numbers.below(8) {
            0 => frame[at] ^= 1 << numbers.below(8),
            1 => frame[at] = numbers.next() as u8,
            2 => frame.truncate(at),
            3 => frame.insert(at, numbers.next() as u8),
            4 => {
                let from = numbers.below(other.len());
                frame.truncate(at);
                frame.extend_from_slice(&other[from..]);
            }
            5 => {
                let bytes = EDGES[numbers.below(EDGES.len())].to_be_bytes();
                let width = 1 << numbers.below(4);
                for (to, from) in frame[at..].iter_mut().zip(&bytes[8 - width..]) {
                    *to = *from;
                }
            }
            6 => {
                let end = (at + 1 + numbers.below(70)).min(frame.len());
                let part = frame[at..end].to_vec();
                frame.splice(at..at, part);
            }
            _ => {
                let end = (at + 1 + numbers.below(40)).min(frame.len());
                frame.drain(at..end);
            }
        }
    }
}

/// A stream of mutated frames: some as they are, some with right lengths and checksums.
pub fn stream(corpus: &[Vec<u8>], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = Vec::new();
    for _ in 0..=numbers.below(4) {
        let mut frame = corpus[numbers.below(corpus.len())].clone();
        let other = &corpus[numbers.below(corpus.len())];
        if numbers.below(4) > 0 {
            mutate(&mut frame, other, numbers);
        }
        if numbers.below(2) == 0 {
            repair(&mut frame);
        }
        bytes.extend(frame);
    }
    bytes.truncate(MOST_BYTES);
    bytes
}

/// How many messages a stream had, and whether it ended in an error. Whoever sends what: no panic; the same in pieces of any length; what is decoded and can be encoded comes
/// back as it was.
///
/// # Panics
/// If one of these does not hold.
pub fn check(bytes: &[u8], numbers: &mut Numbers) -> (usize, bool) {
    let whole = decoded(bytes, |_| bytes.len().max(1));
    let pieces = decoded(bytes, |_| 1 + numbers.below(100));
    assert_eq!(whole, pieces, "the same stream in pieces");
    let Comparable((messages, failed)) = whole;
    let mut count = 0;
    for (device, message) in messages
        .iter()
        .filter_map(|(device, message)| Some((device, message.as_ref()?)))
    {
        count += 1;
        places(message);
        for version in [1, 2] {
            // Names that are no UTF-8 were replaced, and may be longer then.
            let Ok(again) = encode(version, device, Timestamp(7), message) else {
                continue;
            };
            let Comparable((back, failed)) = decoded(&again, |_| again.len());
            assert!(!failed, "what was encoded cannot be read: {message:?}");
            let [(_, Some(back))] = &back[..] else {
                panic!("{message:?} came back as {back:?}");
            };
            assert_eq!(format!("{back:?}"), format!("{message:?}"));
        }
    }
    (count, failed)
}

/// Poses of numbers of any kind are finite, or none.
fn places(message: &Message) {
    let poses: Vec<_> = match message {
        Message::Transform(matrix) => vec![matrix.pose()],
        Message::Position(position) => vec![position.pose()],
        Message::Matrices(tools) => tools.iter().map(|tool| tool.place.pose()).collect(),
        Message::Quaternions(tools) => tools.iter().map(|tool| tool.place.pose()).collect(),
        _ => Vec::new(),
    };
    for pose in poses.into_iter().flatten() {
        assert!(pose.position.iter().all(|x| x.is_finite()), "{pose:?}");
        assert!((pose.orientation.norm() - 1.0).abs() < 1e-6, "{pose:?}");
    }
}

type Decoded = (Vec<(String, Option<Message>)>, bool);

fn decoded(bytes: &[u8], mut piece: impl FnMut(usize) -> usize) -> Comparable {
    let mut decoder = Decoder::new();
    let mut found: Decoded = (Vec::new(), false);
    let mut at = 0;
    loop {
        loop {
            match decoder.next_message() {
                Ok(Some(received)) => {
                    // A body that is none of its type costs its message alone.
                    found
                        .0
                        .push((received.device, received.message.ok().flatten()));
                }
                Ok(None) => break,
                Err(_) => {
                    found.1 = true;
                    return Comparable(found);
                }
            }
        }
        if at == bytes.len() {
            return Comparable(found);
        }
        let end = (at + piece(at)).min(bytes.len());
        decoder.push(&bytes[at..end]);
        at = end;
    }
}

/// Numbers that are none are compared as text.
struct Comparable(Decoded);

impl PartialEq for Comparable {
    fn eq(&self, other: &Self) -> bool {
        format!("{:?}", self.0) == format!("{:?}", other.0)
    }
}

impl std::fmt::Debug for Comparable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}
