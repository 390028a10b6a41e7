//! Exactness of landing, distribution of forces, fall-backs.

use super::*;
use microsim_geometry::Capsule;
use microsim_mesh::{Block, CellSplit, TetMesh};

/// Edge length of the cells [m].
const CELL: f64 = 1e-3;

struct Scene {
    mesh: TetMesh,
    surface: Surface,
    inverse_masses: Vec<f64>,
    mean_edge_length: f64,
}

impl Scene {
    /// 6 × 6 × 1 cells; the top is at z = 0.
    fn layer() -> Self {
        let size = [6.0 * CELL, 6.0 * CELL, CELL];
        let mesh = Block {
            center: [0.0, 0.0, -0.5 * CELL],
            size,
            cells: [6, 6, 1],
            split: CellSplit::Kuhn,
        }
        .mesh()
        .unwrap();
        let inverse_masses = mesh.lumped_masses(1060.0).iter().map(|m| 1.0 / m).collect();
        Self {
            surface: mesh.surface(),
            mean_edge_length: mesh.mean_edge_length(),
            inverse_masses,
            mesh,
        }
    }

    /// One triangle with unequal masses.
    fn triangle() -> Self {
        let positions = vec![Vector3::zeros(), Vector3::x() * CELL, Vector3::y() * CELL];
        let mesh = TetMesh::new(positions, vec![], vec![]);
        let surface = Surface::new(vec![[0, 1, 2]]);
        Self {
            mesh,
            surface,
            inverse_masses: vec![1e6, 3e6, 2e6],
            mean_edge_length: CELL,
        }
    }

    fn body(&self) -> BodySurface<'_> {
        BodySurface {
            surface: &self.surface,
            start: &self.mesh.positions,
            inverse_masses: &self.inverse_masses,
            mean_edge_length: self.mean_edge_length,
        }
    }

    fn respond(
        &self,
        motion: CapsuleMotion,
        memory: &mut ContactMemory,
    ) -> (Vec<Vector3<f64>>, Response) {
        let mut positions = self.mesh.positions.clone();
        let response = respond(&self.body(), &[motion], memory, &mut positions);
        (positions, response)
    }
}

/// A capsule that came from far above: no old overlap.
fn arriving(a: [f64; 3], b: [f64; 3], radius: f64) -> CapsuleMotion {
    let end = Capsule {
        a: Vector3::from(a) * CELL,
        b: Vector3::from(b) * CELL,
        radius: radius * CELL,
    };
    let lift = Vector3::z() * (20.0 * CELL);
    CapsuleMotion {
        start: Capsule {
            a: end.a + lift,
            b: end.b + lift,
            ..end
        },
        end,
    }
}

#[test]
fn after_the_response_no_node_and_hardly_a_triangle_is_inside() {
    let scene = Scene::layer();
    // Lying, upright and tilted tools, thinner and thicker than the cells, pressed in by up to half a radius.
    for (a, b) in [
        ([-2.3, 0.2, 0.0], [2.4, 0.4, 0.0]),
        ([0.3, 0.4, 0.0], [0.3, 0.4, 8.0]),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 8.0]),
        ([-1.2, 0.1, 0.0], [3.0, 0.5, 5.0]),
    ] {
        for radius in [0.25, 0.7, 1.5] {
            for depth in [0.02, 0.2, 0.5] {
                let rise = radius * (1.0 - depth);
                let motion = arriving([a[0], a[1], a[2] + rise], [b[0], b[1], b[2] + rise], radius);
                let (positions, response) = scene.respond(motion, &mut ContactMemory::new());
                assert!(!response.nodes.is_empty());
                for &node in &scene.surface.nodes {
                    let distance = motion.end.signed_distance(&positions[node as usize]);
                    assert!(
                        distance > -1e-12 * motion.end.radius,
                        "{a:?} {radius} {depth}: node {distance}"
                    );
                }
                // Averaging over triangles converges, but not in a fixed number of passes.
                assert!(
                    response.max_depth < 0.05 * depth * motion.end.radius,
                    "{a:?} {radius} {depth}: {} of the depth remain",
                    response.max_depth / (depth * motion.end.radius)
                );
                assert!(response.nodes.iter().all(|n| n.overlap == Vector3::zeros()));
            }
        }
    }
}

#[test]
fn a_touch_inside_a_triangle_acts_at_the_touching_point_along_the_normal() {
    let scene = Scene::triangle();
    let (depth, radius) = (0.01 * CELL, 0.5);
    let motion = arriving([0.2, 0.3, 0.49], [0.2, 0.3, 3.0], radius);
    let (positions, response) = scene.respond(motion, &mut ContactMemory::new());
    assert_eq!(response.nodes.len(), 3);
    // Forces m·Δp: their sum is along −z, their moment about the touching point vanishes.
    let touch = Vector3::new(0.2, 0.3, 0.0) * CELL;
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for n in &response.nodes {
        let f = n.correction / scene.inverse_masses[n.node as usize];
        force += f;
        moment += (scene.mesh.positions[n.node as usize] - touch).cross(&f);
    }
    assert!(force.z < 0.0 && force.xy().norm() < 1e-6 * force.norm());
    // The triangle tilts as it gives way, by depth/CELL = 1 %: the following passes touch beside the first point by the
    // radius times that angle, for a correction that is a few per cent of the first one.
    assert!(
        moment.norm() < 0.01 * radius * CELL * force.norm(),
        "{}",
        moment.norm() / (CELL * force.norm())
    );
    // The touching point itself came down by the depth.
    let z = 0.5 * positions[0].z + 0.2 * positions[1].z + 0.3 * positions[2].z;
    assert!((z + depth).abs() < 0.02 * depth, "{z}");
}

#[test]
fn shares_follow_barycentric_coordinates_and_inverse_masses() {
    // b_i w_i / Σ w b² for w = (1, 2, 4), b = (½, ¼, ¼): Σ = ¼ + 2/16 + 4/16 = 5/8.
    let shares = distribute([1.0, 2.0, 4.0], [0.5, 0.25, 0.25]);
    assert_eq!(shares, [0.8, 0.8, 1.6]);
    assert_eq!(distribute([0.0; 3], [0.2, 0.3, 0.5]), [0.0; 3]);
    // Nearly at a clamped node: without scaling the free node would move by 1/b = 20 times the depth.
    assert!((distribute([0.0, 0.0, 2.0], [0.5, 0.45, 0.05])[2] - 0.15).abs() < 1e-15);
}

#[test]
fn an_old_overlap_is_undone_in_small_steps_and_marked_as_such() {
    let scene = Scene::layer();
    // The tool appears in place, 0.9 cells deep over a node, and does not move.
    let mut motion = arriving([0.0, 0.0, 0.1], [0.0, 0.0, 8.0], 1.0);
    motion.start = motion.end;
    let (_, response) = scene.respond(motion, &mut ContactMemory::new());
    let limit = 0.2 * scene.mean_edge_length;
    for n in &response.nodes {
        assert!(
            n.correction.norm() <= 3.0 * limit,
            "{}",
            n.correction.norm()
        );
        assert!(
            (n.correction - n.overlap).norm() < 1e-12 * CELL,
            "all of it is old"
        );
    }
    assert!(
        response.max_depth > 0.5 * CELL,
        "the rest waits for the next step"
    );

    // A moving tool takes the surface along by its whole way, however far; only what was inside before is limited.
    let node = scene
        .mesh
        .positions
        .iter()
        .position(|p| p.norm() < 1e-12 * CELL)
        .unwrap();
    for (way, old) in [(0.5, 0.4), (0.8, 0.1), (0.9, 0.0), (1.5, 0.0)] {
        let lift = Vector3::z() * (way * CELL);
        motion.start = Capsule {
            a: motion.end.a + lift,
            b: motion.end.b + lift,
            ..motion.end
        };
        let position = &scene.mesh.positions[node];
        let touch = touch_node(
            &scene.body(),
            position,
            node as u32,
            0,
            &motion,
            &ContactMemory::new(),
        )
        .unwrap();
        let undone = (old * CELL).min(limit);
        let expected = (0.9 - old) * CELL + undone;
        assert!(
            (touch.distance - expected).abs() < 1e-12 * CELL,
            "{way}: {} {expected}",
            touch.distance
        );
        assert!((touch.old_share - undone / expected).abs() < 1e-9);
    }
}

#[test]
fn a_point_on_or_across_the_axis_takes_the_normal_of_the_step_before() {
    let scene = Scene::layer();
    let node = scene
        .mesh
        .positions
        .iter()
        .position(|p| p.norm() < 1e-12 * CELL)
        .unwrap() as u32;
    // A lying tool whose axis goes through the node, then a little below it.
    for height in [0.0, -0.1] {
        let motion = arriving([-1.5, 0.0, height], [1.5, 0.0, height], 0.5);
        let mut memory = ContactMemory::new();
        for &other in &scene.surface.nodes {
            memory.remember(0, other, -Vector3::z());
        }
        let (positions, _) = scene.respond(motion, &mut memory);
        let z = positions[node as usize].z / CELL;
        // At the underside, or below it where the triangles around had to go further; never back to the top.
        assert!(z < height - 0.5 + 1e-9 && z > height - 0.8, "{height}: {z}");
        assert!(memory.normal(0, node).unwrap().z < -0.999);
    }
    // Without a memory the surface's own outward normal decides.
    let motion = arriving([-1.5, 0.0, 0.0], [1.5, 0.0, 0.0], 0.5);
    let (positions, _) = scene.respond(motion, &mut ContactMemory::new());
    assert!(
        positions[node as usize].z < -0.49 * CELL,
        "{}",
        positions[node as usize].z
    );
}

#[test]
fn the_far_side_of_a_layer_is_not_touched_through_it() {
    let scene = Scene::layer();
    // The axis is above the top by 0.1 cells; the bottom is 1.1 cells away, inside the radius.
    let motion = arriving([-1.0, 0.0, 0.1], [1.0, 0.0, 0.1], 1.2);
    let capsules = [motion];
    let candidates = Candidates::find(&scene.body(), &capsules, &scene.mesh.positions);
    let memory = ContactMemory::new();
    let mut bottoms = 0;
    for &index in &candidates.triangles {
        let nodes = &scene.surface.triangles[index as usize];
        let bottom = nodes
            .iter()
            .all(|&n| scene.mesh.positions[n as usize].z < -0.9 * CELL);
        let touched = touch_triangle(
            &scene.body(),
            &scene.mesh.positions,
            nodes,
            0,
            &motion,
            &memory,
        );
        assert!(!(bottom && touched.is_some()));
        bottoms += usize::from(bottom);
    }
    assert!(bottoms > 0, "the case was met");
}

#[test]
fn clamped_nodes_stay_and_a_tool_that_is_away_is_forgotten() {
    let mut scene = Scene::layer();
    let clamped: Vec<usize> = (0..scene.mesh.positions.len())
        .filter(|i| i % 3 == 0)
        .collect();
    for &node in &clamped {
        scene.inverse_masses[node] = 0.0;
    }
    let mut memory = ContactMemory::new();
    let (positions, response) = scene.respond(
        arriving([-2.0, 0.2, 0.3], [2.0, 0.1, 0.3], 0.5),
        &mut memory,
    );
    assert!(
        clamped
            .iter()
            .all(|&node| positions[node] == scene.mesh.positions[node])
    );
    assert!(
        response
            .nodes
            .windows(2)
            .all(|pair| pair[0].node < pair[1].node)
    );
    assert_ne!(memory, ContactMemory::new());

    let (positions, response) = scene.respond(
        arriving([-2.0, 0.2, 5.0], [2.0, 0.1, 5.0], 0.5),
        &mut memory,
    );
    assert_eq!(
        (positions, response),
        (scene.mesh.positions.clone(), Response::default())
    );
    assert_eq!(memory, ContactMemory::new());
}
