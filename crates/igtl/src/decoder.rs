//! Messages from a stream of bytes.

use crate::body::{self, BodyError};
use crate::header::{CHECKSUM, HEADER, Header, Timestamp, VERSIONS};
use crate::message::{Kind, Message};
use crc::{Digest, Table};
use std::fmt;

/// Longest body of a type that this crate decodes: 14,000 tools.
const LONGEST: u64 = 1 << 20;
/// Longest body that is skipped: images are of some megabytes.
const LONGEST_SKIPPED: u64 = 1 << 28;

/// A message with its header.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// Version of the header: a peer that sends 2 can be sent 2.
    pub version: u16,
    /// Name of the type.
    pub kind: String,
    /// Name of the device.
    pub device: String,
    /// When it was measured, by the sender's clock.
    pub time: Timestamp,
    /// `Ok(None)` of a type that this crate does not know.
    pub message: Result<Option<Message>, BodyError>,
}

/// Why nothing more can be read from a stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// Version of a header.
    Version(u16),
    /// Type and length of a body, and how long it may be.
    TooLong(String, u64, u64),
    /// Type of a message whose body is not what was sent.
    Checksum(String),
    /// Type of a message whose extended header does not fit its body.
    ExtendedHeader(String),
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version(found) => write!(
                f,
                "expected a header of version {} to {}, found {found}: this is not OpenIGTLink, or bytes were lost",
                VERSIONS.start(),
                VERSIONS.end()
            ),
            Self::TooLong(kind, found, longest) => write!(
                f,
                "{kind}: expected a body of at most {longest} bytes, found {found}"
            ),
            Self::Checksum(kind) => write!(f, "{kind}: the checksum is not that of the body"),
            Self::ExtendedHeader(kind) => write!(
                f,
                "{kind}: expected an extended header of at least 12 bytes that fits the body"
            ),
        }
    }
}

impl std::error::Error for DecodeError {}

/// Takes the bytes of a stream in pieces of any length, and gives its messages. After an error it gives the same error for ever.
#[derive(Default)]
pub struct Decoder {
    /// Bytes that are not decoded yet, from `start` on.
    bytes: Vec<u8>,
    start: usize,
    /// The body that is skipped at present.
    skipped: Option<Skipped>,
    error: Option<DecodeError>,
}

struct Skipped {
    header: Header,
    left: u64,
    checksum: Digest<'static, u64, Table<16>>,
}

impl fmt::Debug for Decoder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let waiting = self.bytes.len() - self.start;
        f.debug_struct("Decoder")
            .field("waiting", &waiting)
            .field("error", &self.error)
            .finish_non_exhaustive()
    }
}

impl Decoder {
    /// At the start of a stream.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds bytes that have come.
    pub fn push(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.start);
        self.start = 0;
        self.bytes.extend_from_slice(bytes);
    }

    /// The next message that is there as a whole.
    ///
    /// # Errors
    /// If nothing more can be read from this stream.
    pub fn next_message(&mut self) -> Result<Option<Received>, DecodeError> {
        if let Some(error) = &self.error {
            return Err(error.clone());
        }
        let message = self.decode();
        if let Err(error) = &message {
            self.error = Some(error.clone());
        }
        message
    }

    fn decode(&mut self) -> Result<Option<Received>, DecodeError> {
        if self.skipped.is_some() {
            return self.skip();
        }
        let Some((header, rest)) = self.bytes[self.start..].split_first_chunk::<HEADER>() else {
            return Ok(None);
        };
        let header = Header::read(header);
        if !VERSIONS.contains(&header.version) {
            return Err(DecodeError::Version(header.version));
        }
        let kind = Kind::of(&header.kind);
        let longest = match kind {
            Some(_) => LONGEST,
            None => LONGEST_SKIPPED,
        };
        if header.length > longest {
            let Header { kind, length, .. } = header;
            return Err(DecodeError::TooLong(kind, length, longest));
        }
        let Some(kind) = kind else {
            self.start += HEADER;
            self.skipped = Some(Skipped {
                left: header.length,
                header,
                checksum: CHECKSUM.digest(),
            });
            return self.skip();
        };
        // At most LONGEST.
        let length = header.length as usize;
        let Some(body) = rest.get(..length) else {
            return Ok(None);
        };
        if CHECKSUM.checksum(body) != header.checksum {
            return Err(DecodeError::Checksum(header.kind));
        }
        let content = match header.version {
            1 => Some(body),
            _ => content(body),
        };
        let Some(content) = content else {
            return Err(DecodeError::ExtendedHeader(header.kind));
        };
        let message = body::decode(&kind, &header.kind, content).map(Some);
        self.start += HEADER + length;
        Ok(Some(received(header, message)))
    }

    /// Goes on with a body that is skipped.
    fn skip(&mut self) -> Result<Option<Received>, DecodeError> {
        let Some(skipped) = &mut self.skipped else {
            return Ok(None);
        };
        let waiting = &self.bytes[self.start..];
        let count =
            usize::try_from(skipped.left).map_or(waiting.len(), |left| left.min(waiting.len()));
        skipped.checksum.update(&waiting[..count]);
        skipped.left -= count as u64;
        self.start += count;
        match self.skipped.take() {
            Some(Skipped {
                header,
                left: 0,
                checksum,
            }) => match checksum.finalize() == header.checksum {
                true => Ok(Some(received(header, Ok(None)))),
                false => Err(DecodeError::Checksum(header.kind)),
            },
            more => {
                self.skipped = more;
                Ok(None)
            }
        }
    }
}

fn received(header: Header, message: Result<Option<Message>, BodyError>) -> Received {
    Received {
        version: header.version,
        kind: header.kind,
        device: header.device,
        time: header.time,
        message,
    }
}

/// What lies between the extended header and the metadata.
fn content(body: &[u8]) -> Option<&[u8]> {
    let (&[a, b, c, d, e, f, g, h], _) = body.split_first_chunk()?;
    let own = usize::from(u16::from_be_bytes([a, b]));
    let index = u64::from(u16::from_be_bytes([c, d]));
    let metadata = u64::from(u32::from_be_bytes([e, f, g, h])) + index;
    let end = body.len().checked_sub(usize::try_from(metadata).ok()?)?;
    (own >= 12).then(|| body.get(own..end))?
}
