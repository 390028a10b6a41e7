//! `level<N>.toml`: one level of a training module: its clock, view, tools, objects, bodies, contacts, limits and the
//! module's own keys.
//!
//! Frames: the field frame is right-handed, x to the right and y away from the trainee in the picture, z up towards the
//! microscope. Everything is in SI.

use crate::body::Body;
use crate::colour::Colour;
use crate::contact::{BroadPhase, ContactPair, CutPair};
use crate::kinds::{
    dependent, file_name, identifier, own_defaults, point, quantity, rotation, size, size3, time,
    vector3,
};
use crate::method::{Accuracy, Method, Tuned};
use crate::rigid::Rigid;
use crate::schema::{Form, Kind};
use crate::table::{Setting, choices, table};
use microsim_vocabulary::{Direction, Finish, LocalText, Unit, terms};
use serde::{Deserialize, Serialize};
use serde_json::Value;

table! {
    /// One level of a training module.
    pub struct Level {
        /// Its name for people.
        title: LocalText,
        /// What changes and why it is harder, in a sentence for people.
        summary: LocalText,
        /// The two clocks of a run.
        clock: Clock,
        /// What the microscope shows.
        view: View => own_defaults(),
        /// The tools that take part.
        tool: Vec<ToolSlot> [0, 8],
        /// Virtual objects.
        object: Vec<Object> [0, 256],
        /// Tetrahedral bodies.
        body: Vec<Body> [0, 64],
        /// Obstacles: they stand.
        rigid: Vec<Rigid> [0, 64],
        /// Which body touches what: exactly one of `tool`, `rigid`, `with` (another body) and `self`; all others pass
        /// through each other.
        contact: Vec<ContactPair> [0, 256],
        /// Which tool cuts which body. Where the two also touch, tissue is pushed away until it gets over a line of no
        /// return; where they do not, the lines go through it.
        cut: Vec<CutPair> [0, 64],
        /// What drives all bodies; needed if and only if there are bodies.
        physics: Option<Physics>,
        /// How the bodies are advanced; needed if and only if there are bodies.
        method: Option<Method>,
        /// What is stated of the motion of the bodies; `microsim tune` looks for the cheapest setting that meets it.
        accuracy: Option<Accuracy>,
        /// What `microsim tune` chose and measured.
        tuned: Option<Tuned>,
        /// What is demanded; a level is passed if every limit is met.
        limit: Vec<Limit> [0, 64],
        /// Parameters of the metrics that need motion alone.
        metrics: MetricParameters => own_defaults(),
        /// What the module's manifest declares.
        module: ModuleKeys => own_defaults(),
    }
}

table! {
    /// The two clocks of a run.
    #[derive(Copy)]
    pub struct Clock {
        /// Time between two ticks, a whole number of microseconds \[s\].
        tick: f64 = time(Clock::TICK[0], Clock::TICK[1]),
        /// Steps of the solver in a tick.
        steps: u32 [Clock::STEPS[0].into(), Clock::STEPS[1].into()] => 1,
    }
}

impl Clock {
    /// Shortest and longest time between two ticks \[s\].
    pub const TICK: [f64; 2] = [0.001, 0.05];
    /// Fewest and most steps of the solver in a tick.
    pub const STEPS: [u32; 2] = [1, 1000];

    /// Time between two ticks \[µs\].
    pub fn tick_us(&self) -> u64 {
        (self.tick * 1e6).round() as u64
    }
}

table! {
    /// What the microscope shows.
    #[derive(Copy)]
    pub struct View {
        /// Diameter of the round field of view \[m\].
        field: f64 = quantity(Unit::Length, 0.001, 0.2) => 0.025,
        /// Point in the middle of the picture, in the field frame \[m\].
        centre: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Angle between the line of sight and straight down, turned towards the trainee \[rad\].
        tilt: f64 = quantity(Unit::Angle, 0.0, 80_f64.to_radians()) => 0.0,
    }
}

table! {
    /// A tool that takes part, under the name that sources and the translator use.
    pub struct ToolSlot {
        /// Slot that sources and the translator name, for example `right`.
        name: String = identifier(),
        /// Name of a file in config/tools, without its extension.
        model: String = identifier(),
    }
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
#[derive(Clone, Debug, PartialEq)]
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
    /// What a file holds, about its origin.
    Model {
        /// Name of the file.
        model: String,
        /// Metres in a unit of the file.
        scale: f64,
        /// Name of the picture on its surface, if it is not one of the file's own.
        texture: Option<String>,
    },
}

table! {
    /// An object as the file has it: the sizes that its shape needs are checked before.
    pub(crate) struct ObjectFile {
        /// Its name, or the beginning of its names if there is a `count`.
        name: String = identifier(),
        /// Makes that many equal objects, named NAME-1, NAME-2 and so on.
        count: Option<u32> [1, 256],
        /// Its form.
        shape: ShapeName,
        /// Of a sphere, capsule or ring, and only there \[m\]; of a ring to the middle of its tube.
        radius: Option<f64> = size(),
        /// Of a capsule, and only there \[m\]: between the centres of its ends, along its z axis.
        length: Option<f64> = size(),
        /// Of a ring, and only there \[m\]: radius of its tube. The ring lies around its z axis.
        tube: Option<f64> = size(),
        /// Of a box, and only there \[m\]: half of each side.
        half_size: Option<[f64; 3]> = size3(),
        /// Of a model, and only there: its file, which is looked for in the folder `assets` of the module, then in that of the installation.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        model: Option<String> = file_name(),
        /// Of a model, and only there: metres in a unit of its file; 1 if left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<f64> = quantity(Unit::Ratio, 1e-6, 1e3),
        /// Of a model with texture coordinates, and only there: the file of a picture, in the place of its own.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        texture: Option<String> = file_name(),
        /// Of its centre, in the frame of the parent \[m\].
        position: [f64; 3] = point() => [0.0, 0.0, 0.0],
        /// Rotation [x, y, z, w] from its own frame to that of the parent.
        orientation: [f64; 4] = rotation() => [0.0, 0.0, 0.0, 1.0],
        /// Object in whose frame its pose is given; the field frame if left out.
        parent: Option<String> = identifier(),
        /// Colour, sRGB.
        colour: Colour => "#c8c8c8",
        /// How its surface answers light.
        finish: Finish => "matte",
        /// Whether it is there from the start.
        active: bool => true,
    }
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
        /// Triangles from a file.
        Model = "model",
    }
}

choices!(ShapeName);

impl Setting for Object {
    fn kind() -> Kind {
        ObjectFile::kind()
    }
}

impl TryFrom<ObjectFile> for Object {
    type Error = String;

    fn try_from(file: ObjectFile) -> Result<Self, String> {
        let sizes = (file.radius, file.length, file.tube, file.half_size);
        let of_file = (file.model, file.scale, file.texture);
        let is_model = file.shape == ShapeName::Model;
        let shape = match (file.shape, sizes) {
            (ShapeName::Model, (None, None, None, None)) if of_file.0.is_some() => Shape::Model {
                model: of_file.0.unwrap_or_default(),
                scale: of_file.1.unwrap_or(1.0),
                texture: of_file.2,
            },
            _ if is_model || of_file != (None, None, None) => {
                return Err(format!("keys of `{}` that do not fit its shape", file.name));
            }
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
            model: None,
            scale: None,
            texture: None,
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
            Shape::Model {
                model,
                scale,
                texture,
            } => {
                file.shape = ShapeName::Model;
                (file.model, file.texture) = (Some(model), texture);
                file.scale = Some(scale).filter(|scale| *scale != 1.0);
            }
        }
        file
    }
}

impl Object {
    /// Files of its shape, with the keys that name them.
    pub fn files(&self) -> Vec<(&'static str, &str)> {
        let Shape::Model { model, texture, .. } = &self.shape else {
            return Vec::new();
        };
        let texture = texture.as_deref().map(|texture| ("texture", texture));
        std::iter::once(("model", &model[..]))
            .chain(texture)
            .collect()
    }

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

table! {
    /// What drives all bodies.
    #[derive(Copy)]
    pub struct Physics {
        /// Acceleration of free fall, in the field frame \[m/s²\].
        gravity: [f64; 3] = vector3(Unit::Acceleration, 100.0) => [0.0, 0.0, -9.81],
        /// How features that may touch are found. Contacts and their bits are the same with each.
        #[serde(default = "BroadPhase::initial", skip_serializing_if = "BroadPhase::is_default")]
        broad_phase: BroadPhase => "bvh",
        /// Edge of a cell of the spatial hash, and only there \[m\]; left out: the mean edge of the mesh for tetrahedra, twice that for triangles.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        cell_size: Option<f64> = quantity(Unit::Length, 1e-9, 1.0),
        /// Whether tools touch each other; else they pass through each other.
        tools_touch: bool => false,
        /// The largest force with which the hand pushes a tool against what it touches \[N\]: beyond, the tool stays behind the hand.
        hand_force: f64 = quantity(Unit::Force, 0.01, 1e3) => 1.0,
        /// The work that a tick may take over its length, counted in operations of a core of a usual kind; half of it is for repetitions. What does not fit is left to the next tick: tools
        /// follow the hand as far as it goes.
        budget: f64 = quantity(Unit::Ratio, 0.01, 1000.0) => 3.0,
        /// The work that ticks may take over their length in their mean: what they take more for long, the next ones may take less.
        mean_budget: f64 = quantity(Unit::Ratio, 0.01, 1000.0) => 0.5,
    }
}

table! {
    /// What is demanded of one metric. Values are in the SI unit of the metric.
    pub struct Limit {
        /// Id of the metric: one that every level has, or one of the module.
        metric: String = identifier(),
        /// Smallest value that passes, in the metric's unit.
        min: Option<f64> = dependent("a value in the metric's unit"),
        /// Largest value that passes, in the metric's unit.
        max: Option<f64> = dependent("a value in the metric's unit"),
        /// Value from which on the score is 100; needs `zero`.
        full: Option<f64> = dependent("a value in the metric's unit"),
        /// Value from which on the score is 0; needs `full`.
        zero: Option<f64> = dependent("a value in the metric's unit"),
        /// Where the limit comes from.
        source: String,
        /// Whether it still has to be set from measurements.
        provisional: bool => true,
        /// Whether a value beyond it stands against a pass. Otherwise it is a reference value: shown and scored, and nothing more. For metrics
        /// that depend on the computation as much as on the hand.
        decides: bool => true,
        /// The module's reason that a result names if it is not met; the metric's id if left out.
        reason: Option<String> = identifier(),
    }
}

table! {
    /// Parameters of the metrics that need motion alone.
    #[derive(Copy)]
    pub struct MetricParameters {
        /// Below it a tool is idle \[m/s\].
        idle_speed: f64 = quantity(Unit::Speed, 1e-6, 1.0) => 0.0001,
        /// Its upward crossings count as movements, with a hysteresis of half of it \[m/s\].
        movement_speed: f64 = quantity(Unit::Speed, 1e-6, 1.0) => 0.001,
        /// Standard deviation of the Gaussian that smooths positions before movements and the correlation of speeds \[s\].
        smoothing: f64 = time(0.0, 1.0) => 0.05,
        /// The same before the idle and the bimanual fraction \[s\]: what is left of tremor has to be slower than `idle_speed`.
        idle_smoothing: f64 = time(0.0, 1.0) => 0.08,
        /// Rate at which segments are sampled evenly \[Hz\].
        resample_rate: f64 = quantity(Unit::Frequency, 60.0, 1000.0) => 60.0,
        /// A longer time without a valid pose splits the motion in two segments \[s\].
        gap: f64 = time(0.001, 10.0) => 0.1,
        /// Length of the shortest sensible path, for economy \[m\]; left out if the module knows it or there is none.
        shortest_path: Option<f64> = quantity(Unit::Length, 0.0, 10.0),
    }
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

/// The values of a table `[module]` by their keys, in SI: what they may be is known from the manifest of the module.
pub type ModuleKeys = serde_json::Map<String, Value>;

impl Setting for ModuleKeys {
    fn kind() -> Kind {
        Kind::Map {
            keys: Form::Symbol,
            of: Box::new(dependent(
                "a value of the kind that the module's manifest declares",
            )),
        }
    }
}
