use super::*;
use crate::testing::{Points, exact, extent};
use microsim_random::SplitMix64;

/// 10,000 configurations against arithmetic without rounding: what is inside is found inside, what is outside by more than twice the
/// tolerance is not, and the coordinates are right to the bound at `FLAT`.
#[test]
fn points_are_inside_as_whole_numbers_say() {
    let mut random = SplitMix64(6);
    let (mut inside, mut skipped) = (0, 0);
    for _ in 0..10_000 {
        let mut points: [_; 5] = random.points();
        if random.below(2) == 0 {
            // A point of the tetrahedron or of a face of it.
            let mut b = [0; 4].map(|_| random.below(4) as f64);
            b[0] += 1.0;
            let sum: f64 = b.iter().sum();
            let [_, corners @ ..] = points;
            points[0] = (0..4).map(|k| corners[k] * (b[k] / sum)).sum();
        }
        let [p, corners @ ..] = points;
        let ([ep, e @ ..], unit) = exact::points(&points);
        let volume = exact::volume(&e[0], &e[1], &e[2], &e[3]);
        let found = point_in_tetrahedron(&p, &corners);
        let longest = (0..4)
            .flat_map(|i| (0..i).map(move |j| (corners[i] - corners[j]).norm()))
            .fold(0.0, f64::max);
        let cubed = libm::ldexp(longest, -unit).powi(3);
        let fraction = exact::Ratio(volume.clone(), 1.into()).rounded() / cubed;
        // Within rounding of FLAT either answer is right. Four equal points have no ratio.
        if fraction.is_nan() || fraction < FLAT * (1.0 + 1e-9) {
            skipped += 1;
            assert!(
                found.is_none() || fraction > FLAT * (1.0 - 1e-9),
                "{points:?}"
            );
            continue;
        }
        let expected: [f64; 4] = std::array::from_fn(|k| {
            let mut with = e.clone();
            with[k] = ep.clone();
            let part = exact::volume(&with[0], &with[1], &with[2], &with[3]);
            exact::Ratio(part, volume.clone()).rounded()
        });
        let least = expected.iter().copied().fold(f64::INFINITY, f64::min);
        if least >= 0.0 {
            assert!(found.is_some(), "{expected:?} {points:?}");
        }
        if least < -2.0 * INSIDE_TOLERANCE {
            assert!(found.is_none(), "{expected:?} {points:?}");
        }
        if let Some(found) = found {
            inside += 1;
            for (found, expected) in found.iter().zip(expected) {
                let allowed = 6e-15 / fraction;
                assert!(
                    (found - expected).abs() <= allowed,
                    "{found} {expected} {fraction}"
                );
            }
            let sum: f64 = found.iter().sum();
            assert!((sum - 1.0).abs() < 1e-14);
        }
    }
    assert!(inside > 1_000 && skipped > 1_000, "{inside} {skipped}");
}

/// Outward normals as in NUMERICS 1.5: the faces ACB, ABD, BCD, CAD of a positive tetrahedron.
#[test]
fn inside_agrees_with_the_rule_of_outward_normals() {
    let mut random = SplitMix64(7);
    for _ in 0..5_000 {
        let corners: [Vector3<f64>; 4] = std::array::from_fn(|_| random.vector());
        let [a, b, c, d] = corners;
        let volume = (b - a).dot(&(c - a).cross(&(d - a)));
        if volume < 1e-3 {
            continue;
        }
        let p = corners.iter().sum::<Vector3<f64>>() / 4.0 + random.vector() * 0.3;
        let t = [[a, c, b], [a, b, d], [b, c, d], [c, a, d]]
            .map(|[x, y, z]| (y - x).cross(&(z - x)).dot(&(p - x)));
        if t.iter().all(|t| t.abs() > 1e-6) {
            let inside = t.iter().all(|&t| t <= 0.0);
            assert_eq!(point_in_tetrahedron(&p, &corners).is_some(), inside);
        }
    }
}

#[test]
fn flat_inverted_and_moved_tetrahedra() {
    let corners = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
    let centre = Vector3::repeat(0.25);
    assert_eq!(point_in_tetrahedron(&centre, &corners), Some([0.25; 4]));
    let [a, b, c, d] = corners;
    assert_eq!(point_in_tetrahedron(&centre, &[a, c, b, d]), None);
    let flat = [a, b, c, Vector3::new(0.3, 0.3, 0.9 * FLAT)];
    assert_eq!(
        point_in_tetrahedron(&Vector3::new(0.3, 0.3, 0.0), &flat),
        None
    );
    assert_eq!(point_in_tetrahedron(&a, &[a; 4]), None);
    assert_eq!(
        point_in_tetrahedron(&Vector3::repeat(f64::NAN), &corners),
        None
    );
    // A power of two and a move that rounds nothing change no bit.
    let scale = |p: Vector3<f64>| p * 2f64.powi(-40);
    assert_eq!(
        point_in_tetrahedron(&scale(centre), &corners.map(scale)),
        Some([0.25; 4])
    );
    let moved = |p: Vector3<f64>| p + Vector3::repeat(1e9);
    assert_eq!(
        point_in_tetrahedron(&moved(centre), &corners.map(moved)),
        Some([0.25; 4])
    );
    assert!(extent(&corners) == 1.0);
}
