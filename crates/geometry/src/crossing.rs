//! Edges through triangles.

use crate::orientation::orientation;
use crate::segment::SegmentPoint;
use crate::triangle::{SegmentTriangle, TrianglePoint, closest_features};
use nalgebra::Vector3;

/// An edge whose two ends span with the triangle less than this share of the largest product of their lengths runs so close to
/// its plane (or through so thin a triangle) that the quotients of volumes have lost half of their digits; the point is then
/// where both come closest, which they do within this share of their length.
const ILL_VOLUME: f64 = 1e-7;

/// An edge through a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeCrossing {
    /// The point of both, as a point of the edge and as one of the triangle.
    pub points: SegmentTriangle,
    /// Whether the edge's first end lies on the side of the triangle from which its corners run counter-clockwise, or the second on
    /// the other side: the sign of d (A.18).
    pub from_front: bool,
}

/// Where the edge `p`–`q` goes through the triangle (A.14–A.19 with the corrected rule of NUMERICS 1.5: either side counts).
///
/// Whether it does is decided without rounding, and ends, edges and corners belong to what they bound. So an edge through the
/// common edge of two triangles goes through both, an edge that only touches goes through, and a closed surface has no
/// gap. By the same rule an edge in the plane of the triangle does not go through it, whatever it shares with it: then edges meet, and
/// the closest points of edges tell. Nothing goes through a triangle without area, and an edge without length goes
/// through nothing.
pub fn edge_through_triangle(
    p: &Vector3<f64>,
    q: &Vector3<f64>,
    triangle: &[Vector3<f64>; 3],
) -> Option<EdgeCrossing> {
    let [a, b, c] = triangle;
    let (at_p, at_q) = (orientation(a, b, c, p), orientation(a, b, c, q));
    let apart = (at_p > 0.0 && at_q > 0.0) || (at_p < 0.0 && at_q < 0.0);
    let coplanar = at_p == 0.0 && at_q == 0.0;
    if apart || coplanar {
        return None;
    }
    let parts = [
        orientation(p, q, b, c),
        orientation(p, q, c, a),
        orientation(p, q, a, b),
    ];
    if parts.iter().any(|&v| v < 0.0) && parts.iter().any(|&v| v > 0.0) {
        return None;
    }
    let volume = at_p - at_q;
    // What is not a number is neither positive nor negative, and comes to here.
    if volume.is_nan() || parts.iter().any(|v| v.is_nan()) {
        return None;
    }
    // The largest product of three lengths that goes into one of the volumes.
    let length = (p - q).norm_squared();
    let longest = [b - a, c - b, a - c]
        .iter()
        .map(Vector3::norm_squared)
        .fold(0.0, f64::max);
    let squared = length * longest * length.max(longest);
    let points = if volume * volume > ILL_VOLUME * ILL_VOLUME * squared {
        let t = at_p / volume;
        let point = p + (q - p) * t;
        let sum: f64 = parts.iter().sum();
        SegmentTriangle {
            on_segment: SegmentPoint { point, t },
            on_triangle: TrianglePoint {
                point,
                barycentric: parts.map(|v| v / sum),
            },
        }
    } else {
        let mut closest = closest_features(p, q, triangle);
        closest.on_triangle.point = closest.on_segment.point;
        closest
    };
    Some(EdgeCrossing {
        points,
        from_front: volume > 0.0,
    })
}

#[cfg(test)]
mod tests;
