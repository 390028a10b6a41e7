//! What touches what in levels and scenes: rigid things that stand, tools that move by themselves, pairs.
//!
//! Frames: a rigid thing lies in the frame of its level or scene by `position` and `orientation`, about its centre unless its
//! shape says otherwise. Everything is in SI.

use crate::text::{Colour, Finish};
use crate::tool::ToolCapsule;
use serde::Deserialize;

/// Two that touch each other: a body, and one of a tool, a rigid thing, another body, or itself. No other contact is computed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactPair {
    /// Name of the body.
    pub body: String,
    /// The tool that touches it.
    pub tool: Option<String>,
    /// The rigid thing that it touches.
    pub rigid: Option<String>,
    /// The other body that it touches.
    pub with: Option<String>,
    /// Whether it touches itself.
    #[serde(rename = "self")]
    pub itself: bool,
    /// Coefficient of Coulomb friction, for sticking and for sliding.
    pub friction: f64,
    /// For the ends of two vessels: whether a node that is beyond the plane of the other one's open end is led back along its axis.
    pub end_planes: bool,
    /// Size of the force from which on time is counted \[N\].
    pub force_limit: Option<f64>,
}

impl ContactPair {
    /// Whom the body touches, as a name for people.
    pub fn partner(&self) -> &str {
        let named = self.tool.as_ref().or(self.rigid.as_ref());
        named
            .or(self.with.as_ref())
            .map_or("itself", String::as_str)
    }
}

/// A tool that cuts a body. Where the two also touch, tissue is pushed away until it gets over a line of no return; where they do not, the
/// lines go through it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutPair {
    /// Name of the body.
    pub body: String,
    /// The tool, with a line of no return.
    pub tool: String,
}

/// A rigid thing that stands.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "RigidFile")]
pub struct Rigid {
    /// Its name.
    pub name: String,
    /// Form and size.
    pub shape: RigidShape,
    /// Of its centre \[m\].
    pub position: [f64; 3],
    /// Rotation x, y, z, w from its own frame.
    pub orientation: [f64; 4],
    /// Colour.
    pub colour: Colour,
    /// How its surface answers light.
    pub finish: Finish,
}

/// Form and size of a rigid thing in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidShape {
    /// Everything below z = 0.
    Plane,
    /// A box along its axes.
    Box {
        /// Half of each side \[m\].
        half_size: [f64; 3],
        /// Radius of its edges and corners, within the box \[m\].
        rounding: f64,
    },
    /// A floor and four walls around an inner space that is open towards +z.
    Tray {
        /// Half of each side of the inner space \[m\].
        half_size: [f64; 3],
        /// Thickness of floor and walls \[m\].
        wall: f64,
        /// Radius of the edges of floor and walls \[m\].
        rounding: f64,
    },
    /// Two equal plates that face each other along x.
    Clamp {
        /// Half of each side of a plate \[m\].
        half_size: [f64; 3],
        /// Between the plates \[m\].
        gap: f64,
        /// Radius of the edges of the plates \[m\].
        rounding: f64,
    },
    /// A solid cylinder along z.
    Cylinder {
        /// \[m\]
        radius: f64,
        /// From end to end \[m\].
        length: f64,
    },
}

impl RigidShape {
    /// As files write them.
    pub const NAMES: [&str; 5] = ["plane", "box", "tray", "clamp", "cylinder"];
}

/// A rigid thing as the file has it: the sizes that its shape needs are checked before.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RigidFile {
    name: String,
    shape: String,
    half_size: Option<[f64; 3]>,
    rounding: Option<f64>,
    wall: Option<f64>,
    gap: Option<f64>,
    radius: Option<f64>,
    length: Option<f64>,
    position: [f64; 3],
    orientation: [f64; 4],
    colour: Colour,
    finish: Finish,
}

impl TryFrom<RigidFile> for Rigid {
    type Error = String;

    fn try_from(file: RigidFile) -> Result<Self, String> {
        let rounding = file.rounding.unwrap_or(0.0);
        let sizes = (
            file.half_size,
            file.wall,
            file.gap,
            file.radius,
            file.length,
        );
        let shape = match (file.shape.as_str(), sizes) {
            ("plane", (None, None, None, None, None)) => RigidShape::Plane,
            ("box", (Some(half_size), None, None, None, None)) => RigidShape::Box {
                half_size,
                rounding,
            },
            ("tray", (Some(half_size), Some(wall), None, None, None)) => RigidShape::Tray {
                half_size,
                wall,
                rounding,
            },
            ("clamp", (Some(half_size), None, Some(gap), None, None)) => RigidShape::Clamp {
                half_size,
                gap,
                rounding,
            },
            ("cylinder", (None, None, None, Some(radius), Some(length))) => {
                RigidShape::Cylinder { radius, length }
            }
            _ => {
                return Err(format!(
                    "sizes of `{}` that do not fit its shape",
                    file.name
                ));
            }
        };
        Ok(Rigid {
            name: file.name,
            shape,
            position: file.position,
            orientation: file.orientation,
            colour: file.colour,
            finish: file.finish,
        })
    }
}

/// A tool of a scene: one of `config/tools`, or capsules of its own, and how it moves.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneTool {
    /// Its name.
    pub name: String,
    /// Name of a file of `config/tools`, without its extension; `None` with capsules of its own.
    pub model: Option<String>,
    /// Its own capsules; empty with a model.
    pub capsule: Vec<ToolCapsule>,
    /// A point of the axis about which its own jaws turn, along y \[m\].
    pub hinge: Option<[f64; 3]>,
    /// Angle between its own jaws when fully open \[rad\].
    pub opening_angle: Option<f64>,
    /// How sharp its own capsules are, from 0 to 1; that of a model is the model's.
    pub sharpness: f64,
    /// Where it is, by ascending time. It stands before the first and after the last key.
    pub motion: Vec<ToolKey>,
}

/// Where a tool is at a time; between two keys its position and opening are interpolated linearly, its orientation along the
/// shortest turn at constant speed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "ToolKeyFile")]
pub struct ToolKey {
    /// \[s\]
    pub time: f64,
    /// Of the tool's origin \[m\].
    pub position: [f64; 3],
    /// Rotation x, y, z, w: scene from tool.
    pub orientation: [f64; 4],
    /// From 0 closed to 1 open.
    pub opening: f64,
}

/// A key as the file has it: with an orientation, with axis and angle, or unturned.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ToolKeyFile {
    time: f64,
    position: [f64; 3],
    orientation: Option<[f64; 4]>,
    axis: Option<[f64; 3]>,
    angle: Option<f64>,
    opening: f64,
}

impl TryFrom<ToolKeyFile> for ToolKey {
    type Error = &'static str;

    fn try_from(file: ToolKeyFile) -> Result<Self, Self::Error> {
        let orientation = match (file.orientation, file.axis, file.angle) {
            (None, None, None) => [0.0, 0.0, 0.0, 1.0],
            (Some(orientation), None, None) => orientation,
            (None, Some([x, y, z]), Some(angle)) => {
                let (sine, cosine) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
                [x * sine, y * sine, z * sine, cosine]
            }
            _ => return Err("either `orientation`, or `axis` and `angle`"),
        };
        Ok(Self {
            time: file.time,
            position: file.position,
            orientation,
            opening: file.opening,
        })
    }
}
