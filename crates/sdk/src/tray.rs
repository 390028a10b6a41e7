//! The inner space of a tray: where a module finds out what lies in it.

use crate::fault::Fault;
use microsim_geometry::Pose;
use microsim_settings::{Rigid, RigidShape};
use nalgebra::Vector3;

/// The inner space of a rigid obstacle of the shape `tray`, from the floor to the rim.
///
/// ```
/// use microsim_sdk::Tray;
///
/// // Of a level's `[[rigid]]`, as [`ModuleConfig::rigid`](crate::ModuleConfig::rigid) has them.
/// let rigid: Vec<_> = serde_json::from_value(serde_json::json!([{
///     "name": "tray", "shape": "tray", "half_size": [0.004, 0.002, 0.001], "wall": 0.0005,
///     "position": [0.01, 0.0, -0.005], "orientation": [0.0, 0.0, 0.0, 1.0],
///     "colour": "#c8ccd0", "finish": "matte",
/// }]))?;
/// let tray = Tray::named(&rigid, "tray")?;
/// assert!(tray.contains([0.011, 0.001, -0.005]));
/// assert!(!tray.contains([0.0, 0.0, 0.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tray {
    name: String,
    pose: Pose,
    /// \[m\]
    half_size: [f64; 3],
}

impl Tray {
    /// The tray of this name among the rigid obstacles of a level. A fault where there is none.
    pub fn named(rigid: &[Rigid], name: &str) -> Result<Self, Fault> {
        let obstacle = rigid.iter().find(|rigid| rigid.name == name);
        match obstacle.map(|rigid| (rigid, rigid.shape)) {
            Some((rigid, RigidShape::Tray { half_size, .. })) => Ok(Self {
                name: name.to_owned(),
                pose: Pose::from_arrays(rigid.position, rigid.orientation),
                half_size,
            }),
            _ => Err(Fault::new(format!(
                "the level needs a [[rigid]] obstacle \"{name}\" of the shape \"tray\""
            ))),
        }
    }

    /// The obstacle's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The place nearest to a point of the field \[m\] that is in it or straight above it.
    pub fn nearest(&self, point: [f64; 3]) -> [f64; 3] {
        let ([x, y, z], inner) = (self.half_size, self.inner(point));
        let nearest = Vector3::new(inner.x.clamp(-x, x), inner.y.clamp(-y, y), inner.z.max(-z));
        (self.pose.position + self.pose.orientation * nearest).into()
    }

    /// Whether a point of the field \[m\] is in it.
    pub fn contains(&self, point: [f64; 3]) -> bool {
        self.is_above(point) && self.inner(point).z <= self.half_size[2]
    }

    /// Whether a point of the field \[m\] is in it or straight above it: what is let go there falls into it.
    pub fn is_above(&self, point: [f64; 3]) -> bool {
        let inner = self.inner(point);
        (0..2).all(|k| inner[k].abs() <= self.half_size[k]) && inner.z >= -self.half_size[2]
    }

    /// A point of the field in its own frame \[m\].
    fn inner(&self, point: [f64; 3]) -> Vector3<f64> {
        self.pose.orientation.inverse() * (Vector3::from(point) - self.pose.position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn obstacles(rigid: Value) -> Vec<Rigid> {
        serde_json::from_value(rigid).expect("rigid obstacles")
    }

    /// Turned by a quarter about z, its long side lies along y.
    #[test]
    fn a_turned_tray_holds_what_lies_along_its_own_axes() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let rigid = obstacles(json!([{
            "name": "tray", "shape": "tray", "half_size": [0.004, 0.002, 0.001], "wall": 0.0005,
            "position": [0.01, 0.0, -0.005], "orientation": [0.0, 0.0, half, half],
            "colour": "#c8ccd0", "finish": "matte",
        }]));
        let tray = Tray::named(&rigid, "tray").expect("a tray");
        assert!(tray.contains([0.011, 0.0035, -0.0045]));
        assert!(!tray.contains([0.0135, 0.0, -0.005]));
        assert!(!tray.contains([0.01, 0.0, -0.0035]), "above the rim");
        assert!(tray.is_above([0.01, 0.0, -0.0035]));
        for outside in [[0.0135, 0.0, -0.0035], [0.01, 0.0, -0.0065]] {
            assert!(!tray.contains(outside), "beside it, or below the floor");
            assert!(!tray.is_above(outside));
        }
        // From the origin, 10 mm beside its middle and 5 mm above it: to where its short side ends, at the same height.
        let nearest = tray.nearest([0.0; 3]);
        let away = crate::tissue::distance(nearest, [0.008, 0.0, 0.0]);
        assert!(away < 1e-15, "{nearest:?}");
    }

    #[test]
    fn what_is_no_tray_is_refused_by_name() {
        let plane = obstacles(json!([{
            "name": "tray", "shape": "plane", "position": [0.0, 0.0, 0.0],
            "orientation": [0.0, 0.0, 0.0, 1.0], "colour": "#c8ccd0", "finish": "matte",
        }]));
        for rigid in [plane, Vec::new()] {
            let fault = Tray::named(&rigid, "tray").expect_err("no tray");
            assert!(fault.to_string().contains("\"tray\""), "{fault}");
        }
    }
}
