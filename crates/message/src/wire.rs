//! A message and its wire form.

use microsim_bus::{Frame, KindInfo, kind_id};
use microsim_vocabulary::Overflow;
use serde::{Serialize, de::DeserializeOwned};
use std::fmt;

/// A typed message.
pub trait Message: Serialize + DeserializeOwned {
    /// Name of the kind, `<topic>.<what>`.
    const KIND: &'static str;
    /// Version of the payload.
    const VERSION: u16 = 1;
    /// The oldest version of the payload that is read: recordings hold it.
    const OLDEST_VERSION: u16 = Self::VERSION;
    /// Rule for a full queue.
    const OVERFLOW: Overflow = Overflow::Refuse;
}

/// What the bus has to know of a kind.
pub(crate) fn info<M: Message>() -> KindInfo {
    KindInfo {
        name: M::KIND.into(),
        version: M::VERSION,
        overflow: M::OVERFLOW,
    }
}

/// A payload that is not what its header states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DecodeError(pub String);

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for DecodeError {}

/// Appends a message to `out` as one frame.
pub fn push<M: Message>(out: &mut Vec<u8>, message: &M) {
    // Writing plain data into a vector cannot fail.
    let payload = rmp_serde::to_vec_named(message).expect("plain data");
    microsim_bus::push_frame(out, kind_id(M::KIND), M::VERSION, &payload);
}

/// The message in a frame, or `None` if the frame is of another kind.
pub fn decode<M: Message>(frame: &Frame<'_>) -> Option<Result<M, DecodeError>> {
    (frame.header.kind == kind_id(M::KIND)).then(|| {
        if !(M::OLDEST_VERSION..=M::VERSION).contains(&frame.header.version) {
            return Err(DecodeError(format!(
                "\"{}\" in version {}, version {} is known here",
                M::KIND,
                frame.header.version,
                M::VERSION
            )));
        }
        rmp_serde::from_slice(frame.payload)
            .map_err(|e| DecodeError(format!("\"{}\": {e}", M::KIND)))
    })
}

/// Any payload as JSON, for people.
pub fn to_json(payload: &[u8]) -> Result<serde_json::Value, DecodeError> {
    rmp_serde::from_slice(payload).map_err(|e| DecodeError(e.to_string()))
}

/// Plain data as MessagePack with field names (set-ups, states).
pub fn encode<T: Serialize>(data: &T) -> Vec<u8> {
    rmp_serde::to_vec_named(data).expect("plain data")
}

/// The opposite of [`encode`].
pub fn decode_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, DecodeError> {
    rmp_serde::from_slice(bytes).map_err(|e| DecodeError(e.to_string()))
}
