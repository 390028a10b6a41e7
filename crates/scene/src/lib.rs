//! Simulates scenes: deformable bodies and rigid tools with clamps, loads, contact and cuts, tick by tick.
//!
//! # Where to begin
//! A scene is described by plain values ([`SceneSpec`]), checked and built ([`Scene::new`]), and advanced in ticks of several solver steps
//! ([`Scene::tick`]):
//!
//! ```
//! use microsim_mesh::{Block, CellSplit};
//! use microsim_scene::*;
//! use microsim_tissue::SpringConstants;
//!
//! // A cube of 2 mm, clamped at its upper face.
//! let block = Block { center: [0.0; 3], size: [2e-3; 3], cells: [2; 3], split: CellSplit::Kuhn };
//! let behaviour = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
//! let material = Material { density: 1060.0, relaxation_time: 0.0, behaviour };
//! let top = BoxSpec { min: [-1.0, -1.0, 1e-3], max: [1.0; 3] };
//! let cube = BodySpec {
//!     drag: 100.0,
//!     clamps: vec![ClampSpec { nodes: Selection::Box(top), motion: None, release: None }],
//!     ..BodySpec::new("cube", block.mesh()?, material)
//! };
//! let mut scene = Scene::new(&SceneSpec::new(vec![cube], Method::StoermerVerlet))?;
//!
//! // 50 ms in ticks of 1 ms: it sags under its own weight.
//! let steps = scene.required_steps(1e-3);
//! for _ in 0..50 {
//!     scene.tick(&[], 1e-3, steps, &Serial)?;
//! }
//! let body = scene.body(0);
//! let lowest = body.positions().iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
//! assert!(lowest < -1e-3 && lowest > -1.1e-3);
//! // The clamp bears its weight, but for what still swings.
//! let clamped = body.forces().into_iter().zip(body.clamped()).filter(|(_, clamped)| *clamped);
//! let force: f64 = clamped.map(|(force, _)| -force.z).sum();
//! let weight = 9.81 * body.masses().iter().sum::<f64>();
//! assert!((force / weight - 1.0).abs() < 0.1, "{force} N, {weight} N");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what for | see |
//! |---|---|
//! | describe: bodies, clamps, loads, tools, obstacles, contacts, cuts | [`SceneSpec`], and the types of its fields |
//! | the same from a TOML file (`config/scenes`, levels) | [`scene_spec`], [`level_spec`] |
//! | advance by a tick, with motions of the tools | [`Scene::tick`], [`ToolMotion`]; number of steps: [`Scene::required_steps`] |
//! | run a scene file to its end, with probes and expected values | [`Runner`] |
//! | read positions, forces, energies, pieces | [`Scene::body`], [`BodyView`] |
//! | forces of contact and what was cut in a tick | [`TickReport`], [`ContactReport`], [`CutReport`] |
//! | save and restore, to the bit | [`Scene::save`], [`Scene::restore`] |
//! | cut a body in two | `cargo run --release --example cut -p microsim-scene` |
//! | materials, laws and methods | crate `tissue` |
//! | meshes: generators and files | crate `mesh` |
//!
//! Quantities are in SI units, positions in the world frame unless stated otherwise.
//!
//! # What is not here
//! Crate `contact` finds where bodies touch, `tissue` enforces non-penetration, `cutting` divides meshes; here they are coupled. A body that
//! diverges is rolled back to the start of the tick ([`Diverged`]). No files, no clocks, no messages: the same scene and motions give the
//! same bits on any [`Executor`].

#![forbid(unsafe_code)]

mod attempt;
mod body;
mod box_grip;
mod budget;
mod check;
mod coarsen;
mod containment;
mod cut_pairs;
mod cut_report;
mod cutting;
mod digest;
mod divergence;
mod division;
mod drive;
mod edits;
mod error;
mod exemption;
mod fields;
mod force_window;
mod from_settings;
mod group;
mod group_contact;
mod initial_equilibrium;
mod irrigation;
mod jaws;
mod jet;
mod jump;
mod lonor;
mod lumen;
mod member;
mod overlap;
mod pairs;
mod pieces;
mod placement;
mod report;
mod run;
mod save;
mod scene;
mod select;
mod spec;
mod state;
mod step_limits;
mod stress;
mod stretch_guard;
mod surface_edits;
mod tally;
mod tear;
mod tick;
mod tool;
mod travel;
mod validity;
mod view;
mod working_step;

pub use body::CutTally;
pub use cut_report::{CutReport, RejectedCut};
pub use divergence::{Diverged, Divergence};
pub use error::{PrestretchError, SceneError};
pub use fields::NodeFields;
pub use force_window::FORCE_WINDOW;
pub use from_settings::{
    Described, FromSettingsCause, FromSettingsError, LevelParts, Load, level_spec, scene_spec,
};
pub use initial_equilibrium::InitialEquilibrium;
pub use microsim_contact::{BroadPhaseMethod, Depth, ObstaclePart, ObstacleShape};
pub use microsim_geometry::{Hinge, Joint, Pose};
pub use microsim_mesh::{Surface, TetMesh};
pub use microsim_tissue::stability::WORKING_STRETCH;
pub use microsim_tissue::{
    Behaviour, BuildError, Energies, Executor, Material, Method, Serial, State, TissueModel,
};
pub use overlap::Overlap;
pub use report::{
    ContactPartner, ContactReport, MANY_SUBSTEPS, PartReport, Recovery, RegionReport, SolverReport,
    TickReport,
};
pub use run::{
    ContactSeries, End, EnergyGrowth, ProbeError, Remarks, Runner, Series, Stiffened, Verdict,
};
pub use save::RestoreError;
pub use scene::Scene;
pub use spec::{
    BodySpec, BoxSpec, CapsuleSpec, ClampSpec, ContactSpec, CouplingKind, CouplingSpec, CutSpec,
    CutTrigger, Grip, IrrigationSpec, Jaw, LoadKind, LoadSpec, LumenSpec, MotionKey, MotionSpec,
    ObstacleSpec, PartnerSpec, SceneSpec, Selection, StartSpec, ToolKeySpec, ToolSpec, WorkBudget,
};
pub use stress::{cauchy_stresses, green_strains, largest_stretches, von_mises};
pub use stretch_guard::TOO_LONG;
pub use tool::ToolMotion;
pub use validity::SolverBounds;
pub use view::BodyView;

#[cfg(test)]
mod tests;
