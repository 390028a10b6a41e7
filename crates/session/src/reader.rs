//! Reading a session file: every complete frame, and how the file ends.

use std::error::Error;
use std::fmt;
use std::io::{self, Read};

use crate::layout::{
    FORMAT_VERSION, HEADER_CHECKED, HEADER_LENGTH, KIND_END, MAGIC, MAX_PAYLOAD, PRELUDE_LENGTH,
};

/// One complete frame, as it was appended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Where it begins in the file `[byte]`.
    pub offset: usize,
    /// What the payload is, in the caller's terms; [`KIND_END`] closes the file.
    pub kind: u8,
    /// Its number in the file, from 0.
    pub sequence: u64,
    /// The tick at which it was written.
    pub tick: u64,
    /// What was recorded.
    pub payload: &'a [u8],
}

/// What a session file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading<'a> {
    /// All frames before the end of the file, or before the first tear or damage, in the order of the file.
    pub frames: Vec<Frame<'a>>,
    /// How the file ends.
    pub ending: Ending,
}

/// How a session file ends. `after_tick` is the tick of the last frame before the place, `None` if there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// With a frame of kind [`KIND_END`]: the session is complete.
    Clean,
    /// Between two frames, without an end: the process was killed.
    Open,
    /// Inside a frame: the process was killed, or the disk was full, while it was written.
    Torn {
        /// Where the incomplete frame begins `[byte]`.
        offset: usize,
        /// See [`Ending`].
        after_tick: Option<u64>,
        /// Number of bytes of the incomplete frame.
        bytes_lost: usize,
    },
    /// With bytes that no writer has written like this. Nothing behind the place is read.
    Damaged {
        /// Where the damaged frame begins `[byte]`.
        offset: usize,
        /// See [`Ending`].
        after_tick: Option<u64>,
        /// Number of bytes from `offset` to the end of the file.
        bytes_lost: usize,
        /// What is wrong.
        what: Damage,
    },
}

/// What is wrong with a damaged frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// The checksum of its header does not fit.
    Header,
    /// The checksum of its payload does not fit.
    Payload,
    /// Its length exceeds [`MAX_PAYLOAD`].
    Length(u32),
    /// A frame is missing, repeated or in the wrong place.
    Sequence {
        /// The number that the frame should have.
        expected: u64,
        /// The number that it has.
        found: u64,
    },
    /// Bytes follow the frame that closes the file.
    BehindEnd,
}

/// Why bytes are not a session file at all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotASession {
    /// They end, after this many bytes, before the first frame could begin: nothing was recorded.
    TooShort(usize),
    /// They begin with something else.
    Magic,
    /// The file has this format version, which is not [`FORMAT_VERSION`].
    Version(u32),
    /// The operating system does not give its bytes, for this reason.
    Unreadable(String),
}

/// Reads a session file frame by frame: what is in memory is one frame, whatever the length of the file.
///
/// Stops at the first tear or damage. Whatever the bytes are, there is no panic, and memory is needed for one frame only, whose length its
/// checked header gives.
#[derive(Debug)]
pub struct Reader<R> {
    source: R,
    /// Where the next frame begins.
    offset: usize,
    /// The number that the next frame should have.
    expected: u64,
    /// Kind and tick of the last frame.
    last: Option<(u8, u64)>,
    ending: Option<Ending>,
    payload: Vec<u8>,
}

impl<R: Read> Reader<R> {
    /// Begins to read.
    ///
    /// # Errors
    /// [`NotASession`] if the prelude is missing, so that there is no frame to look for, or if it cannot be read.
    pub fn open(mut source: R) -> Result<Self, NotASession> {
        let mut prelude = [0; PRELUDE_LENGTH];
        let length = read_up_to(&mut source, &mut prelude)
            .map_err(|error| NotASession::Unreadable(error.to_string()))?;
        let (magic, rest) = prelude[..length].split_at(length.min(MAGIC.len()));
        if !MAGIC.starts_with(magic) {
            return Err(NotASession::Magic);
        }
        let Some((version, _)) = rest.split_first_chunk() else {
            return Err(NotASession::TooShort(length));
        };
        let version = u32::from_le_bytes(*version);
        if version != FORMAT_VERSION {
            return Err(NotASession::Version(version));
        }
        Ok(Self {
            source,
            offset: PRELUDE_LENGTH,
            expected: 0,
            last: None,
            ending: None,
            payload: Vec::new(),
        })
    }

    /// Goes on in a file of which this frame was read before: `source` stands at its first byte, `offset` bytes from the beginning.
    ///
    /// What stands before it is not looked at again.
    pub fn at(source: R, offset: usize, sequence: u64) -> Self {
        Self {
            source,
            offset,
            expected: sequence,
            last: None,
            ending: None,
            payload: Vec::new(),
        }
    }

    /// The source, wherever it stands.
    pub fn into_source(self) -> R {
        self.source
    }

    /// How the file ends; `None` until [`Reader::next_frame`] has come there.
    pub fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// The next complete frame; `None` at the end of the file, or at the first tear or damage.
    ///
    /// # Errors
    /// Those of the source.
    pub fn next_frame(&mut self) -> io::Result<Option<Frame<'_>>> {
        if self.ending.is_some() {
            return Ok(None);
        }
        let mut header = [0; HEADER_LENGTH];
        let found = read_up_to(&mut self.source, &mut header)?;
        let is_closed = self.last.is_some_and(|(kind, _)| kind == KIND_END);
        match (found, is_closed) {
            (0, true) => return Ok(self.end(Ending::Clean)),
            (0, false) => return Ok(self.end(Ending::Open)),
            (_, true) => return self.damaged(Damage::BehindEnd, found),
            (HEADER_LENGTH, false) => {}
            (_, false) => return Ok(self.torn(found)),
        }

        // The header, before anything in it is believed.
        if crc32fast::hash(&header[..HEADER_CHECKED])
            != u32::from_le_bytes(field(&header, HEADER_CHECKED))
        {
            return self.damaged(Damage::Header, found);
        }
        let length = u32::from_le_bytes(field(&header, 0));
        let kind = header[4];
        let sequence = u64::from_le_bytes(field(&header, 5));
        let tick = u64::from_le_bytes(field(&header, 13));
        let payload_checksum = u32::from_le_bytes(field(&header, 21));
        if sequence != self.expected {
            let what = Damage::Sequence {
                expected: self.expected,
                found: sequence,
            };
            return self.damaged(what, found);
        }
        if length as usize > MAX_PAYLOAD {
            return self.damaged(Damage::Length(length), found);
        }

        self.payload.clear();
        let mut limited = (&mut self.source).take(length.into());
        let found = found + limited.read_to_end(&mut self.payload)?;
        if self.payload.len() < length as usize {
            return Ok(self.torn(found));
        }
        if crc32fast::hash(&self.payload) != payload_checksum {
            return self.damaged(Damage::Payload, found);
        }
        let offset = self.offset;
        self.offset += found;
        self.expected += 1;
        self.last = Some((kind, tick));
        Ok(Some(Frame {
            offset,
            kind,
            sequence,
            tick,
            payload: &self.payload,
        }))
    }

    fn end<T>(&mut self, ending: Ending) -> Option<T> {
        self.ending = Some(ending);
        None
    }

    /// The file ends inside a frame, of which this many bytes are there.
    fn torn<T>(&mut self, bytes_lost: usize) -> Option<T> {
        let (offset, after_tick) = (self.offset, self.last.map(|(_, tick)| tick));
        self.end(Ending::Torn {
            offset,
            after_tick,
            bytes_lost,
        })
    }

    /// A damaged frame, of which this many bytes have been read; the rest of the file is only counted.
    fn damaged<T>(&mut self, what: Damage, found: usize) -> io::Result<Option<T>> {
        let behind = io::copy(&mut self.source, &mut io::sink())?;
        let (offset, after_tick) = (self.offset, self.last.map(|(_, tick)| tick));
        Ok(self.end(Ending::Damaged {
            offset,
            after_tick,
            bytes_lost: found + behind as usize,
            what,
        }))
    }
}

/// Fills `buffer` as far as the source has bytes; how many.
fn read_up_to(source: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match source.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// Reads all complete frames of a session file that is in memory, as a [`Reader`] does.
///
/// # Errors
/// [`NotASession`] if the prelude is missing, so that there is no frame to look for.
pub fn read(bytes: &[u8]) -> Result<Reading<'_>, NotASession> {
    let mut reader = Reader::open(bytes)?;
    let unreadable = |error: io::Error| NotASession::Unreadable(error.to_string());
    let mut frames = Vec::new();
    while let Some(frame) = reader.next_frame().map_err(unreadable)? {
        let begin = frame.offset + HEADER_LENGTH;
        frames.push(Frame {
            offset: frame.offset,
            kind: frame.kind,
            sequence: frame.sequence,
            tick: frame.tick,
            payload: &bytes[begin..begin + frame.payload.len()],
        });
    }
    let ending = reader.ending().unwrap_or(Ending::Open);
    Ok(Reading { frames, ending })
}

/// The `N` bytes of a header from a fixed offset on, which lies inside it for every caller above.
fn field<const N: usize>(header: &[u8; HEADER_LENGTH], offset: usize) -> [u8; N] {
    std::array::from_fn(|index| header[offset + index])
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Clean => write!(f, "the session is complete"),
            Self::Open => write!(f, "the session has no end: its process was killed"),
            Self::Torn {
                offset,
                after_tick,
                bytes_lost,
            } => {
                write!(
                    f,
                    "the session breaks off inside a frame at byte {offset}, "
                )?;
                write_place(f, after_tick)?;
                write!(f, ": {bytes_lost} bytes are incomplete")
            }
            Self::Damaged {
                offset,
                after_tick,
                bytes_lost,
                what,
            } => {
                write!(f, "the session is damaged at byte {offset}, ")?;
                write_place(f, after_tick)?;
                write!(f, ": {what}; {bytes_lost} bytes from there on are not read")
            }
        }
    }
}

fn write_place(f: &mut fmt::Formatter<'_>, after_tick: Option<u64>) -> fmt::Result {
    match after_tick {
        Some(tick) => write!(f, "after tick {tick}"),
        None => write!(f, "before its first frame"),
    }
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header => write!(f, "the checksum of a frame's header does not fit"),
            Self::Payload => write!(f, "the checksum of a frame's payload does not fit"),
            Self::Length(length) => {
                write!(
                    f,
                    "a frame claims {length} bytes, more than the {MAX_PAYLOAD} allowed"
                )
            }
            Self::Sequence { expected, found } => {
                write!(f, "expected frame number {expected}, found {found}")
            }
            Self::BehindEnd => write!(f, "bytes follow the end of the session"),
        }
    }
}

impl fmt::Display for NotASession {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort(length) => write!(
                f,
                "not a session file: it has {length} bytes and ends before its first frame, nothing was recorded"
            ),
            Self::Magic => write!(
                f,
                "not a session file: it does not begin with the line \"{}\"",
                String::from_utf8_lossy(MAGIC).trim_end()
            ),
            Self::Unreadable(reason) => f.write_str(reason),
            Self::Version(found) => write!(
                f,
                "a session file of format version {found}; this program reads version {FORMAT_VERSION}"
            ),
        }
    }
}

impl Error for NotASession {}

#[cfg(test)]
mod tests;
