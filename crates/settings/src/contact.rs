//! What touches what in levels and scenes: pairs, and tools that move by themselves. Everything is in SI.

use crate::tool::ToolCapsule;
use serde::{Deserialize, Serialize};

/// Two that touch each other: a body, and one of a tool, a rigid thing, another body, or itself. No other contact is computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutPair {
    /// Name of the body.
    pub body: String,
    /// The tool, with a line of no return.
    pub tool: String,
}

/// A tool of a scene: one of `config/tools`, or capsules of its own, and how it moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Serialize, Deserialize)]
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
