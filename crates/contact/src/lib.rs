//! Contact between tools, rigid things and the surfaces of bodies: which features touch, where, and how deep.
//!
//! What is here: the [`Detector`], which finds [`Point`]s. What is not: the force that keeps gaps open, friction included – it depends on
//! the solver and stands with it (`tissue`); poses and time steps (`scene`). Pure: the same input gives the same bits.

#![forbid(unsafe_code)]

mod body;
mod capsule_motion;
mod depth;
mod detector;
mod edges;
mod ends;
mod features;
mod lists;
mod meshes;
mod near;
mod outward;
mod point;
mod rigid;
mod sides;
mod skin;
mod skin_change;
mod standing;
#[cfg(test)]
mod tests;
mod tool;
mod tree;

pub use capsule_motion::CapsuleMotion;
pub use detector::{Detector, Frame, Touch, VesselEnd};
pub use point::{Key, Partner, Point};
pub use rigid::{Rigid, RigidShape};
pub use sides::Sides;
pub use skin::Skin;
pub use skin_change::SkinChange;
