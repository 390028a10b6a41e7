//! Unit quaternions in the order x, y, z, w: check, product, rotation and interpolation.

use std::error::Error;
use std::fmt;

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// By how much the norm of a quaternion from outside may differ from 1. Six printed digits give 1e-6, float32 1e-7;
/// more than 1e-3 means that it is no orientation, or that columns were mixed up.
pub const NORM_TOLERANCE: f64 = 1e-3;

/// Why four numbers are not an orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QuaternionError {
    /// One of them is not finite.
    NotFinite,
    /// All of them are zero.
    Zero,
    /// Their norm, given here, differs from 1 by more than [`NORM_TOLERANCE`].
    Norm(f64),
}

impl fmt::Display for QuaternionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "quaternion is not finite"),
            Self::Zero => write!(f, "quaternion is zero, expected a unit quaternion"),
            Self::Norm(norm) => write!(
                f,
                "quaternion has norm {norm}, expected 1 within {NORM_TOLERANCE}"
            ),
        }
    }
}

impl Error for QuaternionError {}

/// The quaternion scaled to norm 1, if it was so within [`NORM_TOLERANCE`].
pub(crate) fn checked_unit(quaternion: [f64; 4]) -> Result<[f64; 4], QuaternionError> {
    if !quaternion.iter().all(|component| component.is_finite()) {
        return Err(QuaternionError::NotFinite);
    }
    if quaternion == [0.0; 4] {
        return Err(QuaternionError::Zero);
    }
    let norm = norm(quaternion);
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(QuaternionError::Norm(norm));
    }
    Ok(quaternion.map(|component| component / norm))
}

/// The quaternion that comes back from being checked and scaled to norm 1 as it is: where scaling changes its last bits, those that further scaling leaves.
///
/// # Errors
/// If it is none within [`NORM_TOLERANCE`].
pub fn fixed_unit(quaternion: [f64; 4]) -> Result<[f64; 4], QuaternionError> {
    const MOST: usize = 8;
    let mut scaled = checked_unit(quaternion)?;
    for _ in 0..MOST {
        let again = checked_unit(scaled)?;
        if again == scaled {
            break;
        }
        scaled = again;
    }
    Ok(scaled)
}

/// `a_from_c` of `a_from_b` and `b_from_c`.
pub(crate) fn product(a_from_b: [f64; 4], b_from_c: [f64; 4]) -> [f64; 4] {
    (unit(a_from_b) * unit(b_from_c)).coords.into()
}

/// The components in frame a of a vector given in frame b.
pub(crate) fn rotated(a_from_b: [f64; 4], vector_in_b: [f64; 3]) -> [f64; 3] {
    (unit(a_from_b) * Vector3::from(vector_in_b)).into()
}

/// The orientation at `fraction` (0 to 1) of the rotation from one unit quaternion to another, turning steadily about
/// one axis by the smaller angle (Shoemake 1985). Half a turn apart both directions are as short, and rounding decides.
pub(crate) fn slerp(from: [f64; 4], to: [f64; 4], fraction: f64) -> [f64; 4] {
    let dot: f64 = (0..4).map(|i| from[i] * to[i]).sum();
    // q and -q are the same orientation; the nearer one gives the smaller angle.
    let to = if dot < 0.0 {
        to.map(|component| -component)
    } else {
        to
    };
    // The angle between the two, in the form that keeps its digits when it is small.
    let difference = norm(std::array::from_fn(|i| to[i] - from[i]));
    let sum = norm(std::array::from_fn(|i| to[i] + from[i]));
    let angle = 2.0 * libm::atan2(difference, sum);
    if angle == 0.0 {
        return from;
    }
    let weight_from = libm::sin((1.0 - fraction) * angle) / libm::sin(angle);
    let weight_to = libm::sin(fraction * angle) / libm::sin(angle);
    let blend: [f64; 4] = std::array::from_fn(|i| weight_from * from[i] + weight_to * to[i]);
    // Takes away the rounding of the weights; the norm is 1 up to that.
    let norm = norm(blend);
    blend.map(|component| component / norm)
}

fn norm(quaternion: [f64; 4]) -> f64 {
    quaternion
        .iter()
        .map(|component| component * component)
        .sum::<f64>()
        .sqrt()
}

fn unit([x, y, z, w]: [f64; 4]) -> UnitQuaternion<f64> {
    Unit::new_unchecked(Quaternion::new(w, x, y, z))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, PI};

    use super::*;

    /// Rounding of a dozen operations on numbers of size one.
    const ROUNDING: f64 = 12.0 * f64::EPSILON;

    fn about_z(angle: f64) -> [f64; 4] {
        [0.0, 0.0, libm::sin(angle / 2.0), libm::cos(angle / 2.0)]
    }

    fn assert_close<const N: usize>(found: [f64; N], expected: [f64; N]) {
        for i in 0..N {
            assert!(
                (found[i] - expected[i]).abs() <= ROUNDING,
                "{found:?}, expected {expected:?}"
            );
        }
    }

    #[test]
    fn quarter_turns_by_hand() {
        let about_x = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
        assert_close(
            rotated(about_z(PI / 2.0), [1.0, 2.0, 3.0]),
            [-2.0, 1.0, 3.0],
        );
        assert_close(rotated(about_x, [1.0, 2.0, 3.0]), [1.0, -3.0, 2.0]);
        // First about x, then about z: y goes to z and stays there; x goes to y.
        let both = product(about_z(PI / 2.0), about_x);
        assert_close(rotated(both, [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_close(rotated(both, [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        // i·k = -j, in the order x, y, z, w.
        assert_close(
            product([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]),
            [0.0, -1.0, 0.0, 0.0],
        );
    }

    /// Closed form: between two turns about one axis the angle is linear in the fraction.
    #[test]
    fn slerp_turns_steadily() {
        for angle in [0.0, 1e-9, 0.3, 1.0, 3.1] {
            for fraction in [0.0, 0.25, 0.5, 0.9, 1.0] {
                let found = slerp(about_z(0.2), about_z(0.2 + angle), fraction);
                assert_close(found, about_z(0.2 + fraction * angle));
            }
        }
    }

    #[test]
    fn slerp_takes_the_shorter_way() {
        // A turn by 300° is one by -60°.
        let found = slerp(about_z(0.0), about_z(5.0 * PI / 3.0), 0.5);
        assert_close(found, about_z(-PI / 6.0));
        // The same orientation with the other sign: nothing to turn.
        let q = about_z(1.0);
        assert_eq!(slerp(q, q.map(|component| -component), 0.3), q);
    }

    #[test]
    fn only_orientations_pass() {
        assert_eq!(checked_unit([0.0; 4]), Err(QuaternionError::Zero));
        assert_eq!(
            checked_unit([0.0, f64::NAN, 0.0, 1.0]),
            Err(QuaternionError::NotFinite)
        );
        assert_eq!(
            checked_unit([0.0, 0.0, 0.0, 1.002]),
            Err(QuaternionError::Norm(1.002))
        );
        assert_eq!(
            checked_unit([0.0, 0.0, 0.0, -1.0005]),
            Ok([0.0, 0.0, 0.0, -1.0])
        );
    }
}
