//! Obstacles: half-spaces, boxes, cylinders that do not move.

use microsim_geometry::{Aabb, Pose};
use nalgebra::Vector3;

/// The shape of a part of an obstacle, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObstacleShape {
    /// All that is below the plane z = 0.
    HalfSpace,
    /// A box around the origin.
    Cuboid {
        /// Half of its size along x, y and z \[m\], > 0, the rounding included.
        half_size: [f64; 3],
        /// Radius of its edges and corners \[m\], from 0 to the smallest half size.
        rounding: f64,
    },
    /// A solid cylinder around the z axis, its middle at the origin.
    Cylinder {
        /// Radius \[m\], > 0.
        radius: f64,
        /// Half of its length \[m\], > 0.
        half_length: f64,
    },
}

/// A part of an obstacle, a convex rigid shape that does not move. What is hollow, a tray or a clamp, has several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObstaclePart {
    /// Its shape.
    pub shape: ObstacleShape,
    /// `world_from_part`.
    pub pose: Pose,
}

impl ObstaclePart {
    /// The signed distance of `p` \[m\], below 0 inside, and the unit vector along which it grows: the outward normal at the
    /// surface point that is nearest to `p`.
    ///
    /// ```
    /// use microsim_contact::{ObstaclePart, ObstacleShape};
    /// use microsim_geometry::Pose;
    /// use nalgebra::Vector3;
    ///
    /// let shape = ObstacleShape::Cylinder { radius: 1.0, half_length: 2.0 };
    /// let part = ObstaclePart { shape, pose: Pose::identity() };
    /// assert_eq!(part.distance(&Vector3::new(3.0, 0.0, 0.5)), (2.0, Vector3::x()));
    /// assert_eq!(part.distance(&Vector3::new(0.0, 0.5, 0.0)), (-0.5, Vector3::y()));
    /// ```
    pub fn distance(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let inverse = self.pose.orientation.inverse();
        let local = inverse * (p - self.pose.position);
        let (distance, normal) = match self.shape {
            ObstacleShape::HalfSpace => (local.z, Vector3::z()),
            ObstacleShape::Cuboid {
                half_size,
                rounding,
            } => cuboid(&local, &Vector3::from(half_size), rounding),
            ObstacleShape::Cylinder {
                radius,
                half_length,
            } => cylinder(&local, radius, half_length),
        };
        (distance, self.pose.orientation * normal)
    }

    /// How far it reaches along the unit vector `direction`: the largest coordinate of its points along it \[m\].
    pub(crate) fn support(&self, direction: &Vector3<f64>) -> f64 {
        let local = self.pose.orientation.inverse() * direction;
        let reach = match self.shape {
            ObstacleShape::HalfSpace => 0.0,
            ObstacleShape::Cuboid {
                half_size,
                rounding,
            } => {
                let inner = Vector3::from(half_size).add_scalar(-rounding);
                inner.dot(&local.abs()) + rounding
            }
            ObstacleShape::Cylinder {
                radius,
                half_length,
            } => {
                radius * (local.x * local.x + local.y * local.y).sqrt()
                    + half_length * local.z.abs()
            }
        };
        reach + self.pose.position.dot(direction)
    }

    /// The smallest half of its thickness \[m\].
    pub(crate) fn half_thickness(&self) -> f64 {
        match self.shape {
            ObstacleShape::HalfSpace => f64::INFINITY,
            ObstacleShape::Cuboid { half_size, .. } => {
                half_size.into_iter().fold(f64::MAX, f64::min)
            }
            ObstacleShape::Cylinder {
                radius,
                half_length,
            } => radius.min(half_length),
        }
    }

    /// A box that holds it; without bounds for a half-space.
    pub fn bounds(&self) -> Aabb {
        let half = match self.shape {
            ObstacleShape::HalfSpace => {
                return Aabb {
                    min: Vector3::repeat(f64::NEG_INFINITY),
                    max: Vector3::repeat(f64::INFINITY),
                };
            }
            ObstacleShape::Cuboid { half_size, .. } => Vector3::from(half_size),
            ObstacleShape::Cylinder {
                radius,
                half_length,
            } => Vector3::new(radius, radius, half_length),
        };
        let rotation = self.pose.orientation.to_rotation_matrix();
        let reach = rotation.matrix().abs() * half;
        Aabb {
            min: self.pose.position - reach,
            max: self.pose.position + reach,
        }
    }
}

/// 1 or −1.
fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// A box with round edges is a smaller one, grown by their radius.
fn cuboid(p: &Vector3<f64>, half: &Vector3<f64>, rounding: f64) -> (f64, Vector3<f64>) {
    let over = p.abs() - half.add_scalar(-rounding);
    let outside = over.sup(&Vector3::zeros());
    let distance = outside.norm();
    if distance > 0.0 {
        let normal = outside.component_mul(&p.map(sign)) / distance;
        return (distance - rounding, normal);
    }
    // The nearest face; of several equally near ones the first.
    let axis = (1..3).fold(0, |best, k| if over[k] > over[best] { k } else { best });
    let mut normal = Vector3::zeros();
    normal[axis] = sign(p[axis]);
    (over[axis] - rounding, normal)
}

fn cylinder(p: &Vector3<f64>, radius: f64, half_length: f64) -> (f64, Vector3<f64>) {
    let from_axis = (p.x * p.x + p.y * p.y).sqrt();
    let radial = if from_axis > 0.0 {
        Vector3::new(p.x / from_axis, p.y / from_axis, 0.0)
    } else {
        Vector3::x()
    };
    let axial = Vector3::new(0.0, 0.0, sign(p.z));
    let (over_side, over_end) = (from_axis - radius, p.z.abs() - half_length);
    if over_side > 0.0 && over_end > 0.0 {
        let distance = (over_side * over_side + over_end * over_end).sqrt();
        let normal = (radial * over_side + axial * over_end) / distance;
        return (distance, normal);
    }
    if over_side >= over_end {
        (over_side, radial)
    } else {
        (over_end, axial)
    }
}
