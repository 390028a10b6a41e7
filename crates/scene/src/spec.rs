//! What a scene is made of, as plain values. They are checked when the scene is built.

use microsim_contact::{BroadPhaseMethod, Depth, Detection, ObstaclePart};
use microsim_cutting::TopologyChange;
use microsim_geometry::{Joint, Pose};
use microsim_mesh::TetMesh;
use microsim_tissue::elements::{CouplingConstants, SlidingConstants};
use microsim_tissue::{Material, Method, Response};

/// Description of a scene. [`SceneSpec::new`] has defaults for all but the bodies and the method.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSpec {
    /// The bodies; names differ.
    pub bodies: Vec<BodySpec>,
    /// The tools; names differ.
    pub tools: Vec<ToolSpec>,
    /// Obstacles; names differ.
    pub obstacles: Vec<ObstacleSpec>,
    /// What touches what. No other contact is computed.
    pub contacts: Vec<ContactSpec>,
    /// What cuts what. Nothing else is ever cut.
    pub cuts: Vec<CutSpec>,
    /// Acceleration of gravity in the world \[m/s²\].
    pub gravity: [f64; 3],
    /// How the bodies are advanced.
    pub method: Method,
    /// Whether a body that diverges is rolled back and computed again with shorter steps. Without it the first divergence
    /// ends the run: measurements of methods need that.
    pub containment: bool,
    /// Whether a tick whose forces mean nothing is computed again, and tools make only a part of their motions after it; only with containment.
    pub repeat_invalid: bool,
    /// Whether, without containment too, a tick in which an implicit step did not converge is computed again with shorter steps; the
    /// report of the tick lists it. A tick that converges is not changed by it.
    pub repeat_unconverged: bool,
    /// How features that may touch are found; contacts are the same with each.
    pub broad_phase: BroadPhaseMethod,
    /// Whether tools touch each other.
    pub tools_touch: bool,
    /// The largest force with which a hand pushes a tool against what it touches \[N\]; any if infinite.
    pub hand_force: f64,
    /// The work that ticks may take; any if `None`. What does not fit is left to the next tick.
    pub budget: Option<WorkBudget>,
}

/// The work that ticks may take over their length, by the count of its operations ([`TickReport::work`](crate::TickReport::work)): a token bucket, as networks limit
/// bursts and their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkBudget {
    /// Of one tick at most; above 0.
    pub tick: f64,
    /// Of ticks that follow each other, in their mean; above 0, any if infinite. Where they take more for long, the next ones may take less.
    pub mean: f64,
}

impl SceneSpec {
    /// A scene of `bodies` alone under gravity of 9.81 m/s² along −z, with containment: no tools, obstacles, contacts and cuts.
    pub fn new(bodies: Vec<BodySpec>, method: Method) -> Self {
        Self {
            bodies,
            tools: Vec::new(),
            obstacles: Vec::new(),
            contacts: Vec::new(),
            cuts: Vec::new(),
            gravity: [0.0, 0.0, -9.81],
            method,
            containment: true,
            repeat_invalid: true,
            repeat_unconverged: true,
            broad_phase: BroadPhaseMethod::default(),
            tools_touch: false,
            hand_force: f64::INFINITY,
            budget: None,
        }
    }
}

/// Description of a deformable body. [`BodySpec::new`] has defaults for all but name, mesh and material.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
    /// Its name.
    pub name: String,
    /// Its mesh in the world at rest.
    pub mesh: TetMesh,
    /// Origin of the body's frame in the world \[m\]; its axes are the world's.
    pub origin: [f64; 3],
    /// What each region of the mesh is made of.
    pub materials: Vec<(u32, Material)>,
    /// Drag per mass c of dv/dt = −c v \[1/s\], ≥ 0.
    pub drag: f64,
    /// Force per length of a perfectly sharp edge that cuts it \[N/m\]; infinite for tissue that no single edge cuts.
    pub toughness: f64,
    /// From 0 to 1: how early jaws pinch it off.
    pub brittleness: f64,
    /// Of regions that tear by themselves the strain across a plane, of shreds of a cut their largest one, at which they do, > 0.
    pub tear_strains: Vec<(u32, f64)>,
    /// What is held.
    pub clamps: Vec<ClampSpec>,
    /// Couplings between regions.
    pub couplings: Vec<CouplingSpec>,
    /// Loads on the surface.
    pub loads: Vec<LoadSpec>,
    /// How the body lies and moves at the start, other than at rest; one after the other.
    pub start: Vec<StartSpec>,
    /// The outward triangles of the faces at the open ends of a vessel; empty for a body that is none.
    pub ends: Vec<Vec<[u32; 3]>>,
    /// The lumen of a vessel, which a tool in it may fill; `None` for a body that has none.
    pub lumen: Option<LumenSpec>,
}

impl BodySpec {
    /// A free body at rest of one material, in its first region (number 0), without drag, loads and anything that cuts or tears it.
    pub fn new(name: &str, mesh: TetMesh, material: Material) -> Self {
        Self {
            name: name.to_owned(),
            mesh,
            origin: [0.0; 3],
            materials: vec![(0, material)],
            drag: 0.0,
            toughness: f64::INFINITY,
            brittleness: 0.0,
            tear_strains: Vec::new(),
            clamps: Vec::new(),
            couplings: Vec::new(),
            loads: Vec::new(),
            start: Vec::new(),
            ends: Vec::new(),
            lumen: None,
        }
    }
}

/// The lumen of a vessel.
#[derive(Clone, Debug, PartialEq)]
pub struct LumenSpec {
    /// The outward triangles of the inner surface of the wall; at least one.
    pub triangles: Vec<[u32; 3]>,
    /// Direction of its axis at rest, not zero.
    pub axis: [f64; 3],
    /// Sections of equal length along it at rest, at least 1; no triangle reaches over the border of two.
    pub sections: u32,
}

/// Nodes of a body, in the body's frame and at rest.
#[derive(Clone, Debug, PartialEq)]
pub enum Selection {
    /// Every node.
    All,
    /// Those in a box.
    Box(BoxSpec),
    /// Those whose distance from an axis is in a range.
    Shell {
        /// A point of the axis \[m\].
        point: [f64; 3],
        /// Direction of the axis, not zero.
        axis: [f64; 3],
        /// Smallest and largest distance \[m\].
        radius: [f64; 2],
    },
    /// The one that is nearest to a point \[m\]; of several the first.
    Nearest([f64; 3]),
}

/// Nodes that are held, and how what holds them moves.
#[derive(Clone, Debug, PartialEq)]
pub struct ClampSpec {
    /// Which nodes.
    pub nodes: Selection,
    /// How they are moved; `None` for a clamp at rest.
    pub motion: Option<MotionSpec>,
    /// When it is released \[s\]; `None` for never.
    pub release: Option<f64>,
}

/// A rigid motion given by its values at some times; between them it is interpolated linearly, after the last it rests.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionSpec {
    /// A point of the axis of rotation at rest, in the body's frame \[m\].
    pub pivot: [f64; 3],
    /// Axis of rotation; not zero.
    pub axis: [f64; 3],
    /// The values, in ascending order of time. At time 0 the motion is zero unless a key gives another value.
    pub keys: Vec<MotionKey>,
}

/// Translation and angle of a [`MotionSpec`] at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionKey {
    /// Time \[s\].
    pub time: f64,
    /// Translation \[m\].
    pub shift: [f64; 3],
    /// Right-handed angle about the axis \[rad\].
    pub angle: f64,
}

/// A load on part of the surface of a body. It grows linearly from 0 to its full value during `ramp` \[s\].
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSpec {
    /// The surface: all triangles of which every node is selected.
    pub surface: Selection,
    /// What acts on it.
    pub kind: LoadKind,
    /// Time to the full value \[s\]; 0 for a load that is there from the start.
    pub ramp: f64,
}

/// What acts on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadKind {
    /// A pressure against the outward normal of the deformed surface \[Pa\].
    Pressure(f64),
    /// A force per area at rest of constant direction \[Pa\].
    Traction([f64; 3]),
}

/// What joins the nodes of one region to the surface of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CouplingSpec {
    /// Region whose nodes are coupled.
    pub from: u32,
    /// Region to whose surface they are coupled.
    pub to: u32,
    /// What it does.
    pub kind: CouplingKind,
}

/// What a coupling does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CouplingKind {
    /// It holds until it comes off.
    Bonded(CouplingConstants),
    /// It slides with friction.
    Sliding(SlidingConstants),
}

/// Where nodes are at the start, and how fast: p = pivot + matrix (p_rest − pivot) + shift. Clamped nodes stay.
#[derive(Clone, Debug, PartialEq)]
pub struct StartSpec {
    /// Which nodes.
    pub nodes: Selection,
    /// Rows of the matrix.
    pub matrix: [[f64; 3]; 3],
    /// Fixed point of the matrix, in the body's frame \[m\].
    pub pivot: [f64; 3],
    /// Translation \[m\].
    pub shift: [f64; 3],
    /// Velocity \[m/s\].
    pub velocity: [f64; 3],
}

/// A box parallel to the axes; its boundary belongs to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxSpec {
    /// Smallest coordinates \[m\].
    pub min: [f64; 3],
    /// Largest coordinates \[m\], none smaller than in `min`.
    pub max: [f64; 3],
}

/// A tool, rigid or with joints.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolSpec {
    /// Its name.
    pub name: String,
    /// Its parts; at least one.
    pub capsules: Vec<CapsuleSpec>,
    /// From 0, blunt, to 1: see [`CutSpec`].
    pub sharpness: f64,
    /// Of the tip of a jaw against what opens or closes it \[N/m\], > 0; infinite where jaws are rigid.
    pub jaw_stiffness: f64,
    /// Fluid from its tip; `None` for a tool without.
    pub irrigation: Option<IrrigationSpec>,
    /// Where it is in a scene that runs by itself, by ascending time; empty where it is moved from outside.
    pub motion: Vec<ToolKeySpec>,
}

/// Fluid that a tool sends out. Its pressure goes with the opening of the tool, from nothing at 0 to all of it at 1: of a tool without
/// jaws that is a valve.
///
/// Where the wall of a vessel surrounds the opening, the fluid fills the lumen ([`LumenSpec`]); elsewhere it presses on the surfaces that
/// face the jet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IrrigationSpec {
    /// The opening, in the tool's frame \[m\].
    pub position: [f64; 3],
    /// Where the fluid flows to, in the tool's frame; not zero.
    pub direction: [f64; 3],
    /// Of the fluid at rest, tool open \[Pa\], ≥ 0.
    pub pressure: f64,
    /// Of the jet \[m\], > 0.
    pub radius: f64,
    /// How far the jet reaches \[m\], > 0.
    pub reach: f64,
}

/// Where a tool is at a time. Between two keys position and opening are interpolated linearly, the orientation along the shortest
/// turn; before the first and after the last key it rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolKeySpec {
    /// Time \[s\].
    pub time: f64,
    /// `world_from_tool`.
    pub pose: Pose,
    /// Opening in units of the joints (0 is closed).
    pub opening: f64,
}

/// A capsule of a tool: all points within a radius of a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct CapsuleSpec {
    /// Its name in reports of forces; may be empty.
    pub name: String,
    /// First end of the axis in the tool's frame, tool closed \[m\].
    pub a: [f64; 3],
    /// Second end of the axis in the tool's frame, tool closed \[m\].
    pub b: [f64; 3],
    /// Radius \[m\], > 0.
    pub radius: f64,
    /// How the part moves as the tool opens.
    pub joint: Joint,
    /// Which jaw it belongs to.
    pub jaw: Option<Jaw>,
    /// Whether its axis is a line of no return.
    pub lonor: bool,
    /// Where a single blade is sharp, in the tool's frame, tool closed, of length 1; `None` for one that cuts against the other jaw only.
    pub edge: Option<[f64; 3]>,
    /// Where its line of no return lies beside its axis, in the tool's frame, tool closed, within its radius \[m\]; `None` for on the axis.
    pub lonor_offset: Option<[f64; 3]>,
}

impl CapsuleSpec {
    /// A part of the shaft that does not cut: axis from `a` to `b` and radius \[m\].
    pub fn new(a: [f64; 3], b: [f64; 3], radius: f64) -> Self {
        Self {
            name: String::new(),
            a,
            b,
            radius,
            joint: Joint::Fixed,
            jaw: None,
            lonor: false,
            edge: None,
            lonor_offset: None,
        }
    }
}

/// A jaw of a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Jaw {
    /// The one that opens towards +x.
    Left,
    /// The one that opens towards −x.
    Right,
}

/// A rigid shape that does not move and that bodies can touch.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleSpec {
    /// Its name.
    pub name: String,
    /// What it is made of; at least one part.
    pub parts: Vec<ObstaclePart>,
}

/// Contact of a body with a tool, an obstacle, another body or itself.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSpec {
    /// Name of a body.
    pub body: String,
    /// What it touches.
    pub with: PartnerSpec,
    /// Coefficient of Coulomb friction, ≥ 0.
    pub friction: f64,
    /// Size of the force from which on time is counted \[N\]; infinite for never.
    pub force_limit: f64,
    /// How penetration is prevented or undone.
    pub response: ContactResponse,
    /// How jaws hold the body.
    pub grip: Grip,
}

/// How jaws hold a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Grip {
    /// By the friction of contact alone.
    #[default]
    Friction,
    /// Nodes in the box between the jaws' lines of no return move with the jaws while both touch (dissertation 4.4.2), for explicit methods.
    Box,
}

impl ContactSpec {
    /// Contact without friction, by constraints.
    pub fn new(body: impl Into<String>, with: PartnerSpec) -> Self {
        Self {
            body: body.into(),
            with,
            friction: 0.0,
            force_limit: f64::INFINITY,
            response: ContactResponse::Constraint,
            grip: Grip::default(),
        }
    }
}

/// How penetration is prevented or undone. All but [`ContactResponse::Constraint`] are those of the dissertation (its section 4.3), for explicit methods, without
/// friction; between bodies they find nodes that are in tetrahedra after a step, and nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactResponse {
    /// Non-penetration of all contacts together, found along the whole step.
    Constraint,
    /// Springs to the surface midway between.
    Penalty {
        /// Stiffness of each \[N/m\], above 0.
        stiffness: f64,
        /// How deep nodes inside are.
        depth: Depth,
    },
    /// Forces that bring nodes to the surface at the end of a step, each by itself.
    TargetForce {
        /// How deep nodes inside are.
        depth: Depth,
    },
}

impl ContactResponse {
    /// What finds contacts of bodies.
    pub(crate) fn detection(self) -> Detection {
        match self {
            Self::Constraint => Detection::Continuous,
            Self::Penalty { depth, .. } | Self::TargetForce { depth } => Detection::Discrete(depth),
        }
    }

    /// What makes the force of each contact.
    pub(crate) fn of_contact(self) -> Response {
        match self {
            Self::Constraint => Response::Constraint,
            Self::Penalty { stiffness, .. } => Response::Penalty { stiffness },
            Self::TargetForce { .. } => Response::TargetForce,
        }
    }
}

/// A tool that cuts a body. Where the two also touch, tissue is pushed away until it gets over a line of no return; where they do not,
/// the lines go through it.
#[derive(Clone, Debug, PartialEq)]
pub struct CutSpec {
    /// Name of the body.
    pub body: String,
    /// Name of the tool.
    pub tool: String,
    /// How the mesh changes.
    pub topology: TopologyChange,
    /// When tissue gets over a line of no return.
    pub trigger: CutTrigger,
}

impl CutSpec {
    /// A cut that follows the blade, by force.
    pub fn new(body: impl Into<String>, tool: impl Into<String>) -> Self {
        Self {
            body: body.into(),
            tool: tool.into(),
            topology: TopologyChange::default(),
            trigger: CutTrigger::default(),
        }
    }
}

/// When tissue that a tool touches gets over a line of no return.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CutTrigger {
    /// When the force of contact is more than it bears; of two jaws, when they have closed.
    #[default]
    Force,
    /// When it passes the line, as far as contact lets it into the capsule, and does not come back over it (dissertation 4.4.3); of two jaws also when they
    /// have closed.
    Penetration,
}

/// What a body touches.
#[derive(Clone, Debug, PartialEq)]
pub enum PartnerSpec {
    /// A tool, by its name.
    Tool(String),
    /// An obstacle, by its name.
    Obstacle(String),
    /// Another body.
    Body {
        /// Its name.
        name: String,
        /// Whether the rule of end planes holds for the two ends that face each other (dissertation 4.3). Both bodies then have
        /// [`ends`](BodySpec::ends).
        end_planes: bool,
    },
    /// Itself.
    Itself,
}

impl PartnerSpec {
    /// Its name for people.
    pub fn name(&self) -> &str {
        match self {
            Self::Tool(name) | Self::Obstacle(name) | Self::Body { name, .. } => name,
            Self::Itself => "itself",
        }
    }
}
