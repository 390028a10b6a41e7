use super::*;
use crate::testing::{Points, exact, extent};
use microsim_random::SplitMix64;

/// The decision is that of arithmetic without rounding in every one of 10,000 configurations; the point is one of both.
#[test]
fn edges_go_through_as_whole_numbers_say() {
    let mut random = SplitMix64(4);
    let (mut through, mut touching, mut rough) = (0, 0, 0);
    for _ in 0..10_000 {
        let points: [_; 5] = random.points();
        let [p, q, a, b, c] = points;
        let triangle = [a, b, c];
        let ([ep, eq, ea, eb, ec], _) = exact::points(&points);
        let [at_p, at_q] = [&ep, &eq].map(|end| exact::volume(&ea, &eb, &ec, end));
        let expected = exact::goes_through(&[ep, eq], &[ea, eb, ec]);
        let found = edge_through_triangle(&p, &q, &triangle);
        assert_eq!(found.is_some(), expected, "{points:?}");
        // The triangle turned round, or started at another corner, or the edge turned round.
        for other in [
            edge_through_triangle(&p, &q, &[b, c, a]),
            edge_through_triangle(&p, &q, &[a, c, b]),
            edge_through_triangle(&q, &p, &triangle),
        ] {
            assert_eq!(other.is_some(), expected, "{points:?}");
        }
        let Some(found) = found else { continue };
        through += 1;
        assert_eq!(found.from_front, at_p > at_q);
        let b = found.points.on_triangle.barycentric;
        touching += u32::from(b.contains(&0.0) || [0.0, 1.0].contains(&found.points.on_segment.t));
        let on_triangle = triangle[0] * b[0] + triangle[1] * b[1] + triangle[2] * b[2];
        // Rounding, except where the volume is rounding.
        let off = (on_triangle - found.points.on_segment.point).amax();
        assert!(off <= 1e-6 * extent(&points) + 4.0 * crate::testing::rounding(&points));
        rough += u32::from(off > 32.0 * crate::testing::rounding(&points));
    }
    assert!(rough < through / 100, "{rough} {through}");
    assert!(through > 1_000 && touching > 300, "{through} {touching}");
}

/// A closed surface has no gap: a line from inside to outside goes through it, also where it meets an edge or a corner exactly.
#[test]
fn no_edge_slips_between_two_triangles() {
    // An octahedron, its centre and the lattice points around it: many of the lines go through edges and corners.
    let corners = [
        Vector3::x(),
        Vector3::y(),
        -Vector3::x(),
        -Vector3::y(),
        Vector3::z(),
        -Vector3::z(),
    ];
    let mut random = SplitMix64(5);
    for _ in 0..10_000 {
        let outside = random.lattice() * 4.0;
        let inside = random.vector() * 0.3;
        let inside = if random.below(2) == 0 {
            inside
        } else {
            inside * 0.0
        };
        if outside.abs().sum() <= 1.0 {
            continue;
        }
        let crossings = (0..4)
            .flat_map(|k| [[k, (k + 1) % 4, 4], [(k + 1) % 4, k, 5]])
            .filter_map(|t| edge_through_triangle(&outside, &inside, &t.map(|k| corners[k])))
            .inspect(|crossing| assert!(crossing.from_front))
            .count();
        assert!(crossings >= 1, "{inside:?} {outside:?}");
    }
}

#[test]
fn the_stated_answers() {
    let triangle = [Vector3::zeros(), Vector3::x(), Vector3::y()];
    let through = |p: [f64; 3], q: [f64; 3]| edge_through_triangle(&p.into(), &q.into(), &triangle);
    // From either side, with the side reported (A.18, corrected rule).
    let found = through([0.25, 0.25, 1.0], [0.25, 0.25, -3.0]).expect("a crossing");
    assert!(found.from_front);
    assert_eq!(found.points.on_segment.t, 0.25);
    assert_eq!(found.points.on_triangle.barycentric, [0.5, 0.25, 0.25]);
    let found = through([0.25, 0.25, -3.0], [0.25, 0.25, 1.0]).expect("a crossing");
    assert!(!found.from_front);
    // An end on the face; a corner met.
    assert!(through([0.25, 0.25, 0.0], [0.0, 0.0, 5.0]).is_some());
    assert!(through([1.0, 0.0, 1.0], [1.0, 0.0, -1.0]).is_some());
    // In the plane, right across; parallel to it; beside it; without length, on the face.
    assert!(through([-1.0, 0.25, 0.0], [1.0, 0.25, 0.0]).is_none());
    assert!(through([-1.0, 0.25, 1e-300], [1.0, 0.25, 1e-300]).is_none());
    assert!(through([0.75, 0.75, 1.0], [0.75, 0.75, -1.0]).is_none());
    assert!(through([0.25, 0.25, 0.0], [0.25, 0.25, 0.0]).is_none());
    // No area; not a number.
    let flat = [Vector3::zeros(), Vector3::x(), Vector3::x() * 2.0];
    assert!(edge_through_triangle(&Vector3::z(), &-Vector3::z(), &flat).is_none());
    assert!(through([f64::NAN, 0.0, 1.0], [0.25, 0.25, -1.0]).is_none());
}
