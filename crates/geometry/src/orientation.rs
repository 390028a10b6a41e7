//! On which side of a plane a point lies, without rounding.

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

/// Six times the signed volume of the tetrahedron `(a, b, c, d)` \[m³\], with the exact sign: positive when `d` lies on the side
/// of `a`, `b`, `c` from which they run counter-clockwise, 0 when and only when the four points lie in one plane (Shewchuk 1997).
///
/// The value itself is rounded: near 0 it has the sign and hardly a digit more.
#[inline]
pub fn orientation(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>, d: &Vector3<f64>) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    // Shewchuk's sign is that of the left-handed order.
    -orient3d(a, b, c, d)
}
