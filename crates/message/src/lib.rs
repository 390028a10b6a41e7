//! The message kinds of the platform: typed on this side, MessagePack with field names on the wire.
//!
//! Here: data, its wire form and the list of kinds. Not here: logic, queues (crate `bus`), a module's own kinds (they
//! stand in the module and its manifest). Field names on the wire let `microsim bus` show any message, known or not.
//! Units are SI; frames: *field* is the microscope's field (origin at its centre, z towards the viewer), *device* the
//! input device's own.

#![forbid(unsafe_code)]

mod input;
mod kinds;
mod level;
mod object;
mod setup;
#[cfg(test)]
mod tests;
mod tool;

pub use input::{InputEnd, InputSample};
pub use kinds::{TISSUE_SNAPSHOT, core_kinds};
pub use level::{
    CategoryScore, LevelControl, LevelEvent, LevelPhase, LevelState, LimitRecord, MetricRecord,
    TrainingResult,
};
pub use microsim_vocabulary::{Finish, LocalText, ToolStatus};
pub use object::{Colour, ObjectScene, ObjectSet, ObjectState, Shape};
pub use setup::{
    Log, LogLevel, PictureRequest, Progress, SessionRecord, Setup, SetupFile, config_value,
};
pub use tool::{
    ContactForce, ContactForces, GRIP_MIN, TissueCut, TissueRecovery, ToolSample, ToolState,
    ToolStates,
};

use microsim_bus::{Frame, kind_id};
use microsim_vocabulary::Overflow;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::fmt;

/// A typed message.
pub trait Message: Serialize + DeserializeOwned {
    /// Name of the kind, `<topic>.<what>`.
    const KIND: &'static str;
    /// Version of the payload.
    const VERSION: u16 = 1;
    /// Rule for a full queue.
    const OVERFLOW: Overflow = Overflow::Refuse;
}

/// A payload that is not what its header says.
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
    // Writing plain data into a vector has no way to fail.
    let payload = rmp_serde::to_vec_named(message).expect("plain data");
    microsim_bus::push_frame(out, kind_id(M::KIND), M::VERSION, &payload);
}

/// The message in a frame, or `None` if the frame is of another kind.
pub fn decode<M: Message>(frame: &Frame<'_>) -> Option<Result<M, DecodeError>> {
    (frame.header.kind == kind_id(M::KIND)).then(|| {
        if frame.header.version != M::VERSION {
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

/// Position \[m\] and orientation (unit quaternion x, y, z, w) in a frame that the field's name or doc states.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position \[m\].
    pub position: [f64; 3],
    /// Orientation: unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

impl Default for Pose {
    fn default() -> Self {
        Self {
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
        }
    }
}
