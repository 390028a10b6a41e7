use super::*;
use microsim_geometry::edge_through_triangle;
use microsim_random::SplitMix64;

type V3 = Vector3<f64>;

fn crossing(sheet: &Sheet, u: &V3, v: &V3) -> Option<Crossing> {
    sheet.crossing(u, v, &sheet.triangle_bounds())
}

/// Against the exact test of geometry, for random edges, which touch nothing: one hit or three are a crossing, two are none.
#[test]
fn random_edges_are_crossed_as_geometry_says() {
    let mut random = SplitMix64(5);
    let (mut hits, mut doubles) = (0, 0);
    for _ in 0..20_000 {
        let corners: [V3; 4] = std::array::from_fn(|_| random.vector());
        let sheet = Sheet::quad([corners[0], corners[1]], [corners[2], corners[3]]);
        let (u, v) = (random.vector(), random.vector());
        let found = crossing(&sheet, &u, &v);
        let expected: Vec<_> = (0..2)
            .filter_map(|t| edge_through_triangle(&u, &v, &sheet.corners(t)))
            .collect();
        assert_eq!(found.is_some(), expected.len() == 1);
        doubles += usize::from(expected.len() == 2);
        if let (Some(found), [expected]) = (found, &expected[..]) {
            hits += 1;
            assert!((found.fraction - expected.points.on_segment.t).abs() < 1e-9);
            // Counter-clockwise from its first end: that is on the positive side.
            assert_eq!(found.positive, !expected.from_front);
            assert_eq!(found.positive, (v - u).dot(&found.normal) > 0.0);
            let back = crossing(&sheet, &v, &u).unwrap();
            assert!(
                back.positive != found.positive
                    && (back.fraction + found.fraction - 1.0).abs() < 1e-9
            );
        }
    }
    assert!(hits > 500 && doubles > 50, "{hits} {doubles}");
}

/// A chain of edges from below to above crosses a sheet over all of it once on balance, though every point lies on a lattice
/// with the sheet's points, its edges and diagonals: the displacement decides.
#[test]
fn every_way_through_a_sheet_crosses_it_an_odd_number_of_times() {
    let mut random = SplitMix64(6);
    let lattice = |random: &mut SplitMix64| V3::from_fn(|_, _| random.below(5) as f64 - 2.0);
    for _ in 0..2000 {
        let heights: Vec<f64> = (0..49).map(|_| random.below(3) as f64 - 1.0).collect();
        let mut heights = heights.into_iter();
        let sheet = Sheet::grid(6, 6, |a, b| {
            let height = heights.next().unwrap_or_default();
            V3::new(12.0 * a - 6.0, 12.0 * b - 6.0, height)
        });
        let sheet = sheet.displaced(1.0);
        let mut path = vec![V3::new(0.0, 1.0, -9.0)];
        path.extend((0..6).map(|_| lattice(&mut random)));
        path.push(V3::new(1.0, 0.0, 9.0));
        // An edge is always asked from the same end, here the one with the smaller coordinates.
        let crossed = |pair: &[V3]| {
            let key = |p: &V3| (p.x, p.y, p.z);
            let (u, v) = if key(&pair[0]) < key(&pair[1]) {
                (0, 1)
            } else {
                (1, 0)
            };
            crossing(&sheet, &pair[u], &pair[v]).is_some()
        };
        let count = path.windows(2).filter(|pair| crossed(pair)).count();
        assert_eq!(count % 2, 1);
    }
}

#[test]
fn what_has_no_area_crosses_nothing() {
    let p = V3::new(0.1, 0.2, 0.3);
    for sheet in [
        Sheet::quad([p, p], [p, p]),
        Sheet::quad([-V3::x(), V3::x()], [-V3::x(), V3::x()]),
        Sheet::default(),
    ] {
        assert_eq!(crossing(&sheet, &-V3::z(), &V3::z()), None);
    }
    // In the plane of the sheet, and beside it.
    let sheet = Sheet::quad(
        [-V3::x() - V3::y(), V3::x() - V3::y()],
        [V3::y() - V3::x(), V3::x() + V3::y()],
    );
    assert_eq!(crossing(&sheet, &(V3::x() * -2.0), &(V3::x() * 2.0)), None);
    assert_eq!(
        crossing(&sheet, &V3::new(2.0, 0.0, -1.0), &V3::new(2.0, 0.0, 1.0)),
        None
    );
    assert!(crossing(&sheet, &-V3::z(), &V3::z()).is_some());
}

#[test]
fn a_quad_is_divided_along_its_shorter_diagonal() {
    let points = [
        V3::zeros(),
        V3::x(),
        V3::new(0.0, 1.0, 0.0),
        V3::new(3.0, 1.0, 0.0),
    ];
    // From 0 to (3, 1) it is √10, from (1, 0) to (0, 1) √2.
    let sheet = Sheet::quad([points[0], points[1]], [points[2], points[3]]);
    assert_eq!(sheet.triangles, [[0, 1, 3], [1, 2, 3]]);
    let area = |t: usize| {
        let [a, b, c] = sheet.corners(t);
        (b - a).cross(&(c - a)).z / 2.0
    };
    // The trapezoid with sides 1 and 3 and height 1, all of it facing one side.
    assert!(area(0) > 0.0 && area(1) > 0.0 && (area(0) + area(1) - 2.0).abs() < 1e-15);
}
