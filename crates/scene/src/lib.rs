//! Bodies, tools and contact coupled into one step.
//!
//! What is here: the description of a scene and its checks, the tick with its sub-steps, forces in newtons, containment of a
//! body that diverges, exact saving and restoring. What is not: the mathematics of tissue and contact (crates `tissue`,
//! `contact`), files, clocks, the bus. Pure: the same scene and motions give the same bits on any executor.

mod check;
mod containment;
mod drive;
mod error;
mod from_settings;
mod report;
mod run;
mod save;
mod scene;
mod select;
mod spec;
mod stress;
mod tick;
mod tool;

pub use containment::{Diverged, Divergence};
pub use error::SceneError;
pub use from_settings::{
    Described, FromSettingsCause, FromSettingsError, LevelParts, Load, level_spec, scene_spec,
};
pub use microsim_geometry::Pose;
pub use microsim_mesh::{Surface, TetMesh};
pub use microsim_tissue::{
    Behaviour, BuildError, Energies, Executor, Material, Method, Serial, State, TissueModel,
};
pub use report::{ContactReport, Recovery, TickReport};
pub use run::{End, ProbeError, Runner, Series, Verdict};
pub use save::RestoreError;
pub use scene::Scene;
pub use spec::{
    BodySpec, BoxSpec, CapsuleSpec, ClampSpec, CouplingSpec, HingeSpec, LoadKind, LoadSpec,
    MotionKey, MotionSpec, SceneSpec, Selection, StartSpec, ToolSpec,
};
pub use stress::von_mises;
pub use tool::ToolMotion;

#[cfg(test)]
mod tests;
