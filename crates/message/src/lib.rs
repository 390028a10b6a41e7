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
mod level;
mod microscope;
mod object;
mod pose;
mod setup;
mod solver;
#[cfg(test)]
mod tests;
mod tool;
mod wire;

pub use input::{
    DesktopInput, ImplausibleSample, InputEnd, InputSample, InputTiming, MarkerTracking,
};
pub use level::{
    CategoryScore, LevelControl, LevelEvent, LevelPhase, LevelState, LimitRecord, MetricRecord,
    TrainingResult,
};
pub use microscope::{MAGNIFIED_FIELD, MicroscopeView, depth_of_field};
pub use microsim_vocabulary::{Finish, LocalText, MotionLimit, ToolStatus};
pub use object::{Colour, ObjectScene, ObjectSet, ObjectState, Shape};
pub use pose::Pose;
pub use setup::{
    Log, LogLevel, PictureRequest, Progress, SessionRecord, Setup, SetupFile, config_value,
};
pub use solver::SolverTick;
pub use tool::{
    ContactForce, ContactForces, GRIP_MIN, PartForce, PathPoints, RegionForce, TissueCut,
    TissueRecovery, ToolPlacement, ToolPlacements, ToolPose, ToolSample, ToolState, ToolStates,
};
pub use wire::{DecodeError, Message, decode, decode_bytes, encode, push, to_json};

use microsim_bus::KindInfo;
use microsim_vocabulary::Overflow;

/// Kind of the blocks that carry the nodes and surface of a body: arrays `node_id` (u32), `position` (f64, 3 per node,
/// field frame, m), `piece` (u32, one per node: which piece of the body it is of, 0 before any came off), `triangle` (u32, 3 rows of
/// `node_id`'s array per triangle, outward), `inner` (u32, one per triangle: 1 of a surface that a cut has opened, else 0).
pub const TISSUE_SNAPSHOT: &str = "tissue.snapshot";

/// Kind of the blocks that carry a body at rest, where nothing acts on it, as its mesh lay before the first tick: arrays `node_id`, `position` and
/// `triangle` as in [`TISSUE_SNAPSHOT`]. Published once, in the first tick; whoever subscribes has it in every tick. Nodes that cuts make are not in it.
pub const TISSUE_REST: &str = "tissue.rest";

/// Kind of the blocks that carry what is known of a body beside its snapshot of the same tick, for those who measure layers: arrays `rest` (f64, 3 per node of the
/// snapshot: where it lies in the mesh at rest, field frame, m), `triangle_region` (u32, one per triangle of the snapshot: the region of the element behind it), and of each
/// element `region` (u32), `volume` (f64, at rest, m³) and `stretch` (f64, the largest principal one from the natural state, with what has flowed). Published in every tick of
/// a run whose module subscribes to it.
pub const TISSUE_ELEMENTS: &str = "tissue.elements";

/// Kind of the blocks that carry what pictures of the computation show of a body, of each node of the snapshot of the same tick: `von_mises` (f64, Pa, the mean of the elements
/// at it by their volumes at rest; missing where no element is a continuum), `quality` (f64, the least of the elements at it now, 1 of a regular tetrahedron, below 0 inside
/// out) and `remedy` (u32, the bits of [`Remedy`](microsim_vocabulary::Remedy)). Never published: whoever draws such pictures asks the physics for them by the ability of this name.
pub const TISSUE_FIELDS: &str = "tissue.fields";

/// Every kind that the platform itself brings.
pub fn core_kinds() -> Vec<KindInfo> {
    vec![
        wire::info::<InputSample>(),
        wire::info::<InputEnd>(),
        wire::info::<DesktopInput>(),
        wire::info::<MicroscopeView>(),
        wire::info::<ImplausibleSample>(),
        wire::info::<InputTiming>(),
        wire::info::<MarkerTracking>(),
        wire::info::<ToolSample>(),
        wire::info::<ToolStates>(),
        wire::info::<ToolPlacements>(),
        wire::info::<ContactForces>(),
        wire::info::<TissueRecovery>(),
        wire::info::<TissueCut>(),
        wire::info::<SolverTick>(),
        KindInfo {
            name: TISSUE_SNAPSHOT.into(),
            version: 1,
            overflow: Overflow::DropOldest,
        },
        KindInfo {
            name: TISSUE_REST.into(),
            version: 1,
            overflow: Overflow::DropOldest,
        },
        KindInfo {
            name: TISSUE_ELEMENTS.into(),
            version: 1,
            overflow: Overflow::DropOldest,
        },
        wire::info::<ObjectSet>(),
        wire::info::<ObjectScene>(),
        wire::info::<LevelControl>(),
        wire::info::<LevelState>(),
        wire::info::<LevelEvent>(),
        wire::info::<TrainingResult>(),
        wire::info::<Log>(),
        wire::info::<Progress>(),
        wire::info::<PictureRequest>(),
        wire::info::<SessionRecord>(),
    ]
}
