//! Edges through triangles, and the closest points of both.

use crate::orientation::orientation;
use crate::segment::SegmentPoint;
use crate::triangle::{SegmentTriangle, closest_features, closest_on_triangle};
use nalgebra::Vector3;

/// A crossing point that is further from the triangle than this fraction of the largest length or coordinate is not the best that can be had: edge and
/// triangle are then almost coplanar, or the triangle has almost no area.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

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
/// gap. By the same rule an edge in the plane of the triangle does not go through it, whatever they have in common: then edges meet, and
/// the closest points of edges decide. Nothing goes through a triangle without area, and an edge without length goes
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
    // What is not a number is neither positive nor negative, and comes to here.
    if (at_p - at_q).is_nan() || parts.iter().any(|v| v.is_nan()) {
        return None;
    }
    let points = crossing_point(p, q, triangle);
    Some(EdgeCrossing {
        points,
        from_front: at_p > at_q,
    })
}

/// The closest points of the segment `a`–`b` and a triangle: the true closest feature among the crossing point
/// ([`edge_through_triangle`]), the end points against the triangle, the corners against the segment, and the segment against the insides
/// of the edges. For a capsule, the segment is its axis.
pub fn closest_segment_triangle(
    a: &Vector3<f64>,
    b: &Vector3<f64>,
    triangle: &[Vector3<f64>; 3],
) -> SegmentTriangle {
    if let Some(crossing) = edge_through_triangle(a, b, triangle) {
        return crossing.points;
    }
    closest_features(a, b, triangle)
}

/// The point of an edge that goes through a triangle (A.14), on the edge; the coordinates are those of the triangle's closest point. Where
/// that leaves more than rounding, the closest points without the crossing are a second candidate: the better one is
/// within 1e-6 of the longest length.
fn crossing_point(
    p: &Vector3<f64>,
    q: &Vector3<f64>,
    triangle: &[Vector3<f64>; 3],
) -> SegmentTriangle {
    let [a, b, c] = triangle;
    let (along, ap, normal) = (q - p, p - a, (b - a).cross(&(c - a)));
    let volume = -along.dot(&normal);
    let t = ap.dot(&normal) / volume;
    // Once more from the first result: what rounding left of the height there.
    let t = t + (ap + along * t).dot(&normal) / volume;
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let point = p + along * t;
    let mut points = SegmentTriangle {
        on_segment: SegmentPoint { point, t },
        on_triangle: closest_on_triangle(&point, triangle),
    };
    let longest = [along, ap, b - a, c - a, point]
        .iter()
        .map(Vector3::amax)
        .fold(0.0, f64::max);
    if points.distance() > ROUNDING * longest {
        let others = closest_features(p, q, triangle);
        if others.distance() < points.distance() {
            points = others;
        }
    }
    points.on_triangle.point = points.on_segment.point;
    points
}

#[cfg(test)]
mod tests;
