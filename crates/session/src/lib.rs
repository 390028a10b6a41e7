//! The recording of a session: an append-only file of checksummed frames, and the digests that go into it.
//!
//! Here are the bytes of the file and nothing else: what a frame's payload means belongs to those who write it, and so
//! does opening files. [`Writer`] works on any `std::io::Write`, [`Reader`] on any `std::io::Read`, [`read`] on a slice of bytes.
//! [`History`] is what a station signs ([`StationKey`]), [`read_checkpoint`] the file of a checkpoint.
//!
//! # Format, version 1
//! All integers are little-endian. A file is a prelude and then frames, one behind the other, without padding.
//!
//! | prelude offset | size | what |
//! |---|---|---|
//! | 0 | 17 | [`MAGIC`]: the text `MicroSim session` and a line feed |
//! | 17 | 4 | [`FORMAT_VERSION`] |
//!
//! | frame offset | size | what |
//! |---|---|---|
//! | 0 | 4 | n, the length of the payload, at most [`MAX_PAYLOAD`] |
//! | 4 | 1 | kind; [`KIND_END`] closes the file, all others belong to the caller |
//! | 5 | 8 | sequence number: 0 for the first frame, then one more for each |
//! | 13 | 8 | tick |
//! | 21 | 4 | CRC-32 (IEEE 802.3) of the payload |
//! | 25 | 4 | CRC-32 of the 25 bytes before it |
//! | 29 | n | payload |
//!
//! # Rationale
//! The header has a checksum of its own, so that its length can be trusted before it is followed: a file that ends
//! inside a frame is then known to be *torn* (the process died while it wrote), and is never confused with a *damaged*
//! one, whose length field has a flipped bit. A CRC-32 notices every change of a single bit. The sequence number makes
//! a frame that is missing, repeated or in the wrong place visible, though its own checksums are right.
//!
//! Each frame is handed to the operating system in one piece. What it has accepted survives the end of the process,
//! `kill -9` included, so such an end costs at most the frame that was being written. A power failure may cost more:
//! who needs to outlive that calls `sync_data` on the file.

#![forbid(unsafe_code)]

mod checkpoint;
mod digest;
mod layout;
mod reader;
mod signature;
mod writer;

pub use checkpoint::{
    CHECKPOINT_MAGIC, CHECKPOINT_VERSION, NotACheckpoint, read_checkpoint, write_checkpoint,
};
pub use digest::{Chain, digest};
pub use layout::{FORMAT_VERSION, KIND_END, MAGIC, MAX_PAYLOAD};
pub use reader::{Damage, Ending, Frame, NotASession, Reader, Reading, read};
pub use signature::{History, SEAL_LENGTH, Seal, Station, StationKey};
pub use writer::Writer;
