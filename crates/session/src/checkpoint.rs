//! The file of a checkpoint: one payload behind a digest that covers every byte of it.

use std::error::Error;
use std::fmt;

/// The first bytes of every checkpoint file.
pub const CHECKPOINT_MAGIC: &[u8; 20] = b"MicroSim checkpoint\n";

/// The version of the format that is written, and the only one that is read. Version 1 was a bare payload; 2 had no digests of
/// the states.
pub const CHECKPOINT_VERSION: u32 = 3;

/// Bytes before the payload: magic line, version, digest.
const PRELUDE: usize = CHECKPOINT_MAGIC.len() + 4 + 32;

/// Why bytes are not a checkpoint that can be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotACheckpoint {
    /// They begin with something else.
    Magic,
    /// They have this format version, which is not [`CHECKPOINT_VERSION`].
    Version(u32),
    /// They end before the payload begins.
    TooShort(usize),
    /// The digest does not fit: a byte is wrong, missing or too many.
    Digest,
}

/// The bytes of a checkpoint file: [`CHECKPOINT_MAGIC`], [`CHECKPOINT_VERSION`] (u32, little-endian), the BLAKE3 digest of the payload,
/// the payload.
pub fn write_checkpoint(payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(PRELUDE + payload.len());
    bytes.extend_from_slice(CHECKPOINT_MAGIC);
    bytes.extend_from_slice(&CHECKPOINT_VERSION.to_le_bytes());
    bytes.extend_from_slice(blake3::hash(payload).as_bytes());
    bytes.extend_from_slice(payload);
    bytes
}

/// The payload of a checkpoint file.
///
/// # Errors
/// [`NotACheckpoint`] unless every byte is as it was written.
pub fn read_checkpoint(bytes: &[u8]) -> Result<&[u8], NotACheckpoint> {
    let Some(rest) = bytes.strip_prefix(CHECKPOINT_MAGIC) else {
        return Err(NotACheckpoint::Magic);
    };
    let short = NotACheckpoint::TooShort(bytes.len());
    let Some((version, rest)) = rest.split_first_chunk() else {
        return Err(short);
    };
    let version = u32::from_le_bytes(*version);
    if version != CHECKPOINT_VERSION {
        return Err(NotACheckpoint::Version(version));
    }
    let Some((digest, payload)) = rest.split_first_chunk::<32>() else {
        return Err(short);
    };
    match blake3::hash(payload).as_bytes() == digest {
        true => Ok(payload),
        false => Err(NotACheckpoint::Digest),
    }
}

impl fmt::Display for NotACheckpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => write!(
                f,
                "not a checkpoint of this version: it does not begin with the line \"MicroSim checkpoint\""
            ),
            Self::Version(version) => write!(
                f,
                "a checkpoint of format version {version}; this program reads version {CHECKPOINT_VERSION}"
            ),
            Self::TooShort(length) => {
                write!(f, "it has {length} bytes and ends before its content")
            }
            Self::Digest => write!(
                f,
                "it is damaged: its content does not have the digest that stands before it"
            ),
        }
    }
}

impl Error for NotACheckpoint {}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every single bit, every cut, and a byte too many.
    #[test]
    fn whatever_is_wrong_is_refused() {
        let payload = b"the state of a run".as_slice();
        let bytes = write_checkpoint(payload);
        assert_eq!(read_checkpoint(&bytes), Ok(payload));
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let refused = read_checkpoint(&flipped).expect_err("refused");
            let expected = match bit / 8 {
                0..20 => refused == NotACheckpoint::Magic,
                20..24 => matches!(refused, NotACheckpoint::Version(_)),
                _ => refused == NotACheckpoint::Digest,
            };
            assert!(expected, "bit {bit}: {refused:?}");
        }
        for cut in 0..bytes.len() {
            assert!(read_checkpoint(&bytes[..cut]).is_err(), "cut at {cut}");
        }
        let longer = [&bytes[..], b"x"].concat();
        assert_eq!(read_checkpoint(&longer), Err(NotACheckpoint::Digest));
    }
}
