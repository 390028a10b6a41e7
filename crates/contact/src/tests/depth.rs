use super::*;
use crate::{Depth, Detection};

const BODIES: ContactPair = ContactPair::Bodies {
    body: 0,
    with: 1,
    ends: None,
};

/// A block with inner nodes moved at random, `layers` layers deep in a wide one below it.
fn sunk(layers: usize, random: &mut SplitMix64, map: impl Fn(V3) -> V3) -> Group {
    let mut upper = block([0.02, 0.01, 0.0], [3, 3, layers + 1]);
    let bottom = -0.5 * (layers + 1) as f64;
    for p in &mut upper.positions {
        *p += random.vector() * 0.15 - V3::z() * (bottom + layers as f64 - 0.4);
    }
    let mut lower = sized(
        [0.0, 0.0, -10.0 - layers as f64],
        [12.0, 12.0, 20.0 + 2.0 * layers as f64],
        [4, 4, 2],
    );
    for p in upper.positions.iter_mut().chain(&mut lower.positions) {
        *p = map(*p);
    }
    Group::new(&[&upper, &lower], Vec::new(), vec![BODIES])
}

/// NUMERICS 1.4: for a planar surface depth and direction are exact in every layer.
#[test]
fn the_depth_below_a_plane_is_exact_in_every_layer() {
    let mut random = SplitMix64(7);
    for layers in [1, 2, 3, 5, 8] {
        let mut group = sunk(layers, &mut random, |p| p);
        let points = group.find();
        let upper = 16 * (layers + 2);
        let inside = group.now[..upper].iter().filter(|p| p.z < 0.0).count();
        let found: Vec<_> = points.iter().filter(|p| p.key.body == 0).collect();
        assert_eq!(found.len(), inside, "{layers}");
        assert!(inside >= 16 * layers);
        for point in found {
            let depth = -group.now[point.nodes[0] as usize].z;
            assert!((point.gap + depth).abs() < 1e-12, "{layers} {point:?}");
            assert!((point.normal - V3::z()).norm() < 1e-12);
            let other: V3 = (1..4)
                .map(|k| group.now[point.nodes[k] as usize] * -point.weights[k])
                .sum();
            assert!((point.place + V3::z() * depth - other).norm() < 1e-12);
        }
    }
}

/// Turned, moved far away and scaled: the same depths.
#[test]
fn depths_do_not_depend_on_place_and_scale() {
    let before = sunk(3, &mut SplitMix64(8), |p| p).find();
    let turn = nalgebra::UnitQuaternion::new(V3::new(0.4, -0.8, 0.3));
    let scale = 1.0 / 1024.0;
    let map = |p: V3| turn * p * scale + V3::new(1.0, 2.0, -3.0);
    let after = sunk(3, &mut SplitMix64(8), map).find();
    let rest: Vec<_> = before.iter().zip(&after).collect();
    assert_eq!(before.len(), after.len());
    for (a, b) in rest {
        assert_eq!(a.key, b.key);
        // Coordinates of 3 are rounded at 4e-16 there, which is 5e-13 of an edge, and depths are means of differences of them.
        assert!((a.gap * scale - b.gap).abs() < 1e-11 * scale);
        assert!((turn * a.normal - b.normal).norm() < 1e-10);
    }
}

/// A thin plate is left where it was entered, also by nodes that are nearer to the other side.
#[test]
fn out_of_a_thin_plate_leads_the_way_in() {
    let upper = block([0.0, 0.0, 0.9], [2, 2, 2]);
    let plate = sized([0.0, 0.0, -0.05], [8.0, 8.0, 0.12], [8, 8, 1]);
    let mut group = Group::new(&[&upper, &plate], Vec::new(), vec![BODIES]);
    let points = group.find();
    let nodes: Vec<_> = points.iter().filter(|p| p.key.body == 0).collect();
    assert_eq!(nodes.len(), 9);
    for point in nodes {
        assert!((point.gap + 0.11).abs() < 1e-14, "{point:?}");
        assert!((point.normal - V3::z()).norm() < 1e-14);
    }
}

/// The plate of the test above is 0.12 thick, the nodes 0.11 deep: its nearest surface point is on the far side, 0.01 away.
#[test]
fn the_nearest_surface_point_is_not_where_nodes_came_in() {
    let upper = block([0.0, 0.0, 0.9], [2, 2, 2]);
    let plate = sized([0.0, 0.0, -0.05], [8.0, 8.0, 0.12], [8, 8, 1]);
    let mut group = Group::new(&[&upper, &plate], Vec::new(), vec![BODIES]);
    for (depth, gap, out) in [
        (Depth::Consistent, -0.11, V3::z()),
        (Depth::Nearest, -0.01, -V3::z()),
    ] {
        group
            .detector
            .set_detection([0, 1], Detection::Discrete(depth));
        let points = group.find();
        assert!(points.iter().all(|point| point.first == 1), "no edges");
        let nodes: Vec<_> = points.iter().filter(|p| p.key.body == 0).collect();
        assert_eq!(nodes.len(), 9);
        for point in nodes {
            assert!((point.gap - gap).abs() < 1e-14, "{point:?}");
            assert!((point.normal - out).norm() < 1e-14);
        }
    }
}

/// A block that passes through another one in one step is found along the step, and not at its end.
#[test]
fn discrete_detection_does_not_see_what_passes_through() {
    let pair = [block([0.0, 0.0, 2.0], [1; 3]), block([0.0; 3], [1; 3])];
    let mut group = Group::new(&[&pair[0], &pair[1]], Vec::new(), vec![BODIES]);
    for p in &mut group.now[..8] {
        p.z -= 4.0;
    }
    assert!(!group.find().is_empty());
    let discrete = Detection::Discrete(Depth::Consistent);
    group.detector.set_detection([0, 1], discrete);
    assert!(group.find().is_empty());
}

/// No edge of the inner body crosses the outer one's surface: each node goes to the nearest place of it.
#[test]
fn a_body_inside_another_goes_to_the_nearest_side() {
    let inner = block([2.0, 0.0, 0.0], [1, 1, 1]);
    let outer = block([0.0; 3], [6, 6, 6]);
    let mut group = Group::new(&[&inner, &outer], Vec::new(), vec![BODIES]);
    let points = group.find();
    let nodes: Vec<_> = points.iter().filter(|p| p.key.body == 0).collect();
    assert_eq!(nodes.len(), 8);
    for point in nodes {
        let p = group.now[point.nodes[0] as usize];
        assert!((point.gap + (3.0 - p.x)).abs() < 1e-14, "{point:?}");
        assert!((point.normal - V3::x()).norm() < 1e-14);
    }
}

/// 100 layers on one another in one body, each sunk into the next by 0.01.
#[test]
fn a_hundred_layers_of_one_body_are_kept_apart() {
    let mut mesh = sized([0.0; 3], [2.0, 2.0, 0.5], [2, 2, 1]);
    let single = mesh.clone();
    for layer in 1..100 {
        let mut next = single.clone();
        for p in &mut next.positions {
            p.z += 0.49 * f64::from(layer);
            p.x += 0.1 * f64::from(layer % 3);
            p.y += 0.1 * f64::from(layer % 5);
        }
        mesh.append(&next, 0);
    }
    let mut group = Group::new(&[&mesh], Vec::new(), vec![ContactPair::Itself { body: 0 }]);
    let points = group.find();
    let nodes: Vec<_> = points.iter().filter(|p| p.first == 1).collect();
    // Shifted against one another, of two layers each has at least four nodes in the other.
    assert!(nodes.len() >= 99 * 8);
    for point in nodes {
        // An entry through the layer's side, 0.1 away, has a hundredth of the weight of that through its face, and ten times its depth.
        assert!((point.gap + 0.01).abs() < 0.2 * 0.01, "{point:?}");
        assert!(point.normal.z.abs() > 0.999, "{point:?}");
        let layer = |k: usize| point.nodes[k] as usize / 18;
        assert_eq!(layer(0).abs_diff(layer(1)), 1);
    }
    // A body at rest does not touch itself.
    let mut alone = Group::new(
        &[&block([0.0; 3], [3, 3, 3])],
        Vec::new(),
        vec![ContactPair::Itself { body: 0 }],
    );
    assert!(alone.find().is_empty());
    alone.reach = 0.9;
    assert!(alone.find().is_empty());
}

/// Two tubes end to end, one sunk into the other by a third of a wall: with the rule, the nodes of the rings go straight back before the
/// planes, also those that are in the lumen.
#[test]
fn ends_of_vessels_are_brought_before_the_other_end() {
    use crate::VesselEnd;
    use microsim_mesh::{Arc, Layer, Tube, TubeSide};
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
    let count = left.positions.len() as u32;
    let mut right = left.clone();
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&V3::x_axis(), 0.2);
    for p in &mut right.positions {
        *p = turn * *p + V3::new(4.0 - 0.06, 0.15, 0.0);
    }
    let end = |mesh: &TetMesh, side: TubeSide, offset: u32| VesselEnd {
        triangles: tube
            .side(mesh, side)
            .triangles
            .iter()
            .map(|triangle| triangle.map(|node| node + offset))
            .collect(),
    };
    let ends = [
        end(&left, TubeSide::End, 0),
        end(&left, TubeSide::Start, count),
    ];
    let with_ends = ContactPair::Bodies {
        body: 0,
        with: 1,
        ends: Some(ends),
    };
    let ring = |group: &Group, point: &Point| {
        let p = group.now[point.nodes[0] as usize];
        (p.x - 2.0).abs() < 0.1
    };
    let mut plain = Group::new(&[&left, &right], Vec::new(), vec![BODIES]);
    let mut group = Group::new(&[&left, &right], Vec::new(), vec![with_ends]);
    let points = group.find();
    let nodes: Vec<_> = points.iter().filter(|p| p.first == 1).collect();
    assert!(nodes.len() > plain.find().iter().filter(|p| p.first == 1).count());
    for point in &nodes {
        assert!(ring(&group, point), "{point:?}");
        let sign = if point.key.body == 0 { -1.0 } else { 1.0 };
        assert!((point.normal - V3::x() * sign).norm() < 1e-13, "{point:?}");
        assert!((point.gap + 0.06).abs() < 1e-13, "{point:?}");
    }
}
