//! Contact between capsule tools and the surface of a body: where each touched node has to be after the step.
//!
//! What is here: detection of capsules against surface triangles and nodes, depth and normal, distribution of corrections
//! to nodes, targets that move with the tool. What is not: the force that reaches a target – it depends on the integrator and
//! stands with it (`tissue`); poses and time steps (`scene`); friction, self-collision, continuous detection (later work).
//! Pure: the same input gives the same bits.

mod memory;
mod response;
mod touch;

pub use memory::ContactMemory;
pub use response::{BodySurface, CapsuleMotion, NodeCorrection, Response, respond};
