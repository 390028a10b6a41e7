//! `level<N>.toml`: one level of a training module: its clock, view, tools, objects, bodies, contacts, limits and the
//! module's own keys.
//!
//! Frames: the field frame is right-handed, x to the right and y away from the trainee in the picture, z up towards the
//! microscope. Everything is in SI.

use crate::body::Body;
use crate::colour::Colour;
use crate::contact::{ContactPair, CutPair};
use crate::document::{Loaded, Reading, load_text};
use crate::error::ConfigErrors;
use crate::level_check::check;
use crate::level_schema::level_schema;
use crate::manifest::Manifest;
use crate::method::{Accuracy, Method, Tuned};
use crate::rigid::Rigid;
use microsim_vocabulary::{Direction, Finish, LocalText, Unit, terms};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// One level of a training module.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// For people: its name.
    pub title: LocalText,
    /// For people: what changes and why it is harder.
    pub summary: LocalText,
    /// The two clocks.
    pub clock: Clock,
    /// What the microscope shows.
    pub view: View,
    /// Tool slots.
    pub tool: Vec<ToolSlot>,
    /// Virtual objects.
    pub object: Vec<Object>,
    /// Tetrahedral bodies.
    pub body: Vec<Body>,
    /// Rigid things that stand.
    pub rigid: Vec<Rigid>,
    /// What touches what.
    pub contact: Vec<ContactPair>,
    /// What cuts what.
    pub cut: Vec<CutPair>,
    /// What drives all bodies; `None` in a level without physics.
    pub physics: Option<Physics>,
    /// How they are advanced; `None` in a level without physics.
    pub method: Option<Method>,
    /// What is stated of their motion.
    pub accuracy: Option<Accuracy>,
    /// What `microsim tune` chose.
    pub tuned: Option<Tuned>,
    /// What is demanded.
    pub limit: Vec<Limit>,
    /// Parameters of the metrics.
    pub metrics: MetricParameters,
    /// The keys that the module's manifest declares, in SI.
    pub module: serde_json::Map<String, Value>,
}

/// The two clocks of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clock {
    /// Time between two ticks \[s\], a whole number of microseconds.
    pub tick: f64,
    /// Steps of the solver in a tick.
    pub steps: u32,
}

impl Clock {
    /// Time between two ticks \[µs\].
    pub fn tick_us(&self) -> u64 {
        (self.tick * 1e6).round() as u64
    }
}

/// What the microscope shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Diameter of the round field \[m\].
    pub field: f64,
    /// Point in the middle of the picture, in the field frame \[m\].
    pub centre: [f64; 3],
    /// Angle between the line of sight and −z, turned about x towards the trainee \[rad\].
    pub tilt: f64,
}

/// A tool that takes part, under the name that sources and the translator use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolSlot {
    /// Slot, for example `right`.
    pub name: String,
    /// Name of a file of `config/tools`, without its extension.
    pub model: String,
}

/// A virtual object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ObjectFile", into = "ObjectFile")]
pub struct Object {
    /// Its name, or the beginning of its names if there is a `count`.
    pub name: String,
    /// Makes that many equal objects, named `name-1`, `name-2` …
    pub count: Option<u32>,
    /// Form and size.
    pub shape: Shape,
    /// Of its centre in the frame of the parent \[m\].
    pub position: [f64; 3],
    /// Rotation x, y, z, w from its own frame to that of the parent.
    pub orientation: [f64; 4],
    /// Object whose frame its pose is given in; the field frame if `None`.
    pub parent: Option<String>,
    /// Colour.
    pub colour: Colour,
    /// How its surface answers light.
    pub finish: Finish,
    /// Whether it is there from the start.
    pub active: bool,
}

/// Form and size of a virtual object, about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// All points within the radius.
    Sphere {
        /// \[m\]
        radius: f64,
    },
    /// All points within the radius of a segment along its z axis.
    Capsule {
        /// \[m\]
        radius: f64,
        /// Of the segment \[m\].
        length: f64,
    },
    /// A box along its axes.
    Box {
        /// Half of each side \[m\].
        half_size: [f64; 3],
    },
    /// A torus around its z axis.
    Ring {
        /// To the middle of the tube \[m\].
        radius: f64,
        /// Radius of the tube \[m\].
        tube: f64,
    },
}

/// An object as the file has it: the sizes that its shape needs are checked before.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectFile {
    name: String,
    count: Option<u32>,
    shape: ShapeName,
    radius: Option<f64>,
    length: Option<f64>,
    tube: Option<f64>,
    half_size: Option<[f64; 3]>,
    position: [f64; 3],
    orientation: [f64; 4],
    parent: Option<String>,
    colour: Colour,
    finish: Finish,
    active: bool,
}

terms! {
    /// Forms of virtual objects.
    pub(crate) enum ShapeName {
        /// A ball.
        Sphere = "sphere",
        /// A ball that is drawn out along z.
        Capsule = "capsule",
        /// A box along the axes.
        Box = "box",
        /// A torus around z.
        Ring = "ring",
    }
}

impl TryFrom<ObjectFile> for Object {
    type Error = String;

    fn try_from(file: ObjectFile) -> Result<Self, String> {
        let sizes = (file.radius, file.length, file.tube, file.half_size);
        let shape = match (file.shape, sizes) {
            (ShapeName::Sphere, (Some(radius), None, None, None)) => Shape::Sphere { radius },
            (ShapeName::Capsule, (Some(radius), Some(length), None, None)) => {
                Shape::Capsule { radius, length }
            }
            (ShapeName::Box, (None, None, None, Some(half_size))) => Shape::Box { half_size },
            (ShapeName::Ring, (Some(radius), None, Some(tube), None)) => {
                Shape::Ring { radius, tube }
            }
            _ => {
                return Err(format!(
                    "sizes of `{}` that do not fit its shape",
                    file.name
                ));
            }
        };
        Ok(Object {
            name: file.name,
            count: file.count,
            shape,
            position: file.position,
            orientation: file.orientation,
            parent: file.parent,
            colour: file.colour,
            finish: file.finish,
            active: file.active,
        })
    }
}

impl From<Object> for ObjectFile {
    fn from(object: Object) -> Self {
        let mut file = Self {
            name: object.name,
            count: object.count,
            shape: ShapeName::Sphere,
            radius: None,
            length: None,
            tube: None,
            half_size: None,
            position: object.position,
            orientation: object.orientation,
            parent: object.parent,
            colour: object.colour,
            finish: object.finish,
            active: object.active,
        };
        match object.shape {
            Shape::Sphere { radius } => file.radius = Some(radius),
            Shape::Capsule { radius, length } => {
                file.shape = ShapeName::Capsule;
                (file.radius, file.length) = (Some(radius), Some(length));
            }
            Shape::Box { half_size } => {
                file.shape = ShapeName::Box;
                file.half_size = Some(half_size);
            }
            Shape::Ring { radius, tube } => {
                file.shape = ShapeName::Ring;
                (file.radius, file.tube) = (Some(radius), Some(tube));
            }
        }
        file
    }
}

impl Object {
    /// The names of the objects that this makes.
    pub fn names(&self) -> Vec<String> {
        expanded_names(&self.name, self.count.map(u64::from))
    }
}

/// The names that an object with this name and count makes.
pub(crate) fn expanded_names(name: &str, count: Option<u64>) -> Vec<String> {
    match count {
        None => vec![name.to_owned()],
        Some(count) => (1..=count).map(|i| format!("{name}-{i}")).collect(),
    }
}

/// What drives all bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Physics {
    /// In the field frame \[m/s²\].
    pub gravity: [f64; 3],
}

/// What is demanded of one metric. Values are in the SI unit of the metric.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limit {
    /// Its id.
    pub metric: String,
    /// Smallest value that passes.
    pub min: Option<f64>,
    /// Largest value that passes.
    pub max: Option<f64>,
    /// Value from which on the score is 100.
    pub full: Option<f64>,
    /// Value from which on the score is 0.
    pub zero: Option<f64>,
    /// Where the limit comes from.
    pub source: String,
    /// Whether it still has to be set from measurements.
    pub provisional: bool,
    /// The reason that a result names if it is not met; the metric's id if `None`.
    pub reason: Option<String>,
}

/// Parameters of the metrics that need motion alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MetricParameters {
    /// Below it a tool is idle \[m/s\].
    pub idle_speed: f64,
    /// Its upward crossings count as movements, with a hysteresis of half of it \[m/s\].
    pub movement_speed: f64,
    /// Standard deviation of the Gaussian that smooths positions before idle time, movements and bimanual metrics \[s\].
    pub smoothing: f64,
    /// Rate at which segments are sampled evenly \[Hz\].
    pub resample_rate: f64,
    /// A longer time without a valid pose splits the motion in two segments \[s\].
    pub gap: f64,
    /// Length of the shortest sensible path, for economy \[m\]; `None` if the module knows it or there is none.
    pub shortest_path: Option<f64>,
}

/// A metric that limits may name, besides those of the module itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownMetric<'a> {
    /// Its id.
    pub id: &'a str,
    /// Unit of its values.
    pub unit: Unit,
    /// Which values are good.
    pub direction: Direction,
}

/// Reads a level from a text, by the manifest of its module; `file` is the name that complaints use.
pub fn read_level(
    text: &str,
    file: &str,
    manifest: &Manifest,
    known_metrics: &[KnownMetric<'_>],
) -> Result<Loaded<Level>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &level_schema(Some(manifest)))?;
    check(&mut reading, manifest, known_metrics);
    reading.finish()
}

/// Reads the level at `path`.
pub fn load_level(
    path: &Path,
    manifest: &Manifest,
    known_metrics: &[KnownMetric<'_>],
) -> Result<Loaded<Level>, ConfigErrors> {
    let expected = format!("a level of the module `{}` (level<N>.toml)", manifest.name);
    let text = load_text(path, &expected)?;
    read_level(&text, &path.display().to_string(), manifest, known_metrics)
}
