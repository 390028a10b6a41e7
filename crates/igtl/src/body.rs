//! The body of a message, decoded.

use crate::header::{KIND, NAME, read_name};
use crate::message::{Kind, Matrix, Message, Position, Start, Status, Stream, Text, Tracked};
use std::fmt;

/// A body that is none of its type; the connection goes on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BodyError {
    /// Name of the type.
    pub kind: String,
    /// What its body is.
    pub expected: &'static str,
    /// Bytes that there were.
    pub found: usize,
}

impl fmt::Display for BodyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            kind,
            expected,
            found,
        } = self;
        write!(f, "{kind}: expected {expected}, found {found} bytes")
    }
}

impl std::error::Error for BodyError {}

/// Length of a tool in TDATA: name, kind, a byte of nothing, matrix.
const TOOL_MATRIX: usize = NAME + 2 + 48;
/// The same in QTDATA.
const TOOL_QUATERNION: usize = NAME + 2 + 28;
/// Of the name of a coordinate system.
pub(crate) const COORDINATES: usize = 32;

/// What is in the content of a message of this type.
pub(crate) fn decode(kind: &Kind, name: &str, content: &[u8]) -> Result<Message, BodyError> {
    let wrong = |expected| BodyError {
        kind: name.to_owned(),
        expected,
        found: content.len(),
    };
    Ok(match kind {
        Kind::Transform => {
            let bytes = content.try_into();
            Message::Transform(matrix(bytes.map_err(|_| wrong("48 bytes"))?))
        }
        Kind::Position => {
            let position = position(content);
            Message::Position(position.ok_or_else(|| wrong("12, 24 or 28 bytes"))?)
        }
        Kind::Tracked(Stream::Matrices) => {
            let (tools, []) = content.as_chunks::<TOOL_MATRIX>() else {
                return Err(wrong("70 bytes for each tool"));
            };
            Message::Matrices(tools.iter().map(|tool| tracked(tool, matrix)).collect())
        }
        Kind::Tracked(Stream::Quaternions) => {
            let (tools, []) = content.as_chunks::<TOOL_QUATERNION>() else {
                return Err(wrong("50 bytes for each tool"));
            };
            let tools = tools.iter().map(|tool| tracked(tool, with_quaternion));
            Message::Quaternions(tools.collect())
        }
        Kind::Start(stream) => {
            let (interval, rest) = content.split_first_chunk().unwrap_or((&[0; 4], &[]));
            if rest.len() != COORDINATES {
                return Err(wrong("36 bytes"));
            }
            let start = Start {
                interval: u32::from_be_bytes(*interval),
                coordinates: read_name(rest),
            };
            Message::Start(*stream, start)
        }
        Kind::Stop(stream) => Message::Stop(*stream),
        Kind::Started(stream) => {
            let status = content.first().ok_or_else(|| wrong("a byte"))?;
            Message::Started(*stream, *status == 0)
        }
        Kind::Get(what) => Message::Get(what.clone()),
        Kind::Text => {
            let text = text(content);
            Message::Text(text.ok_or_else(|| wrong("4 bytes and as many as they say"))?)
        }
        Kind::Status => {
            let status = status(content);
            Message::Status(status.ok_or_else(|| wrong("30 bytes and a text"))?)
        }
        Kind::Capability => {
            let (names, []) = content.as_chunks::<KIND>() else {
                return Err(wrong("12 bytes for each type"));
            };
            Message::Capability(names.iter().map(|name| read_name(name)).collect())
        }
    })
}

fn floats<const N: usize>(bytes: &[u8]) -> [f32; N] {
    let (fours, _) = bytes.as_chunks();
    std::array::from_fn(|at| f32::from_be_bytes(fours[at]))
}

fn matrix(bytes: &[u8; 48]) -> Matrix {
    let [x, y, z, translation] = [0, 12, 24, 36].map(|at| floats(&bytes[at..at + 12]));
    Matrix {
        axes: [x, y, z],
        translation,
    }
}

fn with_quaternion(bytes: &[u8; 28]) -> Position {
    Position {
        position: floats(&bytes[..12]),
        orientation: Some(floats(&bytes[12..])),
    }
}

/// In 24 bytes the fourth number of a unit quaternion is left out; it is not negative.
fn position(content: &[u8]) -> Option<Position> {
    if let Ok(bytes) = content.try_into() {
        return Some(with_quaternion(bytes));
    }
    let orientation = match content.len() {
        12 => None,
        24 => {
            let [x, y, z] = floats(&content[12..]);
            let square: f32 = x * x + y * y + z * z;
            Some([x, y, z, (1.0 - square).max(0.0).sqrt()])
        }
        _ => return None,
    };
    Some(Position {
        position: floats(&content[..12]),
        orientation,
    })
}

fn tracked<const N: usize, const M: usize, Place>(
    bytes: &[u8; N],
    place: fn(&[u8; M]) -> Place,
) -> Tracked<Place> {
    let (name, rest) = bytes.split_at(NAME);
    let mut own = [0; M];
    own.copy_from_slice(&rest[2..]);
    Tracked {
        name: read_name(name),
        kind: rest[0],
        place: place(&own),
    }
}

fn text(content: &[u8]) -> Option<Text> {
    let (&[a, b, c, d], rest) = content.split_first_chunk()?;
    Some(Text {
        encoding: u16::from_be_bytes([a, b]),
        bytes: rest.get(..u16::from_be_bytes([c, d]).into())?.to_vec(),
    })
}

fn status(content: &[u8]) -> Option<Status> {
    let (code, rest) = content.split_first_chunk()?;
    let (subcode, rest) = rest.split_first_chunk()?;
    let (name, text) = rest.split_at_checked(NAME)?;
    Some(Status {
        code: u16::from_be_bytes(*code),
        subcode: i64::from_be_bytes(*subcode),
        name: read_name(name),
        text: read_name(text),
    })
}
