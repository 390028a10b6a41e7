//! The message kinds of the platform: typed on this side, MessagePack with field names on the wire.
//!
//! A manifest names a message by its [`Message::KIND`], such as `tool.states` for [`ToolStates`]; `microsim bus` lists all kinds with
//! who publishes and receives them.
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
mod pose;
mod setup;
#[cfg(test)]
mod tests;
mod tool;
mod wire;

pub use input::{InputEnd, InputSample};
pub use kinds::{TISSUE_SNAPSHOT, core_kinds};
pub use level::{
    CategoryScore, LevelControl, LevelEvent, LevelPhase, LevelState, LimitRecord, MetricRecord,
    TrainingResult,
};
pub use microsim_vocabulary::{Finish, LocalText, ToolStatus};
pub use object::{Colour, ObjectScene, ObjectSet, ObjectState, Shape};
pub use pose::Pose;
pub use setup::{
    Log, LogLevel, PictureRequest, Progress, SessionRecord, Setup, SetupFile, config_value,
};
pub use tool::{
    ContactForce, ContactForces, GRIP_MIN, TissueCut, TissueRecovery, ToolPose, ToolSample,
    ToolState, ToolStates,
};
pub use wire::{DecodeError, Message, decode, decode_bytes, encode, push, to_json};
