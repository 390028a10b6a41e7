//! Contact between tools, obstacles and the surfaces of bodies: which features touch, where, and how deep.
//!
//! What is here: the [`Detector`], which finds [`Point`]s. What is not: the forces that enforce non-penetration, friction included: these are the solver's
//! (`tissue`); poses and time steps (`scene`). Pure: the same input gives the same bits.

#![forbid(unsafe_code)]

mod body;
mod body_pair;
mod broad_phase;
mod capsule_motion;
mod depth;
mod detector;
mod edge_edge;
mod end_plane;
mod features;
mod frame;
mod lists;
mod near;
mod node_face;
mod normals;
mod obstacle;
mod obstacle_contact;
mod pair;
mod point;
mod sides;
mod surface;
mod surface_update;
#[cfg(test)]
mod tests;
mod tool_contact;
mod tree;

pub use broad_phase::BroadPhaseMethod;
pub use capsule_motion::CapsuleMotion;
pub use detector::Detector;
pub use frame::Frame;
pub use obstacle::{ObstaclePart, ObstacleShape};
pub use pair::{ContactPair, Depth, Detection, VesselEnd};
pub use point::{Key, Partner, Point};
pub use sides::Sides;
pub use surface::ContactSurface;
pub use surface_update::SurfaceUpdate;
