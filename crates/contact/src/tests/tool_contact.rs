use super::*;
use crate::Partner;

const RADIUS: f64 = 0.4;

/// A layer of 6 × 6 cells, its top at z = 0.
fn layer(thickness: f64) -> TetMesh {
    sized(
        [0.0, 0.0, -0.5 * thickness],
        [6.0, 6.0, thickness],
        [6, 6, 1],
    )
}

fn sphere(from: [f64; 3], travel: [f64; 3]) -> CapsuleMotion {
    capsule(from, from, RADIUS, travel)
}

fn of_nodes(points: &[Point], count: u8) -> Vec<&Point> {
    points.iter().filter(|point| point.first == count).collect()
}

/// A sphere that sinks by d into a face at its inside touches it with gap −d, normal down, weights those of the foot.
#[test]
fn a_sphere_touches_the_inside_of_a_face_at_its_foot() {
    let foot = V3::new(0.2, 0.3, 0.0);
    let height = RADIUS - 0.05;
    let mut group = Group::with_tool(
        &layer(1.0),
        vec![sphere([foot.x, foot.y, 0.5], [0.0, 0.0, height - 0.5])],
    );
    let points = group.find();
    let faces = of_nodes(&points, 3);
    // Both ends of the axis are in one place; each touches.
    assert_eq!(faces.len(), 2, "{points:?}");
    for face in faces {
        assert!((face.gap + 0.05).abs() < 1e-15);
        assert!((face.start_gap - 0.1).abs() < 1e-15);
        assert!((face.normal + V3::z()).norm() < 1e-15);
        assert!((face.place - foot).norm() < 1e-15);
        assert_eq!(face.drift, V3::new(0.0, 0.0, height - 0.5));
    }
}

/// A cylinder's axis across an edge and along none: the distance of two lines is known.
#[test]
fn an_edge_is_touched_between_its_nodes() {
    // The edges at y = const run along x; the axis is parallel to y, between the nodes.
    let mut group = Group::with_tool(
        &layer(1.0),
        vec![capsule(
            [0.25, -2.0, 0.5],
            [0.25, 2.0, 0.5],
            RADIUS,
            [0.0, 0.0, -0.2],
        )],
    );
    let points = group.find();
    let edges = of_nodes(&points, 2);
    assert!(edges.len() >= 5);
    for edge in edges {
        if edge.place.y.abs() > 2.0 {
            // Beyond the end of the axis.
            assert!(edge.gap > -0.1 && edge.gap < 0.0);
            continue;
        }
        assert!((edge.gap + 0.1).abs() < 1e-15, "{edge:?}");
        assert!((edge.normal + V3::z()).norm() < 1e-15);
        assert!((edge.place.x - 0.25).abs() < 1e-15);
    }
}

/// With room to spare every node, edge and face of the top has the gap of the closed form, and nothing of the bottom.
#[test]
fn points_that_are_still_apart_are_found_within_reach_on_the_near_side_only() {
    for thickness in [1.0, 0.1, 1e-3] {
        let mut group = Group::with_tool(
            &layer(thickness),
            vec![capsule([-1.0, 0.1, 0.5], [1.3, 0.2, 0.6], RADIUS, [0.0; 3])],
        );
        group.reach = 0.7;
        let points = group.find();
        assert!(of_nodes(&points, 1).len() > 3 && of_nodes(&points, 3).len() == 2);
        for point in &points {
            assert!(point.place.z.abs() < 1e-15, "{thickness}: {point:?}");
            assert!(point.gap >= 0.1 - 1e-15 && point.gap < 0.7);
            assert!(point.normal.z < 0.0);
        }
    }
}

/// A wall of a tenth of the radius, met at up to 20 radii per step: all that the tool swept over is found on the side on which it was.
#[test]
fn a_fast_tool_does_not_get_through_a_thin_wall() {
    for travel in [0.5, 1.0, 2.0, 8.0] {
        for (from, direction) in [(0.6, -1.0), (-0.64, 1.0)] {
            let mut group = Group::with_tool(
                &layer(0.04),
                vec![sphere([0.1, 0.2, from], [0.0, 0.0, travel * direction])],
            );
            let points = group.find();
            assert!(!points.is_empty());
            let surface = if direction < 0.0 { 0.0 } else { -0.04 };
            let deepest = points.iter().map(|p| p.gap).fold(0.0, f64::min);
            // The face below the sphere is in contact all along.
            let expected = RADIUS + travel - (from - surface).abs();
            assert!((deepest + expected).abs() < 1e-12, "{deepest} {expected}");
            for point in &points {
                assert!(point.normal.z * direction > 0.0, "{point:?}");
                assert!((point.place.z - surface).abs() < 1e-12);
                assert!(point.start_gap > 0.0);
            }
        }
    }
}

/// The same when the wall moves and the tool does not: only relative motion counts.
#[test]
fn fast_tissue_is_caught_as_a_fast_tool_is() {
    let still = |travel: f64| {
        let mut group = Group::with_tool(&layer(0.04), vec![sphere([0.1, 0.2, 0.6], [0.0; 3])]);
        for p in &mut group.now {
            p.z += travel;
        }
        group.find()
    };
    for travel in [0.5, 2.0, 8.0] {
        let moving = sphere([0.1, 0.2, 0.6], [0.0, 0.0, -travel]);
        let expected = Group::with_tool(&layer(0.04), vec![moving]).find();
        let found = still(travel);
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(&expected) {
            assert_eq!(a.key, b.key);
            assert!((a.gap - b.gap).abs() < 1e-12 && (a.normal - b.normal).norm() < 1e-6);
        }
    }
}

/// A tool that goes by, or along the surface without coming near, touches nothing.
#[test]
fn a_fast_tool_that_passes_by_touches_nothing() {
    for (from, travel) in [
        ([-3.0, 0.1, RADIUS + 0.01], [6.0, 0.0, 0.0]),
        ([-5.0, 0.0, 0.0], [0.0, 9.0, 0.0]),
        ([0.0, 0.0, 1.0], [1.0, 1.0, 5.0]),
        ([0.0, 0.0, -0.45], [0.0, 0.0, -5.0]),
    ] {
        let mut group = Group::with_tool(&layer(0.04), vec![sphere(from, travel)]);
        assert!(group.find().is_empty(), "{from:?} {travel:?}");
    }
}

/// Once a node has come past the axis, the last normal decides the side, as long as there is one.
#[test]
fn the_side_is_remembered_from_step_to_step() {
    let mut group = Group::with_tool(&layer(1.0), vec![sphere([0.0, 0.0, 0.3], [0.0, 0.0, -0.2])]);
    for step in 0..4 {
        let points = group.find();
        let node = of_nodes(&points, 1)[0];
        let height = 0.1 - 0.2 * f64::from(step);
        assert!((node.gap - (height - RADIUS)).abs() < 1e-14, "{node:?}");
        assert!((node.normal + V3::z()).norm() < 1e-14);
        group.sides.remember(&points);
        let capsules = group.tools[0].as_mut().unwrap();
        capsules[0] = sphere([0.0, 0.0, height], [0.0, 0.0, -0.2]);
    }
}

/// The tool is in a thick layer, nearer to the top; a node on the axis itself; and in a thin layer with both sides in the radius: it
/// leaves through the nearer one.
#[test]
fn a_tool_that_appears_inside_leaves_through_the_nearest_side() {
    for (thickness, height) in [
        (1.0, -0.1),
        (1.0, 0.0),
        (0.3, -0.1),
        (0.3, -0.2),
        (0.1, -0.04),
    ] {
        let mut group = Group::with_tool(
            &layer(thickness),
            vec![sphere([0.0, 0.0, height], [0.0; 3])],
        );
        let points = group.find();
        assert!(!points.is_empty());
        let up = height > -0.5 * thickness;
        for point in &points {
            assert_eq!(point.normal.z < 0.0, up, "{thickness} {height} {point:?}");
        }
        let depth = if up { -height } else { thickness + height };
        let deepest = points.iter().map(|p| p.gap).fold(0.0, f64::min);
        assert!((deepest + depth + RADIUS).abs() < 1e-12, "{deepest}");
    }
}

/// Between two jaws each side has its own normal.
#[test]
fn two_jaws_with_tissue_between_touch_one_side_each() {
    let jaw =
        |z: f64, travel: f64| capsule([-1.0, 0.1, z], [1.0, 0.1, z], RADIUS, [0.0, 0.0, travel]);
    let mut group = Group::with_tool(&layer(0.3), vec![jaw(0.5, -0.2), jaw(-0.8, 0.2)]);
    let points = group.find();
    for point in &points {
        let Partner::Tool { capsule, .. } = point.key.partner else {
            panic!("{point:?}");
        };
        let top = capsule == 0;
        assert_eq!(point.normal.z < 0.0, top);
        assert!((point.place.z - if top { 0.0 } else { -0.3 }).abs() < 1e-14);
    }
    assert_eq!(of_nodes(&points, 1).len() % 2, 0);
}

/// Half of the step's motion: half of the path.
#[test]
fn a_part_of_the_step_moves_the_tool_by_that_part() {
    let mut group = Group::with_tool(&layer(1.0), vec![sphere([0.2, 0.3, 0.5], [0.0, 0.0, -0.4])]);
    group.fraction = 0.5;
    let gaps: Vec<f64> = of_nodes(&group.find(), 3).iter().map(|p| p.gap).collect();
    assert!((gaps[0] + 0.1).abs() < 1e-15);
    group.tools = vec![None];
    assert!(group.find().is_empty());
    let mut broken = sphere([0.2, 0.3, 0.5], [0.0, 0.0, -0.4]);
    broken.end.a.x = f64::NAN;
    group.tools = vec![Some(vec![broken])];
    assert!(group.find().is_empty());
}
