//! What a scene is made of, as plain values. They are checked when the scene is built.

use microsim_mesh::Block;
use microsim_tissue::SpringVolumeSpec;

/// A scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSpec {
    /// The bodies; names differ.
    pub bodies: Vec<BodySpec>,
    /// The tools; names differ.
    pub tools: Vec<ToolSpec>,
    /// Which tool touches which body: (tool name, body name). No other contact is computed.
    pub contact_pairs: Vec<(String, String)>,
    /// Acceleration of gravity in the world [m/s²].
    pub gravity: [f64; 3],
}

/// A deformable body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySpec {
    /// Its name.
    pub name: String,
    /// Where its mesh comes from.
    pub generator: Generator,
    /// What it is made of.
    pub material: SpringVolumeSpec,
    /// Nodes in any of these boxes are fixed in space. Boxes are in the body's frame.
    pub clamps: Vec<BoxSpec>,
}

/// The source of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Generator {
    /// A block of equal cells. The body's frame has its origin in the block's centre and the axes of the world.
    Block(Block),
}

/// A box parallel to the axes; its boundary belongs to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxSpec {
    /// Smallest coordinates [m].
    pub min: [f64; 3],
    /// Largest coordinates [m], none smaller than in `min`.
    pub max: [f64; 3],
}

/// A rigid tool, or one whose parts turn about hinges.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolSpec {
    /// Its name.
    pub name: String,
    /// Its parts; at least one.
    pub capsules: Vec<CapsuleSpec>,
}

/// A part of a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CapsuleSpec {
    /// First end of the axis in the tool's frame, tool closed [m].
    pub a: [f64; 3],
    /// Second end of the axis in the tool's frame, tool closed [m].
    pub b: [f64; 3],
    /// Radius [m], > 0.
    pub radius: f64,
    /// How the part moves when the tool opens; `None` for a rigid part.
    pub hinge: Option<HingeSpec>,
}

/// The hinge of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HingeSpec {
    /// A point of the hinge's axis in the tool's frame [m].
    pub pivot: [f64; 3],
    /// Direction of the axis in the tool's frame; not zero.
    pub axis: [f64; 3],
    /// Right-handed angle about the axis per unit of opening [rad].
    pub angle: f64,
}
