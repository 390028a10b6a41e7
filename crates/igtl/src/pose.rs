//! Poses of the simulator from those of the wire.

use crate::message::{Matrix, Position};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use std::fmt;

/// By how much a rotation may miss being one: matrices and quaternions come in single precision, and trackers round them.
const NEARLY: f64 = 1e-3;

/// A rigid motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// \[m\]
    pub position: Vector3<f64>,
    /// From the device's axes to the tracker's.
    pub orientation: UnitQuaternion<f64>,
}

/// Why numbers of a message are no pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotRigid {
    /// A number is not finite.
    NotFinite,
    /// The matrix scales, shears or mirrors, or the quaternion is not of length 1, by more than 10⁻³.
    NoRotation,
    /// There is no orientation.
    NoOrientation,
}

impl fmt::Display for NotRigid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a number is not finite",
            Self::NoRotation => {
                "expected a rotation to within 0.001, found one that scales, shears or mirrors"
            }
            Self::NoOrientation => "it has a position alone",
        })
    }
}

impl std::error::Error for NotRigid {}

impl Matrix {
    /// Its position alone \[m\].
    ///
    /// # Errors
    /// If a number of it is not finite.
    pub fn place(&self) -> Result<Vector3<f64>, NotRigid> {
        metres(self.translation)
    }

    /// As a pose: the rotation nearest to the matrix.
    ///
    /// # Errors
    /// If a number is not finite, or the matrix is no rotation to within 10⁻³ in each number of RᵀR and its determinant.
    pub fn pose(&self) -> Result<Pose, NotRigid> {
        let columns = self.axes.map(|axis| Vector3::from(axis).cast::<f64>());
        let rotation = Matrix3::from_columns(&columns);
        let position = metres(self.translation)?;
        if !rotation.iter().all(|number| number.is_finite()) {
            return Err(NotRigid::NotFinite);
        }
        let excess = rotation.transpose() * rotation - Matrix3::identity();
        if excess.amax() > NEARLY || (rotation.determinant() - 1.0).abs() > NEARLY {
            return Err(NotRigid::NoRotation);
        }
        // One step of Newton's iteration for the polar factor, R (3 − RᵀR)/2, leaves 10⁻⁶ of the 10⁻³.
        let nearest = rotation * (Matrix3::identity() * 1.5 - (excess + Matrix3::identity()) * 0.5);
        let rotation = Rotation3::from_matrix_unchecked(nearest);
        Ok(Pose {
            position,
            orientation: fixed_quaternion(
                UnitQuaternion::from_rotation_matrix(&rotation).into_inner(),
            ),
        })
    }
}

impl Position {
    /// Its position alone \[m\].
    ///
    /// # Errors
    /// If a number of it is not finite.
    pub fn place(&self) -> Result<Vector3<f64>, NotRigid> {
        metres(self.position)
    }

    /// As a pose.
    ///
    /// # Errors
    /// If a number is not finite, the length of the quaternion is not 1 to within 10⁻³, or there is none.
    pub fn pose(&self) -> Result<Pose, NotRigid> {
        let position = metres(self.position)?;
        let [x, y, z, w] = self
            .orientation
            .ok_or(NotRigid::NoOrientation)?
            .map(f64::from);
        let quaternion = Quaternion::new(w, x, y, z);
        match quaternion.norm() {
            norm if !norm.is_finite() => Err(NotRigid::NotFinite),
            norm if (norm - 1.0).abs() > NEARLY => Err(NotRigid::NoRotation),
            _ => Ok(Pose {
                position,
                orientation: fixed_quaternion(quaternion),
            }),
        }
    }
}

/// The quaternion scaled to length 1 until that changes no bit: whoever scales it once more, as the translator does, has the same one, and so has whoever plays it back.
fn fixed_quaternion(quaternion: Quaternion<f64>) -> UnitQuaternion<f64> {
    const MOST: usize = 8;
    let mut numbers: [f64; 4] = quaternion.coords.into();
    for _ in 0..MOST {
        let norm = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scaled = numbers.map(|x| x / norm);
        if scaled == numbers {
            break;
        }
        numbers = scaled;
    }
    UnitQuaternion::new_unchecked(Quaternion::from_vector(numbers.into()))
}

fn metres(millimetres: [f32; 3]) -> Result<Vector3<f64>, NotRigid> {
    let place = Vector3::from(millimetres).cast::<f64>() * 1e-3;
    match place.iter().all(|number| number.is_finite()) {
        true => Ok(place),
        false => Err(NotRigid::NotFinite),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A quarter turn about z takes x to y, by hand.
    #[test]
    fn a_quarter_turn_is_one_in_both_forms() {
        let matrix = Matrix {
            axes: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [1.5, -2.25, 300.0],
        };
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let position = Position {
            position: matrix.translation,
            orientation: Some([0.0, 0.0, half, half]),
        };
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2);
        for pose in [
            matrix.pose().expect("a pose"),
            position.pose().expect("a pose"),
        ] {
            assert!((pose.position - Vector3::new(0.0015, -0.00225, 0.3)).norm() < 1e-9);
            // Single precision.
            assert!(pose.orientation.angle_to(&turn) < 1e-7);
        }
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        let straight = Matrix {
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [0.0; 3],
        };
        let changed = |change: fn(&mut Matrix)| {
            let mut matrix = straight;
            change(&mut matrix);
            matrix.pose().map(|_| ())
        };
        assert_eq!(changed(|_| {}), Ok(()));
        assert_eq!(changed(|m| m.axes[0][1] = 4e-4), Ok(()));
        assert_eq!(changed(|m| m.axes[0][1] = 2e-3), Err(NotRigid::NoRotation));
        assert_eq!(changed(|m| m.axes[2][2] = -1.0), Err(NotRigid::NoRotation));
        assert_eq!(
            changed(|m| m.axes = [[0.0; 3]; 3]),
            Err(NotRigid::NoRotation)
        );
        assert_eq!(
            changed(|m| m.axes[1][1] = f32::NAN),
            Err(NotRigid::NotFinite)
        );
        assert_eq!(
            changed(|m| m.translation[2] = f32::INFINITY),
            Err(NotRigid::NotFinite)
        );
        let position = |orientation| {
            let position = Position {
                position: [0.0; 3],
                orientation,
            };
            position.pose().map(|_| ())
        };
        assert_eq!(position(None), Err(NotRigid::NoOrientation));
        assert_eq!(position(Some([0.0; 4])), Err(NotRigid::NoRotation));
        assert_eq!(position(Some([f32::NAN; 4])), Err(NotRigid::NotFinite));
    }
}
