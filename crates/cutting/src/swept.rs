//! What is remembered of the passage of blades by an element.

use nalgebra::Vector3;

/// Cosine of the angle between the directions from a sweep to two elements up to which they lie on one side of it.
pub(crate) const ONE_SIDE: f64 = 0.5;

/// How blades came near to an element.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Swept {
    /// Whether one has passed its centroid.
    pub passed: bool,
    /// Direction from the path to its centroid, of length 1; 0 where blades have passed on several sides, or none has.
    pub side: Vector3<f64>,
}

impl Swept {
    /// Enters another passage at the side from which the element lies in this direction.
    pub(crate) fn pass(&mut self, side: Vector3<f64>) {
        if !self.passed {
            *self = Self { passed: true, side };
        } else if self.side.dot(&side) <= ONE_SIDE {
            self.side = Vector3::zeros();
        }
    }

    /// Whether blades have passed it on several sides: it lies in the cut itself.
    pub(crate) fn is_between(&self) -> bool {
        self.passed && self.side == Vector3::zeros()
    }
}
