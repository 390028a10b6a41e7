//! A message as bytes behind a header, so that unknown kinds are skipped, copied and recorded safely.
//!
//! Layout, little-endian: kind id `u64` | simulated time `u64` \[ns\] | payload size `u32` | version `u16` |
//! sender `u16` | payload. Frames follow one another without padding.

use std::fmt;

/// Bytes of a header.
pub const HEADER_SIZE: usize = 24;
/// Largest payload: more than the largest record of a session, so that it is the recorder who reports that one is too
/// large. Larger states travel as blocks.
pub const MAX_PAYLOAD: usize = 1 << 27;

/// What stands before each payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Id of the message kind ([`crate::kind_id`]).
    pub kind: u64,
    /// Simulated time of the publication \[ns\]; stamped by the router.
    pub time_ns: u64,
    /// Payload size in bytes.
    pub size: u32,
    /// Version of the payload.
    pub version: u16,
    /// Endpoint that published it; stamped by the router.
    pub sender: u16,
}

/// One message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// What stands before the payload.
    pub header: Header,
    /// The message itself.
    pub payload: &'a [u8],
}

/// Bytes that are not a sequence of frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameError {
    /// Where the bad frame starts.
    pub offset: usize,
    /// What is wrong with it.
    pub what: String,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "bad message frame at byte {}: {}",
            self.offset, self.what
        )
    }
}

impl std::error::Error for FrameError {}

/// Appends one frame to `out`; time and sender are stamped by the router.
pub fn push_frame(out: &mut Vec<u8>, kind: u64, version: u16, payload: &[u8]) {
    push_stamped(
        out,
        &Header {
            kind,
            time_ns: 0,
            size: payload.len() as u32,
            version,
            sender: 0,
        },
        payload,
    );
}

/// Appends one frame whose header is complete.
pub fn push_stamped(out: &mut Vec<u8>, header: &Header, payload: &[u8]) {
    out.extend_from_slice(&header.kind.to_le_bytes());
    out.extend_from_slice(&header.time_ns.to_le_bytes());
    out.extend_from_slice(&(payload.len() as u32).to_le_bytes());
    out.extend_from_slice(&header.version.to_le_bytes());
    out.extend_from_slice(&header.sender.to_le_bytes());
    out.extend_from_slice(payload);
}

/// Walks over frames; after an error it ends.
#[derive(Clone, Debug)]
pub struct Frames<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> Frames<'a> {
    /// The frames of `bytes`.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, offset: 0 }
    }
}

impl<'a> Iterator for Frames<'a> {
    type Item = Result<Frame<'a>, FrameError>;

    fn next(&mut self) -> Option<Self::Item> {
        let rest = &self.bytes[self.offset..];
        if rest.is_empty() {
            return None;
        }
        let fail = |this: &mut Self, what: String| {
            let offset = this.offset;
            this.offset = this.bytes.len();
            Some(Err(FrameError { offset, what }))
        };
        if rest.len() < HEADER_SIZE {
            return fail(
                self,
                format!("{} bytes left, a header has {HEADER_SIZE}", rest.len()),
            );
        }
        let u64_at = |at: usize| u64::from_le_bytes(rest[at..at + 8].try_into().expect("8 bytes"));
        let u16_at = |at: usize| u16::from_le_bytes([rest[at], rest[at + 1]]);
        let size = u32::from_le_bytes(rest[16..20].try_into().expect("4 bytes"));
        let header = Header {
            kind: u64_at(0),
            time_ns: u64_at(8),
            size,
            version: u16_at(20),
            sender: u16_at(22),
        };
        let end = HEADER_SIZE + size as usize;
        if size as usize > MAX_PAYLOAD {
            return fail(
                self,
                format!("payload of {size} bytes, at most {MAX_PAYLOAD} are allowed"),
            );
        }
        if rest.len() < end {
            return fail(
                self,
                format!(
                    "payload of {size} bytes announced, {} there",
                    rest.len() - HEADER_SIZE
                ),
            );
        }
        self.offset += end;
        Some(Ok(Frame {
            header,
            payload: &rest[HEADER_SIZE..end],
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_cut_frame_is_an_error_at_its_place() {
        let mut bytes = Vec::new();
        push_frame(&mut bytes, 7, 1, b"first");
        let second = bytes.len();
        push_frame(&mut bytes, 8, 2, b"second");
        for cut in second + 1..bytes.len() {
            let read: Vec<_> = Frames::new(&bytes[..cut]).collect();
            assert_eq!(read[0].as_ref().unwrap().payload, b"first");
            assert_eq!(read[1].as_ref().unwrap_err().offset, second, "cut at {cut}");
            assert_eq!(read.len(), 2);
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_safe(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = Frames::new(&bytes).count();
        }

        #[test]
        fn frames_come_back(payloads in proptest::collection::vec(
            (any::<u64>(), any::<u16>(), proptest::collection::vec(any::<u8>(), 0..50)), 0..20)) {
            let mut bytes = Vec::new();
            for (kind, version, payload) in &payloads {
                push_frame(&mut bytes, *kind, *version, payload);
            }
            let back: Vec<_> = Frames::new(&bytes)
                .map(|f| f.unwrap())
                .map(|f| (f.header.kind, f.header.version, f.payload.to_vec()))
                .collect();
            prop_assert_eq!(back, payloads);
        }
    }
}
