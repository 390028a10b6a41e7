//! Rigid poses and their interpolation.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A rigid pose: `world_from_frame`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Origin of the frame in the world \[m\].
    pub position: Vector3<f64>,
    /// Rotation that takes vectors of the frame into the world.
    pub orientation: UnitQuaternion<f64>,
}

impl Pose {
    /// The pose of the world frame itself.
    pub fn identity() -> Self {
        Self {
            position: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
        }
    }

    /// From a position \[m\] and a quaternion x, y, z, w that is not zero, as messages hold them.
    pub fn from_arrays(position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Self {
        Self {
            position: Vector3::from(position),
            orientation: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
        }
    }

    /// A point of the frame \[m\] in the world \[m\].
    ///
    /// ```
    /// use microsim_geometry::Pose;
    /// use nalgebra::Vector3;
    ///
    /// // A quarter turn about z, and 1 m along x.
    /// let half = std::f64::consts::FRAC_1_SQRT_2;
    /// let world_from_tool = Pose::from_arrays([1.0, 0.0, 0.0], [0.0, 0.0, half, half]);
    /// let tip_in_world = world_from_tool.apply(&Vector3::x());
    /// assert!((tip_in_world - Vector3::new(1.0, 1.0, 0.0)).norm() < 1e-15);
    /// ```
    #[inline]
    pub fn apply(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.orientation * point
    }

    /// Whether every number of the pose is finite.
    pub fn is_finite(&self) -> bool {
        self.position
            .iter()
            .chain(self.orientation.coords.iter())
            .all(|c| c.is_finite())
    }

    /// Angle between the two orientations \[rad\], in 0..π.
    pub fn angle_to(&self, other: &Self) -> f64 {
        2.0 * libm::acos(
            self.orientation
                .coords
                .dot(&other.orientation.coords)
                .abs()
                .min(1.0),
        )
    }

    /// The pose at the fraction `t` (0..1) of a motion to `end`: position on the straight line, orientation along the
    /// shorter great arc at constant angular speed (slerp, Shoemake 1985).
    pub fn interpolate(&self, end: &Self, t: f64) -> Self {
        let position = self.position + (end.position - self.position) * t;
        let (q0, mut q1) = (self.orientation.coords, end.orientation.coords);
        // q and −q are the same rotation: take the one on the shorter arc.
        let mut cosine = q0.dot(&q1);
        if cosine < 0.0 {
            q1 = -q1;
            cosine = -cosine;
        }
        // Below an angle of about 1e-4 rad the weights of slerp and of the straight line differ by less than its
        // square over 6, which is smaller than what sin(angle) in the denominator would lose.
        let (w0, w1) = if cosine > 1.0 - 1e-8 {
            (1.0 - t, t)
        } else {
            let angle = libm::acos(cosine);
            let sine = libm::sin(angle);
            (
                libm::sin((1.0 - t) * angle) / sine,
                libm::sin(t * angle) / sine,
            )
        };
        let orientation = UnitQuaternion::new_normalize(Quaternion::from_vector(q0 * w0 + q1 * w1));
        Self {
            position,
            orientation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about_z(angle: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::new_normalize(Quaternion::new(
            libm::cos(angle / 2.0),
            0.0,
            0.0,
            libm::sin(angle / 2.0),
        ))
    }

    #[test]
    fn slerp_about_one_axis_is_linear_in_the_angle() {
        let start = Pose {
            position: Vector3::new(1.0, 2.0, 3.0),
            orientation: about_z(0.2),
        };
        for step in [1e-6, 1e-4, 0.3, 2.0, 3.0] {
            let end = Pose {
                position: Vector3::new(-1.0, 0.0, 4.0),
                orientation: about_z(0.2 + step),
            };
            assert!(
                (start.angle_to(&end) - step).abs() < 1e-7,
                "acos near 1 keeps half of the digits"
            );
            for t in [0.0, 0.25, 0.5, 1.0] {
                let middle = start.interpolate(&end, t);
                let expected = Pose {
                    position: start.position + (end.position - start.position) * t,
                    orientation: about_z(0.2 + step * t),
                };
                assert!((middle.position - expected.position).norm() < 1e-15);
                assert!(
                    (middle.orientation.coords - expected.orientation.coords).norm() < 1e-12,
                    "{step} {t}"
                );
            }
        }
    }

    #[test]
    fn interpolation_takes_the_shorter_arc_whatever_the_sign_of_the_quaternion() {
        let start = Pose {
            position: Vector3::zeros(),
            orientation: about_z(0.0),
        };
        let turned = about_z(1.0);
        let negated = UnitQuaternion::new_unchecked(-turned.into_inner());
        let end = |orientation| Pose {
            position: Vector3::zeros(),
            orientation,
        };
        let a = start.interpolate(&end(turned), 0.3).apply(&Vector3::x());
        let b = start.interpolate(&end(negated), 0.3).apply(&Vector3::x());
        assert!((a - b).norm() < 1e-15);
        assert!((a - Vector3::new(libm::cos(0.3), libm::sin(0.3), 0.0)).norm() < 1e-14);
    }
}
