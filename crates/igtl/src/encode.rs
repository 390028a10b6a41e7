//! The bytes of a message.

use crate::body::COORDINATES;
use crate::header::{CHECKSUM, Header, KIND, NAME, Timestamp, write_name};
use crate::message::{Matrix, Message, Position, Tracked};
use std::fmt;

/// What does not fit into a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// A name, and the bytes that there are for it.
    Name(String, usize),
    /// A text of more than 65,535 bytes: how many.
    Text(usize),
    /// A version of the header that is not 1 or 2.
    Version(u16),
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name, most) => {
                write!(f, "\"{name}\": expected at most {most} bytes without NUL")
            }
            Self::Text(found) => write!(f, "expected a text of at most 65535 bytes, found {found}"),
            Self::Version(found) => {
                write!(f, "expected version 1 or 2 of the header, found {found}")
            }
        }
    }
}

impl std::error::Error for EncodeError {}

/// The bytes of a message from a device, to be sent in one piece: there are peers that end the connection where a header comes in two.
///
/// `version` is that of the header: 2 only to a peer that has sent 2, as older ones lose the place of the next message for good.
///
/// # Errors
/// If a name or text is too long for its field.
pub fn encode(
    version: u16,
    device: &str,
    time: Timestamp,
    message: &Message,
) -> Result<Vec<u8>, EncodeError> {
    let kind = message.kind();
    fits::<KIND>(&kind)?;
    fits::<NAME>(device)?;
    let content = content(message)?;
    let body = match version {
        1 => content,
        // Of 12 bytes; the metadata has a header, which counts no entries.
        2 => [
            &[0, 12, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0],
            &content[..],
            &[0, 0],
        ]
        .concat(),
        other => return Err(EncodeError::Version(other)),
    };
    let header = Header {
        version,
        kind,
        device: device.to_owned(),
        time,
        length: body.len() as u64,
        checksum: CHECKSUM.checksum(&body),
    };
    let mut bytes = header.write();
    bytes.extend(body);
    Ok(bytes)
}

fn fits<const N: usize>(name: &str) -> Result<(), EncodeError> {
    match name.len() <= N && !name.contains('\0') {
        true => Ok(()),
        false => Err(EncodeError::Name(name.to_owned(), N)),
    }
}

fn content(message: &Message) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = Vec::new();
    match message {
        Message::Transform(matrix) => put_matrix(matrix, &mut bytes),
        Message::Position(position) => put_position(position, &mut bytes),
        Message::Matrices(tools) => put_tools(tools, put_matrix, &mut bytes)?,
        Message::Quaternions(tools) => put_tools(tools, put_with_quaternion, &mut bytes)?,
        Message::Start(_, start) => {
            fits::<COORDINATES>(&start.coordinates)?;
            bytes.extend(start.interval.to_be_bytes());
            write_name::<COORDINATES>(&start.coordinates, &mut bytes);
        }
        Message::Stop(_) | Message::Get(_) => {}
        Message::Started(_, begins) => bytes.push(u8::from(!begins)),
        Message::Text(text) => {
            let length = u16::try_from(text.bytes.len());
            let length = length.map_err(|_| EncodeError::Text(text.bytes.len()))?;
            bytes.extend(text.encoding.to_be_bytes());
            bytes.extend(length.to_be_bytes());
            bytes.extend(&text.bytes);
        }
        Message::Status(status) => {
            fits::<NAME>(&status.name)?;
            bytes.extend(status.code.to_be_bytes());
            bytes.extend(status.subcode.to_be_bytes());
            write_name::<NAME>(&status.name, &mut bytes);
            bytes.extend(status.text.as_bytes());
            bytes.push(0);
        }
        Message::Capability(kinds) => {
            for kind in kinds {
                fits::<KIND>(kind)?;
                write_name::<KIND>(kind, &mut bytes);
            }
        }
    }
    Ok(bytes)
}

fn put_floats(numbers: &[f32], bytes: &mut Vec<u8>) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
}

fn put_matrix(matrix: &Matrix, bytes: &mut Vec<u8>) {
    put_floats(matrix.axes.as_flattened(), bytes);
    put_floats(&matrix.translation, bytes);
}

fn put_position(position: &Position, bytes: &mut Vec<u8>) {
    put_floats(&position.position, bytes);
    put_floats(position.orientation.as_ref().map_or(&[], |all| all), bytes);
}

/// In QTDATA there is a quaternion always: none is no turn.
fn put_with_quaternion(position: &Position, bytes: &mut Vec<u8>) {
    put_floats(&position.position, bytes);
    put_floats(&position.orientation.unwrap_or([0.0, 0.0, 0.0, 1.0]), bytes);
}

fn put_tools<Place>(
    tools: &[Tracked<Place>],
    put: fn(&Place, &mut Vec<u8>),
    bytes: &mut Vec<u8>,
) -> Result<(), EncodeError> {
    for tool in tools {
        fits::<NAME>(&tool.name)?;
        write_name::<NAME>(&tool.name, bytes);
        bytes.extend([tool.kind, 0]);
        put(&tool.place, bytes);
    }
    Ok(())
}
