//! Why a scene cannot be built or run.

use microsim_tissue::elements::CoupleError;
use microsim_tissue::{BuildError, MethodError};

/// Why a scene cannot be built or run. Each text names the part that is meant and what is expected.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneError {
    /// Two bodies, tools or obstacles have one name, or a name is empty.
    Name {
        /// `body`, `tool` or `obstacle`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// The model of a body cannot be built.
    Build {
        /// The body.
        body: String,
        /// Why.
        source: BuildError,
    },
    /// A value of a body cannot be computed with.
    Value {
        /// The body.
        body: String,
        /// Where: `origin`, `cutting`, `clamp`, `load`, `start`.
        what: &'static str,
        /// Index among those.
        index: usize,
        /// What is wrong, or what is expected.
        reason: &'static str,
    },
    /// Two clamps hold one node, and at least one of them moves.
    HeldTwice {
        /// The body.
        body: String,
        /// Indices of the clamps.
        clamps: [usize; 2],
    },
    /// The method is stable at no step for a body.
    NeverStable {
        /// The body.
        body: String,
        /// The method.
        method: &'static str,
    },
    /// Two regions of a body cannot be coupled.
    Couple {
        /// The body.
        body: String,
        /// Why.
        source: CoupleError,
    },
    /// A body with residual stress has no equilibrium to begin in.
    Prestretch {
        /// The body.
        body: String,
        /// Why.
        reason: PrestretchError,
    },
    /// A selection of a body holds no node, or none of its surface.
    Empty {
        /// The body.
        body: String,
        /// What selects: `clamp`, `load`, `start`.
        what: &'static str,
        /// Index among those.
        index: usize,
    },
    /// The method cannot treat a body.
    Method {
        /// The body.
        body: String,
        /// Why.
        source: MethodError,
    },
    /// The method cannot treat a body that is touched.
    Contact {
        /// The body.
        body: String,
        /// The method.
        method: &'static str,
    },
    /// The method cannot prescribe the nodes of a clamp that is released.
    Grip {
        /// The body.
        body: String,
        /// The method.
        method: &'static str,
    },
    /// A tool has no part, or a part with numbers that are not finite, no radius, or an edge without direction.
    Tool {
        /// The tool.
        tool: String,
        /// Index of the part; `None` when there is none.
        part: Option<usize>,
    },
    /// The lumen of a body has no wall, no axis, no length or no section.
    Lumen {
        /// The body.
        body: String,
    },
    /// The fluid of a tool has numbers that are not finite, a negative pressure, no direction, no radius or no reach.
    Irrigation {
        /// The tool.
        tool: String,
    },
    /// A tool's motion has times that do not ascend, or numbers that are not finite.
    ToolMotion {
        /// The tool.
        tool: String,
        /// Index of the key.
        key: usize,
    },
    /// An obstacle has no part, or a part with numbers that are not finite or sizes that are none.
    Obstacle {
        /// The obstacle.
        name: String,
    },
    /// A contact pair names something that is not in the scene, occurs twice, or has a number out of range.
    Contacts {
        /// Index of the pair.
        index: usize,
        /// The body's name.
        body: String,
        /// The partner's name.
        with: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A cut names something that is not in the scene, occurs twice, or cannot be.
    Cuts {
        /// Index of the cut.
        index: usize,
        /// The body's name.
        body: String,
        /// The tool's name.
        tool: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// Gravity is not finite.
    Gravity,
    /// The tick is not a positive time.
    Tick {
        /// The tick \[s\].
        tick_s: f64,
    },
    /// The solver's step is beyond what a body allows.
    StepTooLong {
        /// The body that needs the shortest step.
        body: String,
        /// The step that was asked for \[s\].
        step_s: f64,
        /// The longest stable step with its safety factor \[s\].
        stable_step_s: f64,
        /// Steps per tick that are enough.
        required_steps: u32,
    },
}

impl std::fmt::Display for SceneError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Name { kind, name } => {
                write!(
                    f,
                    "each {kind} needs a name of its own, '{name}' is empty or occurs twice"
                )
            }
            Self::Build { body, source } => write!(f, "body '{body}': {source}"),
            Self::Value {
                body,
                what,
                index,
                reason,
            } => {
                write!(f, "{what} {index} of body '{body}': {reason}")
            }
            Self::HeldTwice {
                body,
                clamps: [first, second],
            } => write!(
                f,
                "clamps {first} and {second} of body '{body}' have a common node, and one of them moves: let each node have one clamp"
            ),
            Self::NeverStable { body, method } => write!(
                f,
                "{method} is stable at no step for body '{body}': give it drag, or use another method"
            ),
            Self::Couple { body, source } => write!(f, "coupling in body '{body}': {source}"),
            Self::Prestretch { body, reason } => {
                write!(f, "residual state of body '{body}': {reason}")
            }
            Self::Empty { body, what, index } => write!(
                f,
                "{what} {index} of body '{body}' holds nothing of it (places are in the body's frame, min must not exceed max)"
            ),
            Self::Method { body, source } => write!(f, "body '{body}': {source}"),
            Self::Contact { body, method } => write!(
                f,
                "body '{body}' is touched, and {method} cannot enforce non-penetration: its force moves a node one step later only; use another method, or contact by penalty"
            ),
            Self::Grip { body, method } => write!(
                f,
                "a clamp of body '{body}' is released, and {method} cannot prescribe nodes: use another method"
            ),
            Self::Tool { tool, part: None } => write!(
                f,
                "tool '{tool}' needs at least one capsule and a sharpness from 0 to 1"
            ),
            Self::Tool {
                tool,
                part: Some(part),
            } => write!(
                f,
                "capsule {part} of tool '{tool}' needs finite ends and a finite joint, a radius above 0 m, an edge that is not zero, and a line of no return a length"
            ),
            Self::Lumen { body } => write!(
                f,
                "the lumen of body '{body}' needs triangles, an axis that is not zero, a length along it, and at least one section"
            ),
            Self::Irrigation { tool } => write!(
                f,
                "the fluid of tool '{tool}' needs a finite position, a direction that is not zero, a pressure of at least 0 Pa, and a radius and a reach above 0 m"
            ),
            Self::ToolMotion { tool, key } => write!(
                f,
                "key {key} of the motion of tool '{tool}' needs finite numbers and a time after that of the key before"
            ),
            Self::Obstacle { name } => write!(
                f,
                "obstacle '{name}' needs parts with finite numbers, sizes above 0 m and a rounding within them"
            ),
            Self::Contacts {
                body, with, reason, ..
            } => {
                write!(f, "contact of body '{body}' with '{with}': {reason}")
            }
            Self::Cuts {
                body, tool, reason, ..
            } => write!(f, "cut of body '{body}' by '{tool}': {reason}"),
            Self::Gravity => write!(f, "gravity must be three finite numbers in m/s²"),
            Self::Tick { tick_s } => write!(f, "a tick must be longer than 0 s, not {tick_s} s"),
            Self::StepTooLong {
                body,
                step_s,
                stable_step_s,
                required_steps,
            } => write!(
                f,
                "a step of {:.3} µs is beyond the stability limit of body '{body}', {:.3} µs: use at least {required_steps} steps per tick",
                step_s * 1e6,
                stable_step_s * 1e6
            ),
        }
    }
}

impl std::error::Error for SceneError {}

/// Why a body with prestretches has no equilibrium to begin in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrestretchError {
    /// Nothing holds a part of it.
    Loose,
    /// None was found.
    NotFound,
    /// Its nodes are far from their places in the mesh.
    Shift {
        /// The largest distance \[m\].
        shift: f64,
        /// Mean edge of the mesh \[m\].
        edge: f64,
    },
}

impl std::fmt::Display for PrestretchError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Loose => write!(
                f,
                "nothing holds a part of it at the start; expected are clamps that hold the ends of what is prestretched"
            ),
            Self::NotFound => write!(
                f,
                "no equilibrium was found with its clamps and loads at the start; expected is a pressure on the lumen that is its \
                 `transmural_pressure`, and clamps that bear the axial stretch"
            ),
            Self::Shift { shift, edge } => write!(
                f,
                "in equilibrium with its clamps and loads at the start nodes are up to {:.4} mm beside their places, edges are {:.4} mm long; \
                 expected is at most half an edge: clamps that hold both ends, and a load on the lumen with the `transmural_pressure` and no ramp",
                1e3 * shift,
                1e3 * edge
            ),
        }
    }
}

impl std::error::Error for PrestretchError {}
