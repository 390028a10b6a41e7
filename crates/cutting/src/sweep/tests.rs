use super::*;
use crate::sheet::Sheet;
use microsim_random::SplitMix64;

type V3 = Vector3<f64>;

fn at_rest(u: V3, v: V3) -> Sweep {
    Sweep {
        before: [u, v],
        now: [u, v],
    }
}

/// A blade that is only shifted sweeps a parallelogram: the same crossings as of the sheet, by an independent method.
#[test]
fn a_shifted_blade_crosses_as_its_parallelogram_does() {
    let mut random = SplitMix64(21);
    let mut hits = 0;
    for _ in 0..20_000 {
        let (p, q, shift) = (random.vector(), random.vector(), random.vector());
        let sweep = Sweep {
            before: [p, q],
            now: [p + shift, q + shift],
        };
        let sheet = Sheet::quad(sweep.before, sweep.now);
        let (u, v) = (random.vector(), random.vector());
        let found = sweep.crossing(&at_rest(u, v));
        let expected = sheet.crossing(&u, &v, &sheet.triangle_bounds());
        assert_eq!(found.is_some(), expected.is_some());
        let (Some(found), Some(expected)) = (found, expected) else {
            continue;
        };
        hits += 1;
        assert!((found.fraction - expected.fraction).abs() < 1e-8);
        assert_eq!(found.positive, expected.positive);
        assert!(found.normal.dot(&expected.normal) > 0.0);
        // In the frame of the blade the tissue moves, and nothing else changes.
        let edge = Sweep {
            before: [u, v],
            now: [u - shift, v - shift],
        };
        let other = at_rest(p, q).crossing(&edge).unwrap();
        assert!((other.fraction - found.fraction).abs() < 1e-8 && other.positive == found.positive);
    }
    assert!(hits > 500, "{hits}");
}

/// Blades that turn and edges that turn, in one step or in two with the same end: what crosses in all crosses in one of them, and at
/// the same place.
#[test]
fn two_half_steps_cross_what_one_does() {
    let mut random = SplitMix64(22);
    let (mut hits, mut others) = (0, 0);
    for _ in 0..20_000 {
        let mut sweep = || Sweep {
            before: [random.vector(), random.vector()],
            now: [random.vector(), random.vector()],
        };
        let (blade, edge) = (sweep(), sweep());
        let time = 0.1 + 0.8 * random.number().abs();
        let parts = |s: &Sweep| {
            let middle = s.at(time);
            [
                Sweep {
                    before: s.before,
                    now: middle,
                },
                Sweep {
                    before: middle,
                    now: s.now,
                },
            ]
        };
        let (blades, edges) = (parts(&blade), parts(&edge));
        let halves: Vec<_> = (0..2)
            .filter_map(|k| blades[k].crossing(&edges[k]))
            .collect();
        let whole = blade.crossing(&edge);
        assert_eq!(whole.is_some(), halves.len() == 1);
        if let (Some(whole), [half]) = (whole, &halves[..]) {
            hits += 1;
            // It may cross three times in all, and twice of these in one of the halves, which so leaves another one.
            let same = (whole.fraction - half.fraction).abs() < 1e-6;
            others += usize::from(!same);
            assert!(!same || whole.positive == half.positive);
        }
    }
    assert!(hits > 500 && others < hits / 100, "{hits} {others}");
}

/// The place of a crossing is the point that blade and edge have in common at some time: looked for at 2000 times.
#[test]
fn blade_and_edge_meet_where_it_is_said() {
    let mut random = SplitMix64(23);
    for _ in 0..300 {
        let mut sweep = || Sweep {
            before: [random.vector(), random.vector()],
            now: [random.vector(), random.vector()],
        };
        let (blade, edge) = (sweep(), sweep());
        let Some(found) = blade.crossing(&edge) else {
            continue;
        };
        let nearest = (0..=2000).map(|k| {
            let time = k as f64 / 2000.0;
            let (b, e) = (blade.at(time), edge.at(time));
            let point = e[0] + (e[1] - e[0]) * found.fraction;
            (microsim_geometry::closest_on_segment(&point, &b[0], &b[1]).point - point).norm()
        });
        // Ends move by up to 4√3 in a step, 0.004 between two looks, and the place with them.
        assert!(nearest.fold(f64::INFINITY, f64::min) < 0.02);
    }
}

#[test]
fn nothing_that_rests_or_is_no_number_crosses() {
    let blade = at_rest(-V3::x(), V3::x());
    let edge = at_rest(-V3::z(), V3::z());
    assert_eq!(blade.crossing(&edge), None);
    let lost = Sweep {
        before: [V3::repeat(f64::NAN), V3::x()],
        now: [V3::x(), V3::y()],
    };
    assert_eq!(lost.crossing(&edge), None);
    assert_eq!(blade.crossing(&lost), None);
    let point = Sweep {
        before: [V3::y(), V3::y()],
        now: [-V3::y(), -V3::y()],
    };
    assert_eq!(point.crossing(&edge), None);
}
