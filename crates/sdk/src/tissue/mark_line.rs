//! The line of a mark on tissue.

use crate::axis;
use crate::fault::Fault;
use microsim_settings::Object;
use nalgebra::Vector3;

/// Sine of the angle to the surface below which a plane does not cut tissue through but peels a layer off: 30°. Small bites at edges lie
/// at 40° to it and more.
const PEELED: f64 = 0.5;

/// A line on tissue along which it is to be cut, straight down: tissue that lies flat has its normal along z.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkLine {
    /// Its middle, at rest \[m\].
    pub middle: [f64; 3],
    /// Its direction, of length 1.
    pub along: [f64; 3],
    /// Normal of the plane that it spans with the normal of the tissue, of length 1.
    pub across: [f64; 3],
}

impl MarkLine {
    /// The line along the z axis of a mark. A fault where it stands upright on the tissue.
    pub fn new(mark: &Object) -> Result<Self, Fault> {
        let along = axis(mark.orientation);
        let across = [along[1], -along[0], 0.0];
        let size = Vector3::from(across).norm();
        if size <= f64::EPSILON {
            return Err(Fault::new(format!(
                "[[object]] \"{}\": its `orientation` lets the mark stand upright on the tissue; it has to lie on it",
                mark.name
            )));
        }
        Ok(Self {
            middle: mark.position,
            along,
            across: across.map(|c| c / size),
        })
    }

    /// Whether a plane with this normal is a cut of the mark, rather than a slit that runs away from its line or a layer that is peeled
    /// off.
    pub(super) fn is_cut_by(&self, normal: [f64; 3]) -> bool {
        let normal = Vector3::from(normal);
        let [across, along] =
            [self.across, self.along].map(|axis| normal.dot(&Vector3::from(axis)).abs());
        across > along && normal.xy().norm() > PEELED
    }

    /// How far a place is from the line \[m\].
    pub(super) fn away(&self, place: [f64; 3]) -> f64 {
        let along = Vector3::from(self.along);
        let offset = Vector3::from(place) - Vector3::from(self.middle);
        (offset - offset.dot(&along) * along).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_that_stands_upright_is_refused_by_its_key() {
        let object = |orientation: [f64; 4]| {
            let object = serde_json::json!({
                "name": "mark-1", "shape": "capsule", "radius": 1e-4, "length": 1e-3, "position": [0.0, 0.0, 0.0],
                "orientation": orientation, "colour": "#888888", "finish": "matte", "active": true,
            });
            serde_json::from_value(object).expect("an object")
        };
        let fault = MarkLine::new(&object([0.0, 0.0, 0.0, 1.0])).expect_err("upright");
        assert!(fault.to_string().contains("`orientation`"), "{fault}");
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let line = MarkLine::new(&object([-half, 0.0, 0.0, half])).expect("it lies");
        assert!((line.across[0].abs() - 1.0).abs() < 1e-12, "{line:?}");
    }
}
