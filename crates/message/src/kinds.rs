//! The list of the platform's own kinds.

use crate::*;
use microsim_bus::KindInfo;

/// Kind of the blocks that carry the nodes and surface of a body: arrays `node_id` (u32), `position` (f64, 3 per node,
/// field frame, m), `triangle` (u32, 3 rows of `node_id`'s array per triangle, outward).
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
