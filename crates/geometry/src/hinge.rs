//! Parts of a tool that turn about a hinge: jaws.

use crate::capsule::Capsule;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// A hinge in the frame of a tool: its part turns in proportion to the tool's opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hinge {
    /// A point of the axis \[m\].
    pub pivot: Vector3<f64>,
    /// Direction of the axis.
    pub axis: Unit<Vector3<f64>>,
    /// Right-handed angle about the axis per unit of opening \[rad\].
    pub angle: f64,
}

impl Hinge {
    /// The rotation at an opening.
    pub fn rotation(&self, opening: f64) -> UnitQuaternion<f64> {
        let half = 0.5 * self.angle * opening;
        let (cosine, sine) = (libm::cos(half), libm::sin(half));
        UnitQuaternion::new_normalize(Quaternion::from_parts(
            cosine,
            self.axis.into_inner() * sine,
        ))
    }

    /// A capsule of the closed tool at an opening.
    ///
    /// ```
    /// use microsim_geometry::{Capsule, Hinge};
    /// use nalgebra::Vector3;
    ///
    /// // A jaw from its tip at the origin up to the hinge, which turns by 90° per unit of opening.
    /// let pivot = Vector3::z() * 0.01;
    /// let hinge = Hinge { pivot, axis: Vector3::y_axis(), angle: std::f64::consts::FRAC_PI_2 };
    /// let open = hinge.turned(&Capsule { a: Vector3::zeros(), b: pivot, radius: 1e-4 }, 1.0);
    /// assert!((open.a - Vector3::new(-0.01, 0.0, 0.01)).norm() < 1e-15 && open.b == pivot);
    /// ```
    pub fn turned(&self, closed: &Capsule, opening: f64) -> Capsule {
        let turn = self.rotation(opening);
        let turned = |p: &Vector3<f64>| self.pivot + turn * (p - self.pivot);
        Capsule {
            a: turned(&closed.a),
            b: turned(&closed.b),
            radius: closed.radius,
        }
    }
}
