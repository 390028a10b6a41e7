//! Tools in the field and what they do to tissue.

use crate::pose::Pose;
use crate::wire::Message;
use microsim_vocabulary::{Overflow, ToolStatus};
use serde::{Deserialize, Serialize};

/// Where a tool was, by one valid sample of its device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolPose {
    /// `field_from_tool`: pose of the tip in the field.
    #[serde(flatten)]
    pub pose: Pose,
    /// Opening, 0 closed … 1 open.
    pub opening: f64,
    /// Time of the sample by the device's clock \[s\].
    #[serde(rename = "sample_time_s")]
    pub time: f64,
}

/// One input sample, translated: for metrics, which must not depend on the tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolSample {
    /// Tool slot of the level.
    pub tool: String,
    /// Device time \[s\].
    pub time: f64,
    /// Whether the instrument was visible, and a hand can have moved it so; if not, the pose is the last valid one.
    pub tracked: bool,
    /// Pose of the tip in the field.
    pub pose: Pose,
    /// Opening, 0 closed … 1 open.
    pub opening: f64,
}

impl ToolSample {
    /// The sample of a tool that is, or if it is not tracked was last seen, `at` a pose; its time is that of the sample.
    pub fn new(tool: &str, tracked: bool, at: ToolPose) -> Self {
        Self {
            tool: tool.to_owned(),
            time: at.time,
            tracked,
            pose: at.pose,
            opening: at.opening,
        }
    }

    /// Where the tool is, without its name.
    pub fn at(&self) -> ToolPose {
        ToolPose {
            pose: self.pose,
            opening: self.opening,
            time: self.time,
        }
    }
}

impl Message for ToolSample {
    const KIND: &'static str = "tool.sample";
}

/// One tool at the end of a tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolState {
    /// Tool slot of the level.
    pub tool: String,
    /// Tool model, for example `forceps`.
    pub model: String,
    /// Tracking state.
    pub status: ToolStatus,
    /// Pose of the tip in the field.
    pub pose: Pose,
    /// Opening, 0 closed … 1 open.
    pub opening: f64,
}

/// All tools of the level at the end of a tick, in the level's order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToolStates {
    /// The tools.
    pub tools: Vec<ToolState>,
}

impl Message for ToolStates {
    const KIND: &'static str = "tool.states";
    const OVERFLOW: Overflow = Overflow::DropOldest;
}

/// Where tissue and other tools let the tools be, at the end of a tick in which one of them is not where its hand holds it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToolPlacements {
    /// The tick; in others the tools are where they are tracked.
    pub tick: u64,
    /// The tools that touch tissue, in the level's order.
    pub tools: Vec<ToolPlacement>,
}

/// Where a tool is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolPlacement {
    /// Tool slot of the level.
    pub tool: String,
    /// Pose of the tip in the field.
    pub pose: Pose,
    /// Opening, 0 closed … 1 open.
    pub opening: f64,
}

impl Message for ToolPlacements {
    const KIND: &'static str = "tool.placements";
    const OVERFLOW: Overflow = Overflow::DropOldest;
}

/// Force of a tool, a rigid obstacle or another body on one body, mean over a tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactForce {
    /// What touches the body: a tool slot; in [`ContactForces::between`] the name of a rigid obstacle or body, that of the body itself in
    /// self-contact.
    #[serde(alias = "tool")]
    pub partner: String,
    /// Body.
    pub body: String,
    /// Force on the tissue in the field \[N\].
    pub force: [f64; 3],
    /// Largest magnitude within the tick \[N\].
    #[serde(alias = "peak")]
    pub peak_force: f64,
    /// Impulse in the tick \[N s\].
    pub impulse: f64,
    /// Point of application in the field \[m\].
    pub point: [f64; 3],
    /// Deepest penetration that was left after a step \[m\].
    pub depth: f64,
    /// Largest displacement of a touched node from its rest position along the force \[m\].
    pub indentation: f64,
    /// Time within the tick in which [`sustained_force`](Self::sustained_force) was above the level's limit for this pair \[s\].
    #[serde(default, alias = "over_limit")]
    pub time_over_limit: f64,
    /// Size of the mean force over the last 50 ms \[N\], the time scale of a hand: what metrics take the peak of. Ticks whose forces mean nothing
    /// ([`SolverTick::valid`](crate::SolverTick::valid)) are left out; 0 in sessions of before version 3.
    #[serde(default)]
    pub sustained_force: f64,
    /// Mean of [`grip_force`](Self::grip_force) over the same time \[N\].
    #[serde(default)]
    pub sustained_grip: f64,
    /// Fraction of the normal force that acts where nothing slides, from 0 to 1.
    #[serde(default, alias = "stick")]
    pub sticking_fraction: f64,
    /// Force with which both jaws of a tool squeeze the tissue between them: the smaller of what each pushes it towards the other
    /// one, without friction \[N\]. From [`GRIP_MIN`] on they grip it.
    #[serde(default, alias = "grip")]
    pub grip_force: f64,
    /// The pieces of the body that are touched, by their numbers in the snapshots, ascending.
    #[serde(default)]
    pub pieces: Vec<u32>,
    /// The parts of the tool that touch, in the order of its file: forces of opposing jaws cancel in [`force`](Self::force), and not here.
    #[serde(default)]
    pub parts: Vec<PartForce>,
    /// The regions of the body that are touched, ascending: their forces sum up to [`force`](Self::force). Those of a body on itself sum up to zero.
    #[serde(default)]
    pub regions: Vec<RegionForce>,
}

/// Force of one part of a tool on one body, mean over a tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartForce {
    /// Name of the capsule in the file of the tool, for example `left-tip` or `shaft`.
    pub part: String,
    /// Force on the tissue in the field \[N\].
    pub force: [f64; 3],
    /// Sum of the sizes of its normal forces \[N\]: how strongly it presses, also where it is pressed from all sides.
    pub normal_force: f64,
    /// Point of application in the field \[m\].
    pub point: [f64; 3],
    /// How many nodes of the body it touches.
    pub nodes: u32,
}

/// Force on one region of a body, mean over a tick. A point on the border of regions counts for each by the area at rest of its triangles there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegionForce {
    /// The region of the mesh's elements, as materials of the level name it.
    pub region: u32,
    /// Force on the tissue in the field \[N\].
    pub force: [f64; 3],
    /// Sum of the sizes of its normal forces \[N\]: how strongly it is pressed, also where that comes from all sides.
    pub normal_force: f64,
    /// Point of application in the field \[m\].
    pub point: [f64; 3],
}

/// Jaws that squeeze tissue less than this touch it and do not grip it \[N\]: a few times what lifts a freed piece of a few
/// milligrams, and far below the grips that tasks take, of tens of millinewtons.
pub const GRIP_MIN: f64 = 1e-3;

/// All contacts of a tick; published while there are any, and once more, empty, when the last one ends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactForces {
    /// The contacts of tools, in the order of the level's pairs.
    pub contacts: Vec<ContactForce>,
    /// Those of bodies with rigid obstacles, with each other and with themselves.
    #[serde(default)]
    pub between: Vec<ContactForce>,
}

impl Message for ContactForces {
    const KIND: &'static str = "contact.forces";
    const VERSION: u16 = 4;
    // Version 1 had other names of fields, version 2 neither sustained forces nor parts, version 3 no regions.
    const OLDEST_VERSION: u16 = 1;
}

/// Points at which a tool crossed edges of a mesh, at rest and in the field, as sums over them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PathPoints {
    /// Their number.
    pub count: u32,
    /// Their sum \[m\].
    pub sum: [f64; 3],
    /// Sums of products of their coordinates: xx, yy, zz, xy, xz, yz \[m²\].
    pub products: [f64; 6],
}

/// Tissue was cut; published in the tick of the edit, once per body and tool.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TissueCut {
    /// Body.
    pub body: String,
    /// Tool slot; empty of tissue that tore by itself.
    pub tool: String,
    /// Area that was opened, of one side, at rest \[m²\].
    pub area: f64,
    /// Its centroid in the field \[m\].
    pub centroid: [f64; 3],
    /// Its mean normal in the field, of length 1.
    pub normal: [f64; 3],
    /// Its centroid at rest, in the field \[m\].
    pub rest_centroid: [f64; 3],
    /// Its mean normal at rest, of length 1.
    pub rest_normal: [f64; 3],
    /// Where the tool went through the tissue: where it crossed edges of the mesh since it last opened something, whatever came apart there. None of tissue that tore by itself.
    #[serde(default)]
    pub points: PathPoints,
    /// Whether its tick is valid ([`SolverTick::valid`](crate::SolverTick::valid)). No metric takes anything from one that was not.
    #[serde(default = "valid")]
    pub valid: bool,
    /// Size of the force of the tool on the body in the tick \[N\].
    pub force: f64,
    /// The pieces that came off, by their numbers in the snapshots.
    pub pieces: Vec<u32>,
}

/// Recordings of version 1 do not hold it: what came apart counted.
fn valid() -> bool {
    true
}

impl Message for TissueCut {
    const KIND: &'static str = "tissue.cut";
    const VERSION: u16 = 2;
    // Version 1 had no points.
    const OLDEST_VERSION: u16 = 1;
}

/// A body diverged, was rolled back and computed again with more sub-steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TissueRecovery {
    /// Body.
    pub body: String,
    /// What was wrong.
    pub cause: String,
    /// Sub-steps of the tick that worked; 0 if none did and the body was held at its last good state.
    pub substeps: u32,
}

impl Message for TissueRecovery {
    const KIND: &'static str = "tissue.recovery";
}
