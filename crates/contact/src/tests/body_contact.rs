use super::*;

const BODIES: ContactPair = ContactPair::Bodies {
    body: 0,
    with: 1,
    ends: None,
};

/// Two blocks face to face, a gap g apart: all nodes of both faces have it, and with less reach none.
#[test]
fn faces_that_are_apart_have_the_gap_between_them() {
    let (left, right) = (
        block([-1.0, 0.1, 0.2], [2, 3, 3]),
        block([1.05, 0.0, 0.0], [2, 4, 4]),
    );
    let mut group = Group::new(&[&left, &right], Vec::new(), vec![BODIES]);
    group.reach = 0.04;
    assert!(group.find().is_empty());
    group.reach = 0.06;
    let points = group.find();
    // All 16 nodes of the left face; of the right one those over it.
    assert_eq!(points.iter().filter(|p| p.key.body == 0).count(), 16);
    assert_eq!(points.iter().filter(|p| p.key.body == 1).count(), 9);
    for point in &points {
        assert!((point.gap - 0.05).abs() < 1e-14, "{point:?}");
        let sign = if point.key.body == 0 { -1.0 } else { 1.0 };
        assert!((point.normal - V3::x() * sign).norm() < 1e-13);
    }
}

/// Exactly touching: gaps of 0 within reach, and nothing that touches without.
#[test]
fn bodies_that_touch_exactly_have_gaps_of_zero() {
    let (left, right) = (
        block([-1.0, 0.1, 0.2], [2, 2, 2]),
        block([1.0, 0.0, 0.0], [2, 4, 4]),
    );
    let mut group = Group::new(&[&left, &right], Vec::new(), vec![BODIES]);
    for point in group.find() {
        assert!(point.gap > -1e-14, "{point:?}");
    }
    group.reach = 0.1;
    let points = group.find();
    let nodes = |body: u32| {
        points
            .iter()
            .filter(move |p| p.first == 1 && p.key.body == body)
    };
    assert_eq!((nodes(0).count(), nodes(1).count()), (9, 4));
    for point in &points {
        assert!(point.gap.abs() < 1e-14, "{point:?}");
        assert!((point.normal.x.abs() - 1.0).abs() < 1e-13, "{point:?}");
    }
}

/// Two roofs across one another, their ridges sunk by 0.02, no node inside: one point, of the ridges.
#[test]
fn ridges_across_one_another_touch_edge_to_edge() {
    let turn = |p: &V3, axis: &V3| {
        let axis = nalgebra::Unit::new_normalize(*axis);
        nalgebra::UnitQuaternion::from_axis_angle(&axis, std::f64::consts::FRAC_PI_4) * p
    };
    let mut lower = sized([0.0; 3], [4.0, 1.0, 1.0], [1, 1, 1]);
    let mut upper = sized([0.0; 3], [1.0, 4.0, 1.0], [1, 1, 1]);
    let height = 0.5f64.sqrt();
    for p in &mut lower.positions {
        *p = turn(p, &V3::x()) - V3::z() * height;
    }
    for gap in [-0.02, 0.02] {
        let mut upper = upper.clone();
        for p in &mut upper.positions {
            *p = turn(p, &V3::y()) + V3::new(0.3, -0.4, height + gap);
        }
        for order in [false, true] {
            let meshes = if order {
                [&lower, &upper]
            } else {
                [&upper, &lower]
            };
            let mut group = Group::new(&meshes, Vec::new(), vec![BODIES]);
            group.reach = if gap > 0.0 { 0.1 } else { 0.0 };
            let points = group.find();
            assert_eq!(points.len(), 1, "{gap}: {points:?}");
            let point = &points[0];
            assert!((point.gap - gap).abs() < 1e-14, "{point:?}");
            let sign = if order { -1.0 } else { 1.0 };
            assert!((point.normal - V3::z() * sign).norm() < 1e-14);
            assert!((point.place.x - 0.3).abs() < 1e-14 && (point.place.y).abs() < 0.5);
        }
    }
    upper.positions.clear();
}

/// A plate that jumps over another one in a step: the faces' nodes and the rims' edges are held on the side they had.
#[test]
fn bodies_that_pass_one_another_in_a_step_keep_their_sides() {
    let plate = |z: f64| sized([0.0, 0.0, z], [3.0, 3.0, 0.05], [3, 3, 1]);
    let mut other = plate(0.5);
    for p in &mut other.positions {
        *p += V3::new(0.21, 0.13, 0.0);
    }
    let mut group = Group::new(&[&plate(0.0), &other], Vec::new(), vec![BODIES]);
    for p in &mut group.now[32..] {
        p.z -= 1.0;
    }
    let points = group.find();
    assert!(points.iter().filter(|p| p.first == 1).count() >= 9 + 9);
    assert!(points.iter().any(|p| p.first == 2));
    for point in points {
        let sign = if point.key.body == 0 { -1.0 } else { 1.0 };
        assert!((point.normal - V3::z() * sign).norm() < 1e-4, "{point:?}");
        assert!((point.gap + 0.55).abs() < 1e-4, "{point:?}");
        assert!((point.start_gap - 0.45).abs() < 1e-4);
    }
}

/// What is in a mirror is found mirrored.
#[test]
fn a_mirrored_scene_has_mirrored_points() {
    let mut random = SplitMix64(3);
    let mut upper = block([0.1, 0.2, 1.4], [2, 2, 2]);
    for p in &mut upper.positions {
        *p += random.vector() * 0.2;
    }
    let lower = block([0.0, 0.0, -0.5], [4, 4, 2]);
    let mirrored = |mesh: &TetMesh| {
        let mut mesh = mesh.clone();
        for p in &mut mesh.positions {
            p.x = -p.x;
        }
        for tet in &mut mesh.tets {
            tet.swap(0, 1);
        }
        mesh
    };
    let mut group = Group::new(&[&upper, &lower], Vec::new(), vec![BODIES]);
    let mut mirror = Group::new(
        &[&mirrored(&upper), &mirrored(&lower)],
        Vec::new(),
        vec![BODIES],
    );
    for reach in [0.0, 0.3] {
        (group.reach, mirror.reach) = (reach, reach);
        let (there, here) = (group.find(), mirror.find());
        assert!(there.len() > 4);
        assert_eq!(there.len(), here.len());
        for (a, b) in there.iter().zip(&here) {
            assert_eq!(a.key, b.key);
            assert!((a.gap - b.gap).abs() < 1e-13);
            let normal = V3::new(-b.normal.x, b.normal.y, b.normal.z);
            assert!((a.normal - normal).norm() < 1e-12);
        }
    }
}

/// The order of the elements does not matter, nor does it which body comes first.
#[test]
fn the_order_of_elements_and_bodies_does_not_matter() {
    let mut random = SplitMix64(4);
    let mut upper = block([0.1, 0.2, 1.4], [2, 2, 2]);
    for p in &mut upper.positions {
        *p += random.vector() * 0.2;
    }
    let lower = block([0.0, 0.0, -0.5], [4, 4, 2]);
    let shuffled = |mesh: &TetMesh, random: &mut SplitMix64| {
        let mut mesh = mesh.clone();
        for k in (1..mesh.tets.len()).rev() {
            mesh.tets.swap(k, random.below(k as u64 + 1) as usize);
        }
        mesh
    };
    let mut plain = Group::new(&[&upper, &lower], Vec::new(), vec![BODIES]);
    let (a, b) = (shuffled(&upper, &mut random), shuffled(&lower, &mut random));
    let mut other = Group::new(&[&a, &b], Vec::new(), vec![BODIES]);
    let mut turned = Group::new(&[&lower, &upper], Vec::new(), vec![BODIES]);
    for reach in [0.0, 0.3] {
        (plain.reach, other.reach, turned.reach) = (reach, reach, reach);
        let (there, here, back) = (plain.find(), other.find(), turned.find());
        assert_eq!((there.len(), there.len()), (here.len(), back.len()));
        for (a, b) in there.iter().zip(&here) {
            assert_eq!(a.key, b.key);
            assert!((a.gap - b.gap).abs() < 1e-13 && (a.normal - b.normal).norm() < 1e-12);
        }
        let sum = |points: &[Point], body: u32| -> (usize, f64) {
            let nodes = points.iter().filter(|p| p.first == 1 && p.key.body == body);
            let gaps: Vec<f64> = nodes.map(|p| p.gap).collect();
            (gaps.len(), gaps.iter().sum())
        };
        for (body, other) in [(0, 1), (1, 0)] {
            let (a, b) = (sum(&there, body), sum(&back, other));
            assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-12);
        }
    }
}

/// Two tubes end to end, turned and beside one another, that come 0.02 into one another in a step: whatever touches is pushed back
/// against the direction in which it came, ridges as well as nodes, though for many the side would be nearer. And so in the next step, which starts at the
/// surface to within what a solver leaves.
#[test]
fn ends_that_meet_are_pushed_back_the_way_they_came() {
    use microsim_mesh::{Arc, Layer, Tube};
    let tube = Tube {
        center: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        inner_radius: 0.8,
        layers: vec![Layer {
            thickness: 0.2,
            cells: 1,
            region: 0,
        }],
        length: 4.0,
        around: 9,
        along: 8,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    let left = tube.mesh().expect("a tube");
    for (turn, beside) in [(0.17, 0.3), (0.05, 0.01), (0.3, 0.15), (0.01, 0.19)] {
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&V3::x_axis(), turn);
        let mut right = left.clone();
        for p in &mut right.positions {
            *p = turn * *p + V3::new(4.0, beside, 0.0);
        }
        for before in [0.01, 0.0, -1e-4] {
            let mut group = Group::new(&[&left, &right], Vec::new(), vec![BODIES]);
            let count = left.positions.len();
            for p in &mut group.start[count..] {
                p.x += before;
            }
            for p in &mut group.now[count..] {
                p.x -= 0.02;
            }
            for reach in [0.0, 0.05] {
                group.reach = reach;
                let points = group.find();
                assert!(points.len() > 4);
                for point in points {
                    if point.gap < 0.0 {
                        assert!(point.normal.x.abs() > 0.999, "{before} {beside} {point:?}");
                        assert!((point.gap + 0.02).abs() < 1e-10, "{before} {point:?}");
                    }
                }
            }
        }
    }
}
