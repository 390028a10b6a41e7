//! OpenIGTLink, the protocol by which trackers send where instruments are: bytes in, messages out, and back.
//!
//! [`Decoder`] takes bytes in pieces of any length and gives a [`Received`] for each message; [`encode`] makes the bytes of one. All that a
//! tracker of instruments sends or is sent is a [`Message`]: TRANSFORM, POSITION, TDATA, QTDATA with STT, STP and RTS, STRING, STATUS, CAPABILITY and the queries
//! GET. Messages of other types are named and skipped. [`Matrix::pose`] and [`Position::pose`] are what the simulator works with: metres and unit quaternions.
//!
//! Not here: sockets, clocks, and whom to answer with what (the input plug-in); images, points, and the metadata of version 2, which are skipped.
//!
//! # Format
//! All numbers are big-endian (protocol specification, openigtlink.org). A header of 58 bytes, then the body:
//!
//! | offset | size | what |
//! |---|---|---|
//! | 0 | 2 | version of the header: 1, 2 or 3 |
//! | 2 | 12 | type, filled with NUL |
//! | 14 | 20 | name of the device, filled with NUL |
//! | 34 | 8 | time: seconds since 1970 UTC, and 2⁻³² s ([`Timestamp`]); 0 is none |
//! | 42 | 8 | length of the body |
//! | 50 | 8 | CRC-64/ECMA-182 of the body |
//!
//! From version 2 on the body begins with an extended header of at least 12 bytes (its length 2, length of the metadata's header 2, of the metadata 4, number of the message 4) and
//! ends with the metadata; between them is the content, which is the whole body in version 1.
//!
//! # Rationale
//! Tolerant in reading: names may fill their field or end in blanks, texts may lack their NUL, a body that does not fit its type costs that message alone. A wrong version, a wrong checksum and
//! a body that is too long end the connection ([`DecodeError`]), as nothing behind them can be found again. Strict in writing: a name that is too long is an
//! error, not cut.
//!
//! The crate `openigtlink-rust` 0.4.1 was tried first: its TDATA has the matrix by rows, where the C++ library and the specification have it by columns, so that a turned tool of a real peer comes
//! out elsewhere; it takes as much memory as a header asks for, and brings TLS and an asynchronous runtime.

#![forbid(unsafe_code)]

mod body;
mod decoder;
mod encode;
mod header;
mod message;
mod pose;

pub use body::BodyError;
pub use decoder::{DecodeError, Decoder, Received};
pub use encode::{EncodeError, encode};
pub use header::Timestamp;
pub use message::{Kind, Matrix, Message, Position, Start, Status, Stream, Text, Tracked};
pub use pose::{NotRigid, Pose};
