//! `config/scenes/NAME.toml`: physics alone. Bodies, materials, loads, method, what is watched and what must come out: the
//! same file is a demonstration, a test and a benchmark.
//!
//! Frame: the world's, right-handed, z up. Everything is in SI.

use crate::body::{Body, Nodes};
use crate::contact::{ContactPair, CutPair, SceneTool};
use crate::document::{Loaded, Reading, load_text};
use crate::error::ConfigErrors;
use crate::level::View;
use crate::method::{Accuracy, Method, Tuned};
use crate::overrides::Override;
use crate::rigid::Rigid;
use crate::scene_check::check;
use crate::scene_schema::scene_schema;
use microsim_vocabulary::{LocalText, Unit, terms};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// For people: its name.
    pub title: LocalText,
    /// For people: what it shows.
    pub summary: LocalText,
    /// How long, in which steps.
    pub run: SceneRun,
    /// What pictures show; `None` for all bodies.
    pub view: Option<View>,
    /// How the bodies are advanced.
    pub method: Method,
    /// Tetrahedral bodies.
    pub body: Vec<Body>,
    /// Tools and how they move.
    pub tool: Vec<SceneTool>,
    /// Rigid things that stand.
    pub rigid: Vec<Rigid>,
    /// What touches what.
    pub contact: Vec<ContactPair>,
    /// What cuts what.
    pub cut: Vec<CutPair>,
    /// What is watched.
    pub probe: Vec<Probe>,
    /// What must come out.
    pub expect: Vec<Expect>,
    /// What is stated of the result.
    pub accuracy: Option<Accuracy>,
    /// What `microsim tune` chose.
    pub tuned: Option<Tuned>,
}

/// How long a scene runs, and in which steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneRun {
    /// Simulated time; with `end = "rest"` the longest \[s\].
    pub duration: f64,
    /// Step of the solver \[s\]; shortened so that a whole number fits between two samples.
    pub step: f64,
    /// Time between two samples of the series \[s\]; a longer step takes its place.
    pub sample: f64,
    /// Time between two exported meshes \[s\]; a longer sample takes its place.
    pub frame: f64,
    /// When it ends.
    pub end: End,
    /// Largest speed of a node that counts as rest \[m/s\].
    pub rest_speed: Option<f64>,
    /// \[m/s²\]
    pub gravity: [f64; 3],
    /// Whether a body that diverges is rolled back and computed again with shorter steps.
    pub containment: bool,
}

terms! {
    /// When a scene ends.
    pub enum End {
        /// After its duration.
        Time = "time",
        /// When no node has been faster than the speed of rest over a whole sample.
        Rest = "rest",
    }
}

/// A number that is sampled into the series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// The body.
    pub body: String,
    /// Nodes of the body.
    pub nodes: Nodes,
    /// The other side: another body, a tool or a rigid thing.
    pub with: Option<String>,
    /// What of them.
    pub quantity: Quantity,
    /// Direction of a displacement, force or gap, of length 1.
    pub direction: Option<[f64; 3]>,
    /// A point of the axis of a radius or torque, in the body's frame \[m\].
    pub point: Option<[f64; 3]>,
    /// Direction of that axis, of length 1.
    pub axis: Option<[f64; 3]>,
}

terms! {
    /// What a probe measures.
    pub enum Quantity {
        /// Mean displacement along a direction.
        Displacement = "displacement",
        /// Displacement of the centre of mass along a direction.
        Centre = "centre",
        /// Mean change of the distance from an axis.
        Radius = "radius",
        /// Largest distance of a node from its place at rest.
        Distance = "distance",
        /// Force along a direction with which clamps hold those of the nodes that they hold now; loads and weight are not in it.
        Force = "force",
        /// Torque about an axis with which clamps hold those of the nodes that they hold now.
        Torque = "torque",
        /// Relative change of the body's volume.
        Volume = "volume",
        /// Smallest volume of an element, as a share of that at rest; negative for an inverted one.
        SmallestVolume = "smallest-volume",
        /// Kinetic, elastic and potential energy of the body, the last one 0 at rest.
        Energy = "energy",
        /// Force of another side on the body along a direction, mean over the sample before.
        ContactForce = "contact-force",
        /// Sum of the sizes of the normal forces of a tool's jaws on the body, mean over the sample before.
        Grip = "grip",
        /// How far another body is ahead of this one along a direction: its least coordinate less the largest one of the nodes.
        Gap = "gap",
        /// Share of the nodes that are inside other bodies, tools and rigid things that the body touches.
        Inside = "inside",
        /// Depth of the deepest of these.
        Depth = "depth",
        /// Number of edges of the body's surface through triangles of another body's, and the other way round.
        Crossings = "crossings",
        /// Number of pieces that the body has come apart into.
        Pieces = "pieces",
    }
}

impl Quantity {
    /// Unit of its values.
    pub fn unit(self) -> Unit {
        match self {
            Self::Displacement
            | Self::Centre
            | Self::Radius
            | Self::Distance
            | Self::Gap
            | Self::Depth => Unit::Length,
            Self::Force | Self::ContactForce | Self::Grip => Unit::Force,
            Self::Torque => Unit::Torque,
            Self::Volume | Self::SmallestVolume | Self::Inside => Unit::Ratio,
            Self::Energy => Unit::Energy,
            Self::Crossings | Self::Pieces => Unit::Count,
        }
    }
}

/// What must come out of a probe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// The probe.
    pub probe: String,
    /// What of its series.
    pub what: Feature,
    /// The right value, in SI.
    pub value: f64,
    /// Largest error that is right, as a share of `scale`.
    pub tolerance: f64,
    /// What errors are a share of, in SI; the size of `value` if `None`.
    pub scale: Option<f64>,
    /// How long a curve must have fallen after its first peak \[s\].
    pub settle: f64,
    /// Where value and tolerance come from.
    pub source: String,
}

terms! {
    /// What is taken from a series.
    pub enum Feature {
        /// The last value.
        AtEnd = "at-end",
        /// The largest value.
        Largest = "largest",
        /// Largest minus smallest value.
        Spread = "spread",
        /// The largest value before the curve has fallen for a time.
        FirstPeak = "first-peak",
        /// When that is.
        FirstPeakTime = "first-peak-time",
        /// Frequency of the crossings of the middle.
        Frequency = "frequency",
    }
}

impl Feature {
    /// Unit of its values for a probe of this quantity.
    pub fn unit(self, quantity: Quantity) -> Unit {
        match self {
            Self::AtEnd | Self::Largest | Self::Spread | Self::FirstPeak => quantity.unit(),
            Self::FirstPeakTime => Unit::Time,
            Self::Frequency => Unit::Frequency,
        }
    }
}

/// Reads a scene from a text, with values that take the place of some in it; `file` is the name that complaints use.
pub fn read_scene(
    text: &str,
    file: &str,
    overrides: &[Override],
) -> Result<Loaded<Scene>, ConfigErrors> {
    let mut reading = Reading::with_overrides(text, file, &scene_schema(), overrides)?;
    check(&mut reading);
    reading.finish()
}

/// Reads the scene at `path`.
pub fn load_scene(path: &Path, overrides: &[Override]) -> Result<Loaded<Scene>, ConfigErrors> {
    let text = load_text(path, "a scene (config/scenes/NAME.toml)")?;
    read_scene(&text, &path.display().to_string(), overrides)
}
