//! What touches what in levels and scenes: pairs, and tools that move by themselves. Everything is in SI.

use crate::kinds::{direction, identifier, point, quantity, ratio, rotation, time};
use crate::schema::Kind;
use crate::table::{Setting, choices, table};
use crate::tool::{Irrigation, ToolCapsule, jaw_angle, tool_point};
use microsim_vocabulary::{Unit, terms};
use serde::{Deserialize, Serialize};

table! {
    /// Two that touch each other: a body, and one of a tool, an obstacle, another body, or itself. No other contact is computed.
    pub struct ContactPair {
        /// Name of the body.
        body: String = identifier(),
        /// The tool that touches it.
        tool: Option<String> = identifier(),
        /// The obstacle that it touches.
        rigid: Option<String> = identifier(),
        /// The other body that it touches.
        with: Option<String> = identifier(),
        /// Whether the body touches itself, where it is folded.
        itself as "self": bool => false,
        /// Coefficient of Coulomb friction, for sticking and for sliding.
        friction: f64 = ratio(10.0) => 0.0,
        /// For the open ends of two vessels, and only with `with`: whether nodes beyond the plane of the other end
        /// are moved back along its axis.
        end_planes: bool => false,
        /// Size of the force, mean over the last 50 ms, from which on time is counted \[N\].
        force_limit: Option<f64> = quantity(Unit::Force, 0.0, 1e3),
        /// How penetration is prevented or undone. All but `constraint` are those of the dissertation (4.3), for explicit methods, without friction.
        #[serde(default = "ContactResponse::initial", skip_serializing_if = "ContactResponse::is_default")]
        response: ContactResponse => "constraint",
        /// Stiffness of a penalty, and only there \[N/m\].
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stiffness: Option<f64> = quantity(Unit::LengthStiffness, 1e-6, 1e6),
        /// How deep nodes in another body are, of a penalty or target force; left out: consistent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        depth: Option<PenetrationDepth>,
        /// How jaws hold the body, and only with `tool`: by friction, or by the box between their lines of no return (dissertation 4.4.2), for explicit methods.
        #[serde(default = "Grip::initial", skip_serializing_if = "Grip::is_default")]
        grip: Grip => "friction",
    }
}

terms! {
    /// How jaws hold a body.
    pub enum Grip {
        /// By the friction of contact alone.
        Friction = "friction",
        /// What lies in the box between the jaws' lines of no return moves with the jaws.
        Box = "box",
    }
}

terms! {
    /// How penetration is prevented or undone.
    pub enum ContactResponse {
        /// All contacts together, found along the whole step.
        Constraint = "constraint",
        /// Springs to the surface midway between.
        Penalty = "penalty",
        /// Forces that bring each node to the surface by themselves.
        TargetForce = "target-force",
    }
}

terms! {
    /// How deep a node in another body is.
    pub enum PenetrationDepth {
        /// To the nearest point of the surface.
        Nearest = "nearest",
        /// By where the edges around came in (Heidelberger et al. 2004).
        Consistent = "consistent",
    }
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

terms! {
    /// How features of surfaces whose boxes overlap are found.
    pub enum BroadPhase {
        /// A hierarchy of boxes, refitted as nodes move.
        Bvh = "bvh",
        /// Spatial hashing (dissertation 4.3).
        SpatialHash = "spatial-hash",
        /// Every box is compared with every other.
        AllPairs = "all-pairs",
    }
}

terms! {
    /// How a mesh changes where it is cut.
    pub enum CutTopology {
        /// Elements that are cut are taken away.
        Remove = "remove",
        /// The mesh comes apart at the faces nearest to the cut.
        SplitAtFaces = "split-at-faces",
        /// Elements are divided when the blade has left them (dissertation 4.2.1).
        SemiProgressive = "semi-progressive",
        /// Elements are divided in the step in which the blade comes to them.
        Progressive = "progressive",
    }
}

terms! {
    /// When tissue that a tool presses on gets over a line of no return.
    pub enum CutTrigger {
        /// When the force of contact is more than it bears; of two jaws, when they have closed.
        Force = "force",
        /// When it lies behind the line, as far as contact lets it into the capsule (dissertation 4.4.3).
        Penetration = "penetration",
    }
}

choices!(
    BroadPhase,
    ContactResponse,
    CutTopology,
    CutTrigger,
    Grip,
    PenetrationDepth
);

// What was recorded before there were these keys has their defaults, and has the digest of then.
impl BroadPhase {
    pub(crate) fn initial() -> Self {
        Self::Bvh
    }

    pub(crate) fn is_default(&self) -> bool {
        *self == Self::initial()
    }
}

impl Grip {
    pub(crate) fn initial() -> Self {
        Self::Friction
    }

    pub(crate) fn is_default(&self) -> bool {
        *self == Self::initial()
    }
}

impl CutTopology {
    pub(crate) fn initial() -> Self {
        Self::Progressive
    }

    pub(crate) fn is_default(&self) -> bool {
        *self == Self::initial()
    }
}

impl CutTrigger {
    pub(crate) fn initial() -> Self {
        Self::Force
    }

    pub(crate) fn is_default(&self) -> bool {
        *self == Self::initial()
    }
}

impl ContactResponse {
    pub(crate) fn initial() -> Self {
        Self::Constraint
    }

    pub(crate) fn is_default(&self) -> bool {
        *self == Self::initial()
    }
}

table! {
    /// A tool that cuts a body. Where the two also touch, tissue is pushed away until it gets over a line of no return; where they do not, the
    /// lines go through it.
    pub struct CutPair {
        /// Name of the body.
        body: String = identifier(),
        /// The tool, one with a line of no return.
        tool: String = identifier(),
        /// How the mesh changes.
        #[serde(default = "CutTopology::initial", skip_serializing_if = "CutTopology::is_default")]
        topology: CutTopology => "progressive",
        /// When tissue gets over a line of no return, of a tool that also touches the body.
        #[serde(default = "CutTrigger::initial", skip_serializing_if = "CutTrigger::is_default")]
        trigger: CutTrigger => "force",
    }
}

table! {
    /// A tool of a scene: one of `config/tools`, or capsules of its own, and how it moves.
    pub struct SceneTool {
        /// Its name.
        name: String = identifier(),
        /// Name of a file in the folder `tools` beside that of the scene, without its extension; left out with
        /// capsules of its own.
        model: Option<String> = identifier(),
        /// Its parts, and only without a `model`.
        capsule: Vec<ToolCapsule> [0, 32],
        /// A point of the axis about which the jaws turn \[m\]; the axis is along y. Only and always with jaws.
        hinge: Option<[f64; 3]> = tool_point(),
        /// Angle between the jaws when fully open \[rad\]. Only and always with jaws.
        opening_angle: Option<f64> = jaw_angle(),
        /// How well its edges and jaws cut, from 0, blunt, to 1.
        sharpness: f64 = ratio(1.0) => 0.0,
        /// Fluid that it sends out, with its opening as the valve; only without a `model`.
        irrigation: Option<Irrigation>,
        /// Where it is, by ascending time: linear between two keys, still before the first and after the last.
        motion: Vec<ToolKey> [1, 10_000],
    }
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

table! {
    /// A key as the file has it: with an orientation, with axis and angle, or unturned.
    pub(crate) struct ToolKeyFile {
        /// Time since the start \[s\]; later than that of the key before.
        time: f64 = time(0.0, 6e3),
        /// Of the tool's origin, its tip \[m\].
        position: [f64; 3] = point(),
        /// Rotation [x, y, z, w] that turns tool directions into those of the scene; unturned if there is no axis
        /// either.
        orientation: Option<[f64; 4]> = rotation(),
        /// Axis of that rotation; with `angle`, and instead of `orientation`.
        axis: Option<[f64; 3]> = direction(),
        /// Right-handed angle about `axis` \[rad\].
        angle: Option<f64> = quantity(Unit::Angle, -1e3, 1e3),
        /// From 0 closed to 1 open.
        opening: f64 = ratio(1.0) => 0.0,
    }
}

impl Setting for ToolKey {
    fn kind() -> Kind {
        ToolKeyFile::kind()
    }
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
