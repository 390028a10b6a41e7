//! `config/scenes/NAME.toml`: physics alone. Bodies, materials, loads, method, what is watched and what must come out: the
//! same file is a demonstration, a test and a benchmark.
//!
//! Frame: the world's, right-handed, z up. Everything is in SI.

use crate::body::{Body, Nodes};
use crate::contact::{BroadPhase, ContactPair, CutPair, SceneTool};
use crate::kinds::{
    dependent, direction, english_text, identifier, own_defaults, point, quantity, time, vector3,
};
use crate::level::View;
use crate::method::{Accuracy, Method, Tuned};
use crate::rigid::Rigid;
use crate::table::{choices, table};
use microsim_vocabulary::{LocalText, Unit, terms};

table! {
    /// A scene.
    pub struct Scene {
        /// Its name for people.
        title: LocalText = english_text(),
        /// What it shows, in a sentence for people.
        summary: LocalText = english_text(),
        /// How long, in which steps.
        run: SceneRun,
        /// What pictures show; all bodies as they lie at the start without it.
        view: Option<View>,
        /// How the bodies are advanced.
        method: Method,
        /// Tetrahedral bodies.
        body: Vec<Body> [1, 64],
        /// Tools and how they move.
        tool: Vec<SceneTool> [0, 8],
        /// Obstacles: they stand.
        rigid: Vec<Rigid> [0, 64],
        /// Which body touches what: exactly one of `tool`, `rigid`, `with` (another body) and `self`; all others pass
        /// through each other.
        contact: Vec<ContactPair> [0, 256],
        /// Which tool cuts which body. Where the two also touch, tissue is pushed away until it gets over a line of no
        /// return; where they do not, the lines go through it.
        cut: Vec<CutPair> [0, 64],
        /// What is watched: a number each, sampled into the series.
        probe: Vec<Probe> [0, 64],
        /// What must come out, and where that is known from.
        expect: Vec<Expect> [0, 64],
        /// What is stated of the result; `microsim tune` looks for the cheapest setting that meets it.
        accuracy: Option<Accuracy>,
        /// Why no error is stated under `accuracy`, in a sentence.
        no_stated_error: Option<String>,
        /// What `microsim tune` chose and measured.
        tuned: Option<Tuned>,
    }
}

table! {
    /// How long a scene runs, and in which steps.
    #[derive(Copy)]
    pub struct SceneRun {
        /// Simulated time \[s\]; with `end = "rest"` the longest.
        duration: f64 = time(1e-6, 6e3),
        /// Step of the solver \[s\]; shortened so that a whole number fits between two samples.
        step: f64 = time(1e-9, 600.0),
        /// Time between two samples of the series \[s\]; a longer step takes its place.
        sample: f64 = time(1e-9, 600.0) => 0.001,
        /// Time between two exported meshes (--vtu) \[s\]; a longer sample takes its place.
        frame: f64 = time(1e-9, 6e3) => 0.02,
        /// When it ends: after its `duration`, when it has come to `rest`, or with the `divergence` of a body, which is then what has to come out.
        end: End => "time",
        /// It rests when no node moved faster than this over a whole sample \[m/s\]; with `end = "rest"`, and only
        /// there.
        rest_speed: Option<f64> = quantity(Unit::Speed, 1e-12, 1.0),
        /// Acceleration of free fall \[m/s²\].
        gravity: [f64; 3] = vector3(Unit::Acceleration, 100.0) => [0.0, 0.0, -9.81],
        /// How features that may touch are found. Contacts and their bits are the same with each.
        #[serde(default = "BroadPhase::initial", skip_serializing_if = "BroadPhase::is_default")]
        broad_phase: BroadPhase => "bvh",
        /// Edge of a cell of the spatial hash, and only there \[m\]; left out: the mean edge of the mesh for tetrahedra, twice that for triangles.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        cell_size: Option<f64> = quantity(Unit::Length, 1e-9, 1.0),
        /// Whether tools touch each other; else they pass through each other.
        tools_touch: bool => false,
        /// The largest force with which a hand pushes a tool against what it touches \[N\]: beyond, the tool stays behind. Any if it is left out.
        hand_force: Option<f64> = quantity(Unit::Force, 0.01, 1e3),
        /// Whether a body that diverges is rolled back and computed again with shorter steps; without it the run ends
        /// there, unless it is only that an implicit step did not converge.
        containment: bool => false,
    }
}

terms! {
    /// When a scene ends.
    pub enum End {
        /// After its duration.
        Time = "time",
        /// When no node has been faster than the speed of rest over a whole sample.
        Rest = "rest",
        /// When a body has diverged, which a scene of a failing method expects within its duration.
        Divergence = "divergence",
    }
}

table! {
    /// A number that is sampled into the series.
    pub struct Probe {
        /// Its name.
        name: String = identifier(),
        /// The body.
        body: String = identifier(),
        /// Nodes of the body: all, or those that fulfil every condition that is given.
        nodes: Nodes => own_defaults(),
        /// The other side: a tool, obstacle or body of a contact-force, a tool of a grip, a body of a gap or of
        /// crossings, and only there.
        with: Option<String> = identifier(),
        /// What of them: mean `displacement`, that of the `centre` of mass, mean change of the `radius`, largest
        /// `distance` from rest, `force` or `torque` with which clamps hold those that they hold now, relative change
        /// of the body's `volume`, `smallest-volume` of an element relative to that at rest, total `energy`;
        /// `contact-force` of the other side, `grip`, the force with which both jaws of a tool squeeze it between
        /// them, `gap` to the other body, fraction of nodes `inside` what the body touches and the `depth` of the
        /// deepest, or of the deepest point of an edge or a face in a tool, `crossings` of edges of its surface and the
        /// other body's with triangles; number of `pieces` that the body has come apart into.
        quantity: Quantity,
        /// Of a displacement, centre, force, contact-force or gap, and only there.
        direction: Option<[f64; 3]> = direction(),
        /// A point of the axis of a radius or torque, in the body's frame \[m\]; its origin if left out.
        point: Option<[f64; 3]> = point(),
        /// Axis of a radius or torque, and only there.
        axis: Option<[f64; 3]> = direction(),
    }
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
        /// Smallest volume of an element, relative to that at rest; negative for an inverted one.
        SmallestVolume = "smallest-volume",
        /// Kinetic, elastic and potential energy of the body, the last one 0 at rest.
        Energy = "energy",
        /// Force of another side on the body along a direction, mean over the sample before.
        ContactForce = "contact-force",
        /// Sum of the sizes of the normal forces of a tool's jaws on the body, mean over the sample before.
        Grip = "grip",
        /// How far another body is ahead of this one along a direction: its least coordinate less the largest one of the nodes.
        Gap = "gap",
        /// Fraction of the nodes that are inside other bodies, tools and obstacles that the body touches.
        Inside = "inside",
        /// Depth of the deepest of these, or of the deepest point of an edge or a face in a tool.
        Depth = "depth",
        /// Number of edges of the body's surface through triangles of another body's, and the reverse.
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

table! {
    /// What must come out of a probe.
    pub struct Expect {
        /// Name of the probe.
        probe: String = identifier(),
        /// What of its series: the value `at-end`, the `largest`, the `spread` from smallest to largest, the
        /// `first-peak` or its `first-peak-time`, the `frequency` with which it crosses its middle.
        what: Feature,
        /// The right value.
        value: f64 = dependent("a value in the unit of what is expected"),
        /// Largest error that is right, relative to `scale`.
        tolerance: f64 = quantity(Unit::Ratio, 1e-15, 10.0),
        /// What errors are relative to; the size of `value` if left out.
        scale: Option<f64> = dependent("a value in the unit of what is expected"),
        /// A first peak counts when the curve has stayed below it for this time \[s\].
        fall_time: f64 = time(0.0, 600.0) => 0.05,
        /// Whether the value is the simulator's own output, of finer steps or of an earlier version, and not known from elsewhere: it shows
        /// that nothing has changed, not that it is right.
        regression: bool => false,
        /// Where value and tolerance come from, in a sentence.
        source: String,
    }
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

choices!(End, Feature, Quantity);
