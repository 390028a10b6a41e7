//! Virtual objects: what a level names and a module activates, moves and colours.

use crate::pose::Pose;
use crate::wire::Message;
use microsim_vocabulary::{Finish, Overflow};
use serde::{Deserialize, Serialize};

/// Colour, sRGB 0…1.
pub type Colour = [f64; 3];

/// Shape of an object in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case")]
pub enum Shape {
    /// A sphere around the origin.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A capsule along z, centred at the origin.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Distance of the two end points \[m\].
        length: f64,
    },
    /// A box around the origin.
    Box {
        /// Half edge lengths \[m\].
        half_size: [f64; 3],
    },
    /// A torus around its z axis.
    Ring {
        /// To the middle of the tube \[m\].
        radius: f64,
        /// Radius of the tube \[m\].
        tube: f64,
    },
    /// Everything below z = 0.
    HalfSpace,
    /// A cylinder along z, centred at the origin.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// From end to end \[m\].
        length: f64,
    },
    /// What a file of the level holds, about its origin. Whoever draws it has the file.
    Model {
        /// Name of the file.
        model: String,
        /// Metres in a unit of the file.
        scale: f64,
        /// Name of the picture on it, if that is not one of its own.
        texture: Option<String>,
    },
}

/// Changes an object, or the colour of a rigid obstacle; what is `None` stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectSet {
    /// Unique name of the object or rigid obstacle.
    pub name: String,
    /// Shown or not.
    pub active: Option<bool>,
    /// Pose in its parent's frame (the field for an object without parent).
    pub pose: Option<Pose>,
    /// Colour.
    pub colour: Option<Colour>,
}

impl Message for ObjectSet {
    const KIND: &'static str = "object.set";
}

/// One object as it is now, or a solid part of a rigid obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectState {
    /// Name of the object, or of the rigid obstacle, whose parts all have its name.
    pub name: String,
    /// Shape in its own frame.
    pub shape: Shape,
    /// Pose in the field.
    pub pose: Pose,
    /// Colour.
    pub colour: Colour,
    /// How it shines.
    pub finish: Finish,
}

/// All active objects and all rigid obstacles; published whenever one of them changes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectScene {
    /// The rigid obstacles, then the objects, in the level's order.
    pub objects: Vec<ObjectState>,
}

impl Message for ObjectScene {
    const KIND: &'static str = "object.scene";
    const OVERFLOW: Overflow = Overflow::DropOldest;
}
