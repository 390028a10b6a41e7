//! The list of the platform's own kinds.

use crate::input::{InputEnd, InputSample};
use crate::level::{LevelControl, LevelEvent, LevelState, TrainingResult};
use crate::object::{ObjectScene, ObjectSet};
use crate::setup::{Log, PictureRequest, Progress, SessionRecord};
use crate::tool::{ContactForces, TissueCut, TissueRecovery, ToolSample, ToolStates};
use crate::wire::Message;
use microsim_bus::KindInfo;
use microsim_vocabulary::Overflow;

/// Kind of the blocks that carry the nodes and surface of a body: arrays `node_id` (u32), `position` (f64, 3 per node,
/// field frame, m), `piece` (u32, one per node: which piece of the body it is of, 0 before any came off), `triangle` (u32, 3 rows of
/// `node_id`'s array per triangle, outward), `inner` (u32, one per triangle: 1 of a surface that a cut has opened, else 0).
pub const TISSUE_SNAPSHOT: &str = "tissue.snapshot";

fn info<M: Message>() -> KindInfo {
    KindInfo {
        name: M::KIND.into(),
        version: M::VERSION,
        overflow: M::OVERFLOW,
    }
}

/// Every kind that the platform itself brings.
pub fn core_kinds() -> Vec<KindInfo> {
    vec![
        info::<InputSample>(),
        info::<InputEnd>(),
        info::<ToolSample>(),
        info::<ToolStates>(),
        info::<ContactForces>(),
        info::<TissueRecovery>(),
        info::<TissueCut>(),
        KindInfo {
            name: TISSUE_SNAPSHOT.into(),
            version: 1,
            overflow: Overflow::DropOldest,
        },
        info::<ObjectSet>(),
        info::<ObjectScene>(),
        info::<LevelControl>(),
        info::<LevelState>(),
        info::<LevelEvent>(),
        info::<TrainingResult>(),
        info::<Log>(),
        info::<Progress>(),
        info::<PictureRequest>(),
        info::<SessionRecord>(),
    ]
}
