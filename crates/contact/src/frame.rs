//! The input of a search for contact: positions over a step of time.

use crate::capsule_motion::CapsuleMotion;
use crate::sides::Sides;
use nalgebra::Vector3;

/// Positions of bodies and tools over a step, and what is searched for.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Positions of the group's nodes before the step \[m\].
    pub start: &'a [Vector3<f64>],
    /// Positions at which points are wanted \[m\].
    pub now: &'a [Vector3<f64>],
    /// The capsules of each tool over the step; `None` of an absent tool.
    pub tools: &'a [Option<Vec<CapsuleMotion>>],
    /// Step fraction of the tools' motion that belongs to `now`, from 0 to 1.
    pub fraction: f64,
    /// Points with a gap below this are found \[m\], ≥ 0.
    pub reach: f64,
    /// The normals that the step before ended with.
    pub sides: &'a Sides,
}
