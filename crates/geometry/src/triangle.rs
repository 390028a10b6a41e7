//! Closest points of triangles.

use crate::segment::{SegmentPoint, closest_inside, closest_on_segment};
use nalgebra::Vector3;

/// A triangle whose sin² between two edges is below this has no usable normal.
const FLAT_SIN_SQUARED: f64 = 1e-14;

/// A triangle whose sin² between two edges is below this (a corner of 6°, or of 174°) is thin: the coordinates along two of its
/// edges lose digits, those along its longest edge and the height on it do not.
const THIN_SIN_SQUARED: f64 = 1e-2;

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePoint {
    /// The point \[m\].
    pub point: Vector3<f64>,
    /// Its barycentric coordinates: not negative, sum 1.
    pub barycentric: [f64; 3],
}

/// The part of a triangle on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriangleFeature {
    /// Within the triangle.
    Face,
    /// On the edge that starts at this corner, between its ends.
    Edge(u8),
    /// On this corner.
    Corner(u8),
}

impl TrianglePoint {
    /// The part of the triangle on which the point lies.
    pub fn feature(&self) -> TriangleFeature {
        match self.barycentric.map(|b| b == 0.0) {
            [_, true, true] => TriangleFeature::Corner(0),
            [true, _, true] => TriangleFeature::Corner(1),
            [true, true, _] => TriangleFeature::Corner(2),
            [true, _, _] => TriangleFeature::Edge(1),
            [_, true, _] => TriangleFeature::Edge(2),
            [_, _, true] => TriangleFeature::Edge(0),
            [false, false, false] => TriangleFeature::Face,
        }
    }
}

/// The closest points of a segment and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentTriangle {
    /// The point on the segment.
    pub on_segment: SegmentPoint,
    /// The point on the triangle.
    pub on_triangle: TrianglePoint,
}

impl SegmentTriangle {
    /// Distance of the two points \[m\]; 0 when the segment pierces the triangle.
    pub fn distance(&self) -> f64 {
        self.distance_squared().sqrt()
    }

    fn distance_squared(&self) -> f64 {
        (self.on_triangle.point - self.on_segment.point).norm_squared()
    }
}

/// Unit normal of a triangle by the right-hand rule; `None` when it has no area.
pub fn triangle_normal(triangle: &[Vector3<f64>; 3]) -> Option<Vector3<f64>> {
    let (e1, e2) = (triangle[1] - triangle[0], triangle[2] - triangle[0]);
    let normal = e1.cross(&e2);
    let squared = normal.norm_squared();
    (squared > FLAT_SIN_SQUARED * e1.norm_squared() * e2.norm_squared())
        .then(|| normal / squared.sqrt())
}

/// The point of a triangle closest to `p`: the orthogonal projection (A.7, A.8) where it falls inside, else the
/// closest point of the three edges.
///
/// ```
/// use microsim_geometry::{TriangleFeature, closest_on_triangle};
/// use nalgebra::Vector3;
///
/// let triangle = [Vector3::zeros(), Vector3::x(), Vector3::y()];
/// let found = closest_on_triangle(&Vector3::new(0.25, 0.25, 3.0), &triangle);
/// assert_eq!(found.point, Vector3::new(0.25, 0.25, 0.0));
/// assert_eq!((found.barycentric, found.feature()), ([0.5, 0.25, 0.25], TriangleFeature::Face));
/// ```
pub fn closest_on_triangle(p: &Vector3<f64>, triangle: &[Vector3<f64>; 3]) -> TrianglePoint {
    let [a, b, c] = triangle;
    let (v0, v1, v2) = (b - a, c - a, p - a);
    let normal = v0.cross(&v1);
    let squared = normal.norm_squared();
    let thin = squared <= THIN_SIN_SQUARED * v0.norm_squared() * v1.norm_squared();
    let inside = if thin {
        thin_projection(p, triangle)
    } else {
        // A.7 and A.8 as triple products: equal to the quotients of scalar products, which lose twice as many digits.
        let s = v2.cross(&v1).dot(&normal) / squared;
        let t = v0.cross(&v2).dot(&normal) / squared;
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| TrianglePoint {
            point: a + (v0 * s + v1 * t),
            barycentric: [1.0 - s - t, s, t],
        })
    };
    if let Some(inside) = inside
        && !thin
    {
        return inside;
    }
    let mut best = edge_point(&closest_on_segment(p, a, b), 0);
    let edges = (1..3).map(|edge| {
        let on_edge = closest_on_segment(p, &triangle[edge], &triangle[(edge + 1) % 3]);
        edge_point(&on_edge, edge)
    });
    for candidate in edges.chain(inside) {
        if (candidate.point - p).norm_squared() < (best.point - p).norm_squared() {
            best = candidate;
        }
    }
    best
}

/// The projection of `p` onto a thin triangle, when it falls inside.
///
/// The height is only known to rounding of the longest edge, and with it the plane: of what is close to the plane the projection
/// is right all the same, and of what is not, its error changes the distance in second order.
fn thin_projection(p: &Vector3<f64>, triangle: &[Vector3<f64>; 3]) -> Option<TrianglePoint> {
    let length = |k: usize| (triangle[(k + 1) % 3] - triangle[k]).norm_squared();
    let first = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [i, j, k] = [first, (first + 1) % 3, (first + 2) % 3];
    let (edge, side, v) = (
        triangle[j] - triangle[i],
        triangle[k] - triangle[i],
        p - triangle[i],
    );
    let ratio = |v: &Vector3<f64>, of: &Vector3<f64>| v.dot(of) / of.norm_squared();
    // What the first subtraction rounds, the second takes off: the height is then normal to the edge.
    let mut height = side - edge * ratio(&side, &edge);
    height -= edge * ratio(&height, &edge);
    let s = ratio(&v, &height);
    let t = ratio(&v, &edge) - s * ratio(&side, &edge);
    let mut barycentric = [0.0; 3];
    (barycentric[i], barycentric[j], barycentric[k]) = (1.0 - s - t, t, s);
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| TrianglePoint {
        point: triangle[i] + (edge * t + side * s),
        barycentric,
    })
}

/// The closest points of a segment and a triangle without their crossing point: of those parts of which one is an end or an edge.
pub(crate) fn closest_features(
    a: &Vector3<f64>,
    b: &Vector3<f64>,
    triangle: &[Vector3<f64>; 3],
) -> SegmentTriangle {
    let mut best = SegmentTriangle {
        on_segment: SegmentPoint { point: *a, t: 0.0 },
        on_triangle: closest_on_triangle(a, triangle),
    };
    let mut consider = |candidate: SegmentTriangle| {
        if candidate.distance_squared() < best.distance_squared() {
            best = candidate;
        }
    };
    consider(SegmentTriangle {
        on_segment: SegmentPoint { point: *b, t: 1.0 },
        on_triangle: closest_on_triangle(b, triangle),
    });
    for corner in 0..3 {
        let (start, end) = (&triangle[corner], &triangle[(corner + 1) % 3]);
        consider(SegmentTriangle {
            on_segment: closest_on_segment(start, a, b),
            on_triangle: edge_point(
                &SegmentPoint {
                    point: *start,
                    t: 0.0,
                },
                corner,
            ),
        });
        if let Some(pair) = closest_inside(a, b, start, end) {
            consider(SegmentTriangle {
                on_segment: pair.first,
                on_triangle: edge_point(&pair.second, corner),
            });
        }
    }
    best
}

/// A point of the edge that starts at corner `edge`, as a point of the triangle.
fn edge_point(on_edge: &SegmentPoint, edge: usize) -> TrianglePoint {
    let mut barycentric = [0.0; 3];
    barycentric[edge] = 1.0 - on_edge.t;
    barycentric[(edge + 1) % 3] = on_edge.t;
    TrianglePoint {
        point: on_edge.point,
        barycentric,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crossing::closest_segment_triangle;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0f64].prop_map(Vector3::from)
    }

    fn from_barycentric(triangle: &[Vector3<f64>; 3], b: &[f64; 3]) -> Vector3<f64> {
        triangle[0] * b[0] + triangle[1] * b[1] + triangle[2] * b[2]
    }

    /// All points of a regular grid of `n` steps on the triangle.
    fn grid(triangle: [Vector3<f64>; 3], n: usize) -> impl Iterator<Item = Vector3<f64>> {
        (0..=n).flat_map(move |i| {
            (0..=n - i).map(move |j| {
                let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
                from_barycentric(&triangle, &[1.0 - s - t, s, t])
            })
        })
    }

    fn longest_edge(t: &[Vector3<f64>; 3]) -> f64 {
        (0..3)
            .map(|k| (t[(k + 1) % 3] - t[k]).norm())
            .fold(0.0, f64::max)
    }

    fn check_barycentric(
        found: &TrianglePoint,
        triangle: &[Vector3<f64>; 3],
        scale: f64,
    ) -> Result<(), TestCaseError> {
        let b = found.barycentric;
        prop_assert!(
            b.iter().all(|&c| (-1e-15..=1.0 + 1e-15).contains(&c)),
            "{b:?}"
        );
        prop_assert!((b.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        // The barycentric point of a crossing and the point on the segment agree within the conditioning of the plane.
        prop_assert!((from_barycentric(triangle, &b) - found.point).norm() < 1e-6 * scale);
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

        /// Brute force over a grid: nothing sampled is closer; the best sample is within one cell of the result.
        #[test]
        fn point_and_triangle_agree_with_sampling(p in vector(), triangle in [vector(), vector(), vector()],
                                                  flat in 0..4u8, scale in prop::sample::select(vec![1.0, 1e-4, 1e4])) {
            let mut triangle = triangle;
            if flat == 0 {
                triangle[2] = triangle[0] + (triangle[1] - triangle[0]) * 0.4;
            }
            let (p, triangle) = (p * scale, triangle.map(|c| c * scale));
            let found = closest_on_triangle(&p, &triangle);
            let distance = (found.point - p).norm();
            let sampled = grid(triangle, 30).map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(distance <= sampled + 1e-12 * scale);
            prop_assert!(distance >= sampled - longest_edge(&triangle) / 30.0);
            check_barycentric(&found, &triangle, scale)?;
        }

        #[test]
        fn segment_and_triangle_agree_with_sampling(a in vector(), b in vector(), triangle in [vector(), vector(), vector()],
                                                    kind in 0..4u8, scale in prop::sample::select(vec![1.0, 1e-4, 1e4])) {
            // One case in four is parallel to the plane, one has a segment of length zero.
            let b = match kind {
                0 => a + (triangle[1] - triangle[0]) * 0.8,
                1 => a,
                _ => b,
            };
            let (a, b, triangle) = (a * scale, b * scale, triangle.map(|c| c * scale));
            let found = closest_segment_triangle(&a, &b, &triangle);
            let distance = found.distance();
            const N: usize = 16;
            let mut sampled = f64::INFINITY;
            for i in 0..=N {
                let p = a + (b - a) * (i as f64 / N as f64);
                sampled = grid(triangle, N).map(|q| (q - p).norm()).fold(sampled, f64::min);
            }
            let spacing = ((b - a).norm() / 2.0 + longest_edge(&triangle)) / N as f64;
            prop_assert!(distance <= sampled + 1e-12 * scale);
            prop_assert!(distance >= sampled - spacing);
            check_barycentric(&found.on_triangle, &triangle, scale)?;
        }
    }

    #[test]
    fn closest_features_of_known_cases() {
        let triangle = [Vector3::zeros(), Vector3::x(), Vector3::y()];
        // (segment, expected distance, expected barycentric coordinates)
        let cases = [
            // An end above the inside; above a corner; beside an edge.
            ([0.25, 0.25, 1.0], [0.25, 0.25, 3.0], 1.0, [0.5, 0.25, 0.25]),
            ([-3.0, -4.0, 0.0], [-6.0, -8.0, 0.0], 5.0, [1.0, 0.0, 0.0]),
            ([0.5, -2.0, 1.0], [0.5, -2.0, -1.0], 2.0, [0.5, 0.5, 0.0]),
            // Piercing from either side.
            ([0.25, 0.5, 1.0], [0.25, 0.5, -1.0], 0.0, [0.25, 0.25, 0.5]),
            ([0.25, 0.5, -1.0], [0.25, 0.5, 1.0], 0.0, [0.25, 0.25, 0.5]),
        ];
        for (a, b, distance, barycentric) in cases {
            let found = closest_segment_triangle(&a.into(), &b.into(), &triangle);
            assert!(
                (found.distance() - distance).abs() < 1e-15,
                "{a:?} {b:?}: {found:?}"
            );
            assert_eq!(found.on_triangle.barycentric, barycentric, "{a:?} {b:?}");
        }
        assert_eq!(triangle_normal(&triangle), Some(Vector3::z()));
        assert_eq!(
            triangle_normal(&[Vector3::zeros(), Vector3::x(), Vector3::x() * 2.0]),
            None
        );
    }
}
