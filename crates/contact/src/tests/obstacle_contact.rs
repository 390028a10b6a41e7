use super::*;
use crate::ObstacleShape;
use microsim_geometry::Pose;
use nalgebra::UnitQuaternion;

fn thing(shape: ObstacleShape, position: [f64; 3]) -> ObstaclePart {
    ObstaclePart {
        shape,
        pose: Pose {
            position: position.into(),
            ..Pose::identity()
        },
    }
}

fn cuboid(half_size: [f64; 3], rounding: f64) -> ObstacleShape {
    ObstacleShape::Cuboid {
        half_size,
        rounding,
    }
}

const PAIR: ContactPair = ContactPair::Obstacle { body: 0, part: 0 };

/// Distances of known points, and everywhere the normal is the gradient: the distance grows by the step along it.
#[test]
fn signed_distances_are_those_of_the_closed_forms() {
    let shapes = [
        ObstacleShape::HalfSpace,
        cuboid([1.0, 2.0, 3.0], 0.0),
        cuboid([1.0, 2.0, 3.0], 0.25),
        ObstacleShape::Cylinder {
            radius: 1.0,
            half_length: 2.0,
        },
    ];
    for (shape, p, expected) in [
        (0, [3.0, 1.0, -2.0], -2.0),
        (1, [1.0, 2.0, 5.0], 2.0),
        (1, [4.0, 6.0, 0.0], 5.0),
        (1, [0.5, 0.0, 0.0], -0.5),
        (2, [0.75 + 3.0, 1.75 + 4.0, 0.0], 4.75),
        (2, [0.9, 0.0, 0.0], -0.1),
        (3, [0.0, 3.0, 0.0], 2.0),
        (3, [4.0, 0.0, 6.0], 5.0),
        (3, [0.0, 0.0, 1.9], -0.1),
    ] {
        let (distance, _) = thing(shapes[shape], [0.0; 3]).distance(&p.into());
        assert!(
            (distance - expected).abs() < 1e-15,
            "{shape} {p:?} {distance}"
        );
    }
    let mut random = SplitMix64(1);
    for shape in shapes {
        let mut thing = thing(shape, [0.3, -0.2, 0.1]);
        thing.pose.orientation = UnitQuaternion::new(V3::new(0.3, 0.5, -0.4));
        for _ in 0..300 {
            let p = random.vector() * 4.0;
            let (distance, normal) = thing.distance(&p);
            let step = 1e-6;
            let (further, _) = thing.distance(&(p + normal * step));
            // Along a ray out of a smooth or round surface the distance is linear, inside up to the middle.
            assert!((further - distance - step).abs() < 1e-12, "{shape:?} {p:?}");
            // The surface point is on the surface.
            let (zero, _) = thing.distance(&(p - normal * distance));
            assert!(zero.abs() < 1e-12);
            // No point of the obstacle is further along a direction than its support.
            let direction = random.vector().normalize();
            if distance <= 0.0 && shape != ObstacleShape::HalfSpace {
                assert!(p.dot(&direction) <= thing.support(&direction) + 1e-12);
            }
        }
    }
}

/// A block that has sunk into a plane by d: its lower nodes, and they alone, have the gap −d.
#[test]
fn a_block_on_a_plane_touches_with_its_lower_nodes() {
    let mesh = block([0.0, 0.0, 1.0], [3, 3, 2]);
    let plane = thing(ObstacleShape::HalfSpace, [0.0, 0.0, 0.01]);
    let points = Group::new(&[&mesh], vec![plane], vec![PAIR]).find();
    assert_eq!(points.len(), 16);
    for point in points {
        assert!((point.gap + 0.01).abs() < 1e-15 && point.normal == V3::z());
        assert_eq!((point.start_gap, point.first), (point.gap, 1));
    }
}

/// A post with edges of half an edge length stands below the inside of a large triangle: no node is in it.
#[test]
fn a_corner_of_a_box_does_not_sink_into_a_face() {
    let mesh = sized([0.0, 0.0, 0.5], [4.0, 4.0, 1.0], [1, 1, 1]);
    for rounding in [0.0, 0.05] {
        let post = thing(cuboid([0.3, 0.3, 1.0], rounding), [1.0, -0.9, -0.98]);
        let points = Group::new(&[&mesh], vec![post], vec![PAIR]).find();
        assert_eq!(points.len(), 4, "{points:?}");
        for point in points {
            assert!((point.gap + 0.02).abs() < 1e-15);
            assert!((point.normal - V3::z()).norm() < 1e-15);
        }
    }
}

/// Two sharp edges across one another, far from nodes and corners: a roof above a box's edge.
#[test]
fn an_edge_of_a_box_and_an_edge_of_the_surface_meet_between_their_ends() {
    let mut mesh = sized([0.0, 0.0, 0.0], [4.0, 1.0, 1.0], [1, 1, 1]);
    // The block stands on its edge along x, at z = 0.
    let turn = UnitQuaternion::from_axis_angle(&V3::x_axis(), std::f64::consts::FRAC_PI_4);
    for p in &mut mesh.positions {
        *p = turn * *p + V3::z() * 0.5f64.sqrt();
    }
    // The box lies along y with an edge up, 0.01 above the other one.
    let half = 0.5;
    let mut bar = thing(
        cuboid([half, 3.0, half], 0.0),
        [0.2, 0.1, 0.01 - half * 2f64.sqrt()],
    );
    bar.pose.orientation =
        UnitQuaternion::from_axis_angle(&V3::y_axis(), std::f64::consts::FRAC_PI_4);
    let points = Group::new(&[&mesh], vec![bar], vec![PAIR]).find();
    assert_eq!(points.len(), 1, "{points:?}");
    assert!((points[0].gap + 0.01).abs() < 1e-14);
    assert!((points[0].normal - V3::z()).norm() < 1e-14);
    assert!((points[0].place - V3::new(0.2, 0.0, 0.0)).norm() < 1e-14);
    assert_eq!(points[0].first, 2);
}

/// A plate of a tenth of an edge, met at up to 50 of its thicknesses per step: the gap is to the side that was met.
#[test]
fn fast_tissue_does_not_get_through_a_thin_plate() {
    let mesh = block([0.0, 0.0, 1.0], [2, 2, 1]);
    let plate = thing(cuboid([3.0, 3.0, 0.05], 0.0), [0.0, 0.0, 0.3]);
    for depth in [0.17, 0.22, 0.3, 5.0] {
        let mut group = Group::new(&[&mesh], vec![plate], vec![PAIR]);
        for p in &mut group.now {
            p.z -= depth;
        }
        let points = group.find();
        let lowest: Vec<_> = points.iter().filter(|p| p.place.z < 0.6 - depth).collect();
        assert_eq!(lowest.len(), 9, "{depth}");
        for point in lowest {
            assert!((point.normal - V3::z()).norm() < 1e-14);
            assert!(
                (point.gap - (0.15 - depth)).abs() < 1e-14,
                "{depth} {point:?}"
            );
            assert!((point.start_gap - 0.15).abs() < 1e-14);
        }
    }
    // Inside from before: the side of the last normal, though the other one is nearer.
    let mut group = Group::new(&[&mesh], vec![plate], vec![PAIR]);
    for p in &mut group.now {
        p.z -= 0.22;
    }
    let points = group.find();
    group.sides.remember(&points);
    group.start = group.now.clone();
    assert!(
        group
            .find()
            .iter()
            .all(|p| (p.gap + 0.07).abs() < 1e-14 && p.normal.z > 0.9)
    );
    group.sides = Sides::new();
    assert!(
        group
            .find()
            .iter()
            .all(|p| (p.gap + 0.03).abs() < 1e-14 && p.normal.z < -0.9)
    );
}

/// A bar across a cylinder between its nodes.
#[test]
fn an_edge_lies_on_the_side_of_a_cylinder() {
    let mesh = sized([0.0, 0.0, 0.5], [4.0, 1.0, 1.0], [1, 1, 1]);
    let mut roller = thing(
        ObstacleShape::Cylinder {
            radius: 0.5,
            half_length: 2.0,
        },
        [0.3, 0.0, -0.48],
    );
    roller.pose.orientation =
        UnitQuaternion::from_axis_angle(&V3::x_axis(), std::f64::consts::FRAC_PI_2);
    let points = Group::new(&[&mesh], vec![roller], vec![PAIR]).find();
    assert!(points.len() >= 2);
    for point in points {
        assert_eq!(point.first, 2);
        assert!((point.gap + 0.02).abs() < 1e-14 && (point.normal - V3::z()).norm() < 1e-14);
    }
}
