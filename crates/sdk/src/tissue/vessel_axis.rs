//! The axis of a straight vessel.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The axis of a straight vessel, from its held end to its free end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VesselAxis {
    /// A point on it \[m\], from which lengths along it count.
    point: [f64; 3],
    /// Towards the free end, of length 1.
    direction: [f64; 3],
    /// Across it, of length 1: where angles around it begin.
    across: [f64; 3],
}

impl VesselAxis {
    /// Through `point` \[m\] towards the free end. `None` where the direction has no length.
    pub fn new(point: [f64; 3], towards_end: [f64; 3]) -> Option<Self> {
        let direction = Vector3::from(towards_end).try_normalize(f64::MIN_POSITIVE)?;
        // Upwards, as far as that is across; a vessel that stands upright begins at x.
        let up = match direction.z.abs() < 0.9 {
            true => Vector3::z(),
            false => Vector3::x(),
        };
        let across = (up - direction * direction.dot(&up)).normalize();
        Some(Self {
            point,
            direction: direction.into(),
            across: across.into(),
        })
    }

    /// Towards the free end, of length 1.
    pub fn direction(&self) -> [f64; 3] {
        self.direction
    }

    /// How far along the axis a place lies \[m\].
    pub fn along(&self, place: [f64; 3]) -> f64 {
        self.offset(place).dot(&Vector3::from(self.direction))
    }

    /// From the axis to a place, across it \[m\].
    pub fn radial(&self, place: [f64; 3]) -> [f64; 3] {
        let direction = Vector3::from(self.direction);
        let from = self.offset(place);
        (from - direction * from.dot(&direction)).into()
    }

    /// The direction across the axis at an angle around it \[rad\], of length 1: upwards at 0, then counter-clockwise as seen from the free end.
    pub fn spoke(&self, angle: f64) -> [f64; 3] {
        let (across, direction) = (Vector3::from(self.across), Vector3::from(self.direction));
        (across * libm::cos(angle) + direction.cross(&across) * libm::sin(angle)).into()
    }

    fn offset(&self, place: [f64; 3]) -> Vector3<f64> {
        Vector3::from(place) - Vector3::from(self.point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: along −x, counter-clockwise as seen from there, from z to y.
    #[test]
    fn places_have_a_length_and_an_angle() {
        let axis = VesselAxis::new([1.0, 0.0, 2.0], [-3.0, 0.0, 0.0]).expect("a direction");
        assert_eq!(axis.along([-4.0, 7.0, 9.0]), 5.0);
        assert_eq!(axis.radial([-4.0, 7.0, 9.0]), [0.0, 7.0, 7.0]);
        let spoke = axis.spoke(std::f64::consts::FRAC_PI_2);
        assert!(
            (Vector3::from(spoke) - Vector3::y()).norm() < 1e-15,
            "{spoke:?}"
        );
        let upright = VesselAxis::new([0.0; 3], [0.0, 0.0, 1.0]).expect("a direction");
        assert_eq!(upright.spoke(0.0), [1.0, 0.0, 0.0]);
        assert!(VesselAxis::new([0.0; 3], [0.0; 3]).is_none());
    }
}
