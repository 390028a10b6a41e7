//! Why a scene cannot be built or run.

use microsim_mesh::BlockError;
use microsim_tissue::{MaterialError, ModelError};

/// Why a scene cannot be built or run. Each text says which part is meant and what is expected.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneError {
    /// Two bodies or two tools have one name, or a name is empty.
    Name {
        /// `body` or `tool`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// The mesh of a body cannot be generated.
    Mesh {
        /// The body.
        body: String,
        /// Why.
        source: BlockError,
    },
    /// A material value is out of range.
    Material {
        /// The body.
        body: String,
        /// Which value.
        source: MaterialError,
    },
    /// The model of a body cannot be built.
    Model {
        /// The body.
        body: String,
        /// Why.
        source: ModelError,
    },
    /// A clamp box holds no node, is turned inside out or not finite.
    Clamp {
        /// The body.
        body: String,
        /// Index of the box.
        index: usize,
    },
    /// A tool has no part, or a part with numbers that are not finite, no radius, or a hinge without direction.
    Tool {
        /// The tool.
        tool: String,
        /// Index of the part; `None` when there is none.
        part: Option<usize>,
    },
    /// A contact pair names something that is not in the scene, or stands twice.
    ContactPair {
        /// The tool's name.
        tool: String,
        /// The body's name.
        body: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// Gravity is not finite.
    Gravity,
    /// The tick is not a positive time.
    Tick {
        /// The tick [s].
        tick_s: f64,
    },
    /// The solver's step is beyond what a body allows.
    StepTooLong {
        /// The body that needs the shortest step.
        body: String,
        /// The step that was asked for [s].
        step_s: f64,
        /// The longest stable step with its safety factor [s].
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
                    "each {kind} needs a name of its own, '{name}' is empty or stands twice"
                )
            }
            Self::Mesh { body, source } => write!(f, "body '{body}': {source}"),
            Self::Material { body, source } => write!(f, "material of body '{body}': {source}"),
            Self::Model { body, source } => write!(f, "body '{body}': {source}"),
            Self::Clamp { body, index } => write!(
                f,
                "clamp {index} of body '{body}' holds no node (boxes are in the body's frame, min must not exceed max)"
            ),
            Self::Tool { tool, part: None } => write!(f, "tool '{tool}' has no capsule"),
            Self::Tool {
                tool,
                part: Some(part),
            } => write!(
                f,
                "capsule {part} of tool '{tool}' needs finite ends, a radius above 0 m and a hinge axis that is not zero"
            ),
            Self::ContactPair { tool, body, reason } => {
                write!(f, "contact pair ('{tool}', '{body}'): {reason}")
            }
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
