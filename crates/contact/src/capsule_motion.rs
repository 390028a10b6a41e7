//! A capsule in motion.

use microsim_geometry::Capsule;
use nalgebra::Vector3;

/// One capsule of a tool over a step, in the world. Its radius is that of `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CapsuleMotion {
    /// Before the step.
    pub start: Capsule,
    /// After the step.
    pub end: Capsule,
}

impl CapsuleMotion {
    /// The capsule at a step fraction, each end of its axis on a straight line.
    pub fn at(&self, fraction: f64) -> Capsule {
        let between = |from: Vector3<f64>, to: Vector3<f64>| {
            if fraction == 1.0 {
                to
            } else {
                from + (to - from) * fraction
            }
        };
        Capsule {
            a: between(self.start.a, self.end.a),
            b: between(self.start.b, self.end.b),
            radius: self.end.radius,
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        [self.start.a, self.start.b, self.end.a, self.end.b]
            .iter()
            .all(|p| p.iter().all(|c| c.is_finite()))
            && self.end.radius.is_finite()
    }
}
