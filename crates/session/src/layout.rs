//! The fixed numbers of the file format, which the root of the crate documents.

/// The first bytes of every session file.
pub const MAGIC: &[u8; 17] = b"MicroSim session\n";

/// The version of the format that is written, and the only one that is read.
pub const FORMAT_VERSION: u32 = 1;

/// Kind of the frame that closes a complete file. Nothing may follow it.
pub const KIND_END: u8 = 0;

/// Largest payload of one frame `[byte]`. Larger ones are refused when writing and are damage when reading.
pub const MAX_PAYLOAD: usize = 1 << 26;

/// Bytes before the first frame.
pub(crate) const PRELUDE_LENGTH: usize = MAGIC.len() + 4;

/// Bytes of a frame before its payload.
pub(crate) const HEADER_LENGTH: usize = 29;

/// Bytes of a frame's header that its own checksum covers.
pub(crate) const HEADER_CHECKED: usize = HEADER_LENGTH - 4;
