//! The capsule: all points within a radius of a segment. Tools are made of capsules.

use crate::aabb::Aabb;
use crate::pose::Pose;
use crate::segment::{SegmentPoint, closest_on_segment};
use nalgebra::Vector3;

/// A capsule; with both ends in one place it is a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// First end of the axis \[m\].
    pub a: Vector3<f64>,
    /// Second end of the axis \[m\].
    pub b: Vector3<f64>,
    /// Radius \[m\], > 0.
    pub radius: f64,
}

impl Capsule {
    /// The point of the axis closest to `p`.
    #[inline]
    pub fn axis_point(&self, p: &Vector3<f64>) -> SegmentPoint {
        closest_on_segment(p, &self.a, &self.b)
    }

    /// Signed distance of `p` from the capsule's surface \[m\]; negative inside.
    #[inline]
    pub fn signed_distance(&self, p: &Vector3<f64>) -> f64 {
        (p - self.axis_point(p).point).norm() - self.radius
    }

    /// The smallest box around the capsule.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(&[self.a, self.b]).inflated(self.radius)
    }

    /// The smallest box around the capsule on its path to `end`, each end of the axis on a straight line.
    pub fn swept_bounds(&self, end: &Self) -> Aabb {
        self.bounds().union(&end.bounds())
    }

    /// The capsule of a frame, posed in the world.
    pub fn posed(&self, world_from_frame: &Pose) -> Self {
        Self {
            a: world_from_frame.apply(&self.a),
            b: world_from_frame.apply(&self.b),
            radius: self.radius,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signed_distance_of_known_points() {
        let capsule = Capsule {
            a: Vector3::zeros(),
            b: Vector3::x() * 2.0,
            radius: 0.5,
        };
        for (p, expected) in [
            ([1.0, 2.0, 0.0], 1.5),
            ([1.0, 0.0, 0.25], -0.25),
            ([5.0, 4.0, 0.0], 4.5),
            ([-3.0, 0.0, 4.0], 4.5),
            ([2.5, 0.0, 0.0], 0.0),
        ] {
            assert!(
                (capsule.signed_distance(&p.into()) - expected).abs() < 1e-15,
                "{p:?}"
            );
        }
        assert_eq!(
            capsule.bounds(),
            Aabb {
                min: Vector3::repeat(-0.5),
                max: Vector3::new(2.5, 0.5, 0.5)
            }
        );
        let moved = capsule.posed(&Pose {
            position: Vector3::z(),
            ..Pose::identity()
        });
        assert_eq!(moved.a, Vector3::z());
    }
}
