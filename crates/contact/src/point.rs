//! A point of contact: which features, where, how far apart.

use nalgebra::Vector3;

/// What a point of contact is with, seen from its first side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Partner {
    /// A capsule of a tool.
    Tool {
        /// Which tool.
        tool: u32,
        /// Which of its capsules.
        capsule: u32,
    },
    /// A part of an obstacle.
    Obstacle {
        /// Which of the parts of all obstacles.
        part: u32,
    },
    /// A body, itself included.
    Body {
        /// Which.
        body: u32,
    },
}

/// Identity of a point of contact from step to step: the partner and the features of both sides. Contact forces are
/// carried over by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The body of the first side.
    pub body: u32,
    /// What it touches.
    pub partner: Partner,
    /// The nodes of the feature of the first side, ascending; unused ones are `u32::MAX`.
    pub first: [u32; 3],
    /// The nodes of an edge of another body. Of a face they are not named, so that a node which slides from triangle to
    /// triangle stays the same contact. Of a rigid other side the first is the number of the end of a capsule's axis (0 or 1) that a
    /// face touches, or of a box's edge (0..12) or corner (12..20). Unused ones are `u32::MAX`.
    pub second: [u32; 2],
}

/// A point of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Its name.
    pub key: Key,
    /// Its nodes; unused ones have the weight 0 and repeat the first one.
    pub nodes: [u32; 4],
    /// Weights: of the first side positive with the sum 1, of another body's negative with the sum −1.
    pub weights: [f64; 4],
    /// How many of the nodes are of the first side.
    pub first: u8,
    /// Unit normal, from the other side to the first.
    pub normal: Vector3<f64>,
    /// Distance between the sides along the normal at the positions it was found for \[m\]; below 0 inside.
    pub gap: f64,
    /// The same before the step, for the same nodes, weights and normal \[m\].
    pub start_gap: f64,
    /// How far the point of a rigid other side moves from the start of the step to where it was found for \[m\].
    pub drift: Vector3<f64>,
    /// Where it is on the first side \[m\].
    pub place: Vector3<f64>,
}

impl Point {
    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let vectors = [&self.normal, &self.drift, &self.place];
        let mut numbers = vectors.into_iter().flat_map(Vector3::iter);
        numbers.all(|c| c.is_finite()) && self.gap.is_finite() && self.start_gap.is_finite()
    }
}
