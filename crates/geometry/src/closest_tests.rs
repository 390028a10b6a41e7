//! Distances of all pairs of features against whole numbers of any length.

use crate::testing::{Points, exact, extent, rounding};
use crate::{
    SegmentPoint, TriangleFeature, TrianglePoint, closest_on_segment, closest_on_triangle,
    closest_segment_triangle, closest_segments,
};
use microsim_random::SplitMix64;
use nalgebra::Vector3;

/// Roundings in a distance: each of the two points is a corner plus two products, each with a rounded difference; their
/// difference and its norm: below 16 half units of the largest coordinate each. The parameters of a point may be further
/// off where that moves it along what it is closest to, which changes the distance in second order.
const ROUNDINGS: f64 = 16.0;

fn check(kind: &str, found: f64, squared: &exact::Ratio, unit: i32, points: &[Vector3<f64>]) {
    let expected = libm::ldexp(squared.rounded().sqrt(), unit);
    let allowed = ROUNDINGS * rounding(points);
    assert!(
        (found - expected).abs() <= allowed,
        "{kind}: {found:e}, not {expected:e}: off by {:e} of {allowed:e}; {points:?}",
        (found - expected).abs()
    );
}

fn on_segment(p: &SegmentPoint, a: &Vector3<f64>, b: &Vector3<f64>, allowed: f64) {
    assert!((0.0..=1.0).contains(&p.t));
    assert!((a + (b - a) * p.t - p.point).amax() <= allowed);
}

fn on_triangle(p: &TrianglePoint, triangle: &[Vector3<f64>; 3], allowed: f64) {
    let b = p.barycentric;
    // 1 − s − t, where s + t ≤ 1 after rounding.
    assert!(
        b.iter().all(|&b| (-f64::EPSILON..=1.0).contains(&b)),
        "{b:?}"
    );
    let point = triangle[0] * b[0] + triangle[1] * b[1] + triangle[2] * b[2];
    assert!((point - p.point).amax() <= allowed, "{p:?} {triangle:?}");
}

#[test]
fn distances_equal_those_without_rounding() {
    let mut random = SplitMix64(2);
    let mut zeros = 0;
    for _ in 0..10_000 {
        let points: [_; 5] = random.points();
        let [p, q, a, b, c] = points;
        let triangle = [a, b, c];
        let ([ep, eq, ea, eb, ec], unit) = exact::points(&points);
        let allowed = ROUNDINGS * rounding(&points);

        let found = closest_on_segment(&p, &a, &b);
        on_segment(&found, &a, &b, allowed);
        let expected = exact::point_segment(&ep, &ea, &eb);
        check(
            "point, segment",
            (found.point - p).norm(),
            &expected,
            unit,
            &points,
        );

        let found = closest_segments(&p, &q, &a, &b);
        on_segment(&found.first, &p, &q, allowed);
        on_segment(&found.second, &a, &b, allowed);
        let edge = [ep.clone(), eq];
        let expected = exact::segments(&edge, &[ea.clone(), eb.clone()]);
        let distance = found.distance_squared().sqrt();
        check("segments", distance, &expected, unit, &points);

        let triangle_exact = [ea, eb, ec];
        let found = closest_on_triangle(&p, &triangle);
        on_triangle(&found, &triangle, allowed);
        let expected = exact::point_triangle(&ep, &triangle_exact);
        check(
            "point, triangle",
            (found.point - p).norm(),
            &expected,
            unit,
            &points,
        );

        let found = closest_segment_triangle(&p, &q, &triangle);
        on_segment(&found.on_segment, &p, &q, allowed);
        let expected = exact::segment_triangle(&edge, &triangle_exact);
        check(
            "segment, triangle",
            found.distance(),
            &expected,
            unit,
            &points,
        );
        zeros += u32::from(expected.is_zero());
        // The point of a crossing lies on the edge; the triangle's is at most 1e-6 away from it (see `crossing`).
        on_triangle(
            &found.on_triangle,
            &triangle,
            allowed + 1e-6 * extent(&points),
        );
    }
    assert!(zeros > 1_500, "{zeros}");
}

/// Multiplied by a power of two, which rounds nothing, the answer is the same to the bit.
#[test]
fn answers_scale_with_the_input() {
    let mut random = SplitMix64(3);
    for _ in 0..10_000 {
        let points: [_; 5] = random.points();
        let weights = |points: [Vector3<f64>; 5]| {
            let [p, q, a, b, c] = points;
            let found = closest_segments(&p, &q, &a, &b);
            let both = closest_segment_triangle(&p, &q, &[a, b, c]);
            (
                [
                    closest_on_segment(&p, &a, &b).t,
                    found.first.t,
                    found.second.t,
                ],
                closest_on_triangle(&p, &[a, b, c]).barycentric,
                both.on_segment.t,
                both.on_triangle.barycentric,
            )
        };
        let expected = weights(points);
        for scale in [2f64.powi(-30), 0.5, 2f64.powi(40)] {
            assert_eq!(weights(points.map(|p| p * scale)), expected, "{points:?}");
        }
    }
}

#[test]
fn the_closest_feature_of_a_triangle_is_named() {
    let triangle = [Vector3::zeros(), Vector3::x(), Vector3::y()];
    for (p, feature) in [
        ([0.25, 0.25, 3.0], TriangleFeature::Face),
        ([0.5, -1.0, 0.0], TriangleFeature::Edge(0)),
        ([1.0, 1.0, 1.0], TriangleFeature::Edge(1)),
        ([-1.0, 0.5, 2.0], TriangleFeature::Edge(2)),
        ([-1.0, -2.0, 0.0], TriangleFeature::Corner(0)),
        ([3.0, -1.0, 0.0], TriangleFeature::Corner(1)),
        ([-1.0, 5.0, 1.0], TriangleFeature::Corner(2)),
    ] {
        let found = closest_on_triangle(&p.into(), &triangle);
        assert_eq!(found.feature(), feature, "{p:?}");
    }
}
