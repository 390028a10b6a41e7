//! Joints of a tool: how its parts move as it opens. A tool of a new kind has a new joint here.

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

/// How a part of a tool moves in the tool's frame as the tool opens.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Joint {
    /// Not at all: it belongs to the shaft.
    #[default]
    Fixed,
    /// It turns: a jaw.
    Hinge(Hinge),
}

/// Upper bounds for the axis of a part while the tool opens or closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointBounds {
    /// Length of the path of any of its points in the tool's frame \[m\].
    pub path: f64,
    /// Distance of any of its points from the tool's origin \[m\].
    pub reach: f64,
}

impl Joint {
    /// A capsule of the closed tool at an opening.
    pub fn capsule_at(&self, closed: &Capsule, opening: f64) -> Capsule {
        match self {
            Self::Fixed => *closed,
            Self::Hinge(hinge) => hinge.turned(closed, opening),
        }
    }

    /// A direction on the part of the closed tool, at an opening.
    pub fn direction_at(&self, closed: Vector3<f64>, opening: f64) -> Vector3<f64> {
        match self {
            Self::Fixed => closed,
            Self::Hinge(hinge) => hinge.rotation(opening) * closed,
        }
    }

    /// Bounds for the part while the opening goes `from` one value `to` another.
    pub fn bounds(&self, closed: &Capsule, [from, to]: [f64; 2]) -> JointBounds {
        let reach = |point: &Vector3<f64>| (closed.a - point).norm().max((closed.b - point).norm());
        match self {
            Self::Fixed => JointBounds {
                path: 0.0,
                reach: reach(&Vector3::zeros()),
            },
            Self::Hinge(hinge) => {
                let arm = reach(&hinge.pivot);
                JointBounds {
                    path: arm * (hinge.angle * (to - from)).abs(),
                    reach: hinge.pivot.norm() + arm,
                }
            }
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Fixed => true,
            Self::Hinge(Hinge { pivot, axis, angle }) => axis
                .iter()
                .chain(pivot)
                .chain([angle])
                .all(|c| c.is_finite()),
        }
    }
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
