//! Bodies, tools and contact coupled into one step.
//!
//! What is here: the description of a scene and its checks, the tick with its sub-steps, forces in newtons, containment of a
//! body that diverges, exact saving and restoring. Crate `contact` finds where bodies touch, `tissue` enforces non-penetration; here one is
//! translated into the other. What is not: the mathematics of both, files, clocks, the bus. Pure: the same scene and motions give the same bits on any executor.

#![forbid(unsafe_code)]

mod body;
mod check;
mod containment;
mod cut_pairs;
mod cutting;
mod digest;
mod divergence;
mod drive;
mod edits;
mod error;
mod exemption;
mod from_settings;
mod group;
mod group_contact;
mod jaws;
mod lonor;
mod member;
mod overlap;
mod pairs;
mod pieces;
mod report;
mod run;
mod save;
mod scene;
mod select;
mod spec;
mod state;
mod stress;
mod surface_edits;
mod tally;
mod tear;
mod tick;
mod tool;
mod view;

pub use body::CutTally;
pub use divergence::{Diverged, Divergence};
pub use error::SceneError;
pub use from_settings::{
    Described, FromSettingsCause, FromSettingsError, LevelParts, Load, level_spec, scene_spec,
};
pub use microsim_contact::{ObstaclePart, ObstacleShape};
pub use microsim_geometry::Pose;
pub use microsim_mesh::{Surface, TetMesh};
pub use microsim_tissue::{
    Behaviour, BuildError, Energies, Executor, Material, Method, Serial, State, TissueModel,
};
pub use overlap::Overlap;
pub use report::{
    ContactPartner, ContactReport, CutReport, MANY_SUBSTEPS, Recovery, RejectedCut, TickReport,
};
pub use run::{ContactSeries, End, ProbeError, Remarks, Runner, Series, Verdict};
pub use save::RestoreError;
pub use scene::Scene;
pub use spec::{
    BodySpec, BoxSpec, CapsuleSpec, ClampSpec, ContactSpec, CouplingSpec, CutSpec, HingeSpec, Jaw,
    LoadKind, LoadSpec, MotionKey, MotionSpec, ObstacleSpec, PartnerSpec, SceneSpec, Selection,
    StartSpec, ToolKeySpec, ToolSpec,
};
pub use stress::von_mises;
pub use tool::ToolMotion;
pub use view::BodyView;

#[cfg(test)]
mod tests;
