//! Closest points of segments.

use nalgebra::Vector3;

/// A point on a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentPoint {
    /// The point \[m\].
    pub point: Vector3<f64>,
    /// Its place: 0 at the first end, 1 at the second.
    pub t: f64,
}

/// The closest points of two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentsClosest {
    /// The point on the first segment.
    pub first: SegmentPoint,
    /// The point on the second segment.
    pub second: SegmentPoint,
}

impl SegmentsClosest {
    /// Squared distance of the two points \[m²\].
    pub fn distance_squared(&self) -> f64 {
        (self.second.point - self.first.point).norm_squared()
    }
}

/// The point of the segment `a`–`b` closest to `p`.
#[inline]
pub fn closest_on_segment(p: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> SegmentPoint {
    let along = b - a;
    let length_squared = along.norm_squared();
    let t = if length_squared > 0.0 {
        ((p - a).dot(&along) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    // The far end is returned as it is, without the rounding of a + (b − a).
    let point = if t == 1.0 { *b } else { a + along * t };
    SegmentPoint { point, t }
}

/// The closest points of the segments `a0`–`a1` and `b0`–`b1`.
///
/// The squared distance is a convex quadratic over the unit square of the two parameters: its minimum lies inside the
/// square, or on a side of it, which is an end point against the other segment.
pub fn closest_segments(
    a0: &Vector3<f64>,
    a1: &Vector3<f64>,
    b0: &Vector3<f64>,
    b1: &Vector3<f64>,
) -> SegmentsClosest {
    if let Some(inside) = closest_inside(a0, a1, b0, b1) {
        return inside;
    }
    let mut best = SegmentsClosest {
        first: SegmentPoint { point: *a0, t: 0.0 },
        second: closest_on_segment(a0, b0, b1),
    };
    let candidates = [
        SegmentsClosest {
            first: SegmentPoint { point: *a1, t: 1.0 },
            second: closest_on_segment(a1, b0, b1),
        },
        SegmentsClosest {
            first: closest_on_segment(b0, a0, a1),
            second: SegmentPoint { point: *b0, t: 0.0 },
        },
        SegmentsClosest {
            first: closest_on_segment(b1, a0, a1),
            second: SegmentPoint { point: *b1, t: 1.0 },
        },
    ];
    for candidate in candidates {
        if candidate.distance_squared() < best.distance_squared() {
            best = candidate;
        }
    }
    best
}

/// The closest points of two lines where both lie on the segments; then no end point is closer.
///
/// With n = u × v the parameter is a triple product, which keeps its digits down to an angle of rounding, where the determinant
/// u²v² − (u·v)² has lost all of them at its square root. What it loses between nearly parallel lines, it loses along both
/// alike: the point of the second closest to that of the first is as close as the lines are there.
pub(crate) fn closest_inside(
    a0: &Vector3<f64>,
    a1: &Vector3<f64>,
    b0: &Vector3<f64>,
    b1: &Vector3<f64>,
) -> Option<SegmentsClosest> {
    let (u, v, w) = (a1 - a0, b1 - b0, b0 - a0);
    let n = u.cross(&v);
    // Not a number for parallel lines, and then inside of nothing.
    let s = w.cross(&v).dot(&n) / n.norm_squared();
    if !(0.0..=1.0).contains(&s) {
        return None;
    }
    let first = SegmentPoint {
        point: a0 + u * s,
        t: s,
    };
    let t = (first.point - b0).dot(&v) / v.norm_squared();
    let second = SegmentPoint {
        point: b0 + v * t,
        t,
    };
    (0.0..=1.0)
        .contains(&t)
        .then_some(SegmentsClosest { first, second })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        [-1.0..1.0, -1.0..1.0, -1.0..1.0f64].prop_map(Vector3::from)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

        /// Brute force: no sampled pair is closer, and the sampled minimum is closer than half a sample spacing per
        /// segment allows.
        #[test]
        fn segments_agree_with_sampling(a0 in vector(), a1 in vector(), b0 in vector(), b1 in vector(),
                                        parallel in any::<bool>(), scale in prop::sample::select(vec![1.0, 1e-4, 1e4])) {
            let b1 = if parallel { b0 + (a1 - a0) * 0.7 } else { b1 };
            let [a0, a1, b0, b1] = [a0, a1, b0, b1].map(|p| p * scale);
            let found = closest_segments(&a0, &a1, &b0, &b1);
            let distance = found.distance_squared().sqrt();
            const N: usize = 40;
            let mut sampled = f64::INFINITY;
            for i in 0..=N {
                let p = a0 + (a1 - a0) * (i as f64 / N as f64);
                for j in 0..=N {
                    let q = b0 + (b1 - b0) * (j as f64 / N as f64);
                    sampled = sampled.min((p - q).norm());
                }
            }
            let spacing = ((a1 - a0).norm() + (b1 - b0).norm()) / (2.0 * N as f64);
            prop_assert!(distance <= sampled + 1e-12 * scale, "{distance} > {sampled}");
            prop_assert!(distance >= sampled - spacing);
            prop_assert!((a0 + (a1 - a0) * found.first.t - found.first.point).norm() < 1e-14 * scale);
            prop_assert!((b0 + (b1 - b0) * found.second.t - found.second.point).norm() < 1e-14 * scale);
        }
    }

    #[test]
    fn a_segment_of_length_zero_is_its_point() {
        let p = Vector3::new(1.0, 2.0, 3.0);
        assert_eq!(
            closest_on_segment(&Vector3::zeros(), &p, &p),
            SegmentPoint { point: p, t: 0.0 }
        );
        let found = closest_segments(&p, &p, &Vector3::zeros(), &Vector3::x());
        assert_eq!((found.first.point, found.second.point), (p, Vector3::x()));
    }
}
