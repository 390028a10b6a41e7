//! Responses to contact other than constraints.

use super::*;
use crate::spec::{ContactResponse, ObstacleSpec};
use microsim_contact::{Depth, ObstaclePart, ObstacleShape};

const EDGE: f64 = 2e-3;
const STIFFNESS: f64 = 1.0;

/// A soft cube above the plane z = 0 that falls with drag.
fn above_a_plane(method: Method, height: f64, response: ContactResponse) -> SceneSpec {
    let block = Block {
        center: [0.0, 0.0, 0.5 * EDGE + height],
        size: [EDGE; 3],
        cells: [1; 3],
        split: CellSplit::Kuhn,
    };
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Springs(SpringConstants::scaled(500.0, 500.0)),
    };
    let mut cube = BodySpec::new("cube", block.mesh().unwrap(), material);
    cube.drag = 100.0;
    SceneSpec {
        obstacles: vec![ObstacleSpec {
            name: "table".into(),
            parts: vec![ObstaclePart {
                shape: ObstacleShape::HalfSpace,
                pose: Pose::identity(),
            }],
        }],
        contacts: vec![ContactSpec {
            response,
            ..ContactSpec::new("cube", PartnerSpec::Obstacle("table".into()))
        }],
        ..SceneSpec::new(vec![cube], method)
    }
}

fn lowest(scene: &Scene) -> Vec<f64> {
    let heights = scene.body(0).positions().iter().map(|p| p.z);
    heights.filter(|z| *z < 0.5 * EDGE).collect()
}

/// The springs carry the weight: Σ k depth = m g, whatever the depth of each. Explicit Euler can, as a penalty needs no motion within the step.
#[test]
fn a_penalty_rests_as_deep_as_carries_the_weight() {
    let penalty = ContactResponse::Penalty {
        stiffness: STIFFNESS,
        depth: Depth::Consistent,
    };
    for method in [Method::ExplicitEuler, Method::StoermerVerlet] {
        let mut scene = Scene::new(&above_a_plane(method, 0.0, penalty)).unwrap();
        for _ in 0..50 {
            scene.tick(&[], 0.02, 2000, &Serial).unwrap();
        }
        let depths: f64 = lowest(&scene).iter().map(|z| -z).sum();
        let weight = 1000.0 * EDGE * EDGE * EDGE * 9.81;
        let carried = STIFFNESS * depths;
        assert!(
            (carried / weight - 1.0).abs() < 1e-6,
            "{method:?}: {carried} of {weight} N"
        );
    }
}

/// In the step in which they would come below the plane, all lower nodes land on it (NUMERICS 2: to round-off).
#[test]
fn a_target_force_lands_nodes_on_the_surface() {
    let response = ContactResponse::TargetForce {
        depth: Depth::Consistent,
    };
    for method in [
        Method::SymplecticEuler,
        Method::StoermerVerlet,
        Method::VelocityVerlet,
        Method::VelocityVerletLagged,
    ] {
        let height = 0.1 * EDGE;
        let mut scene = Scene::new(&above_a_plane(method, height, response)).unwrap();
        let mut landed = false;
        for _ in 0..10_000 {
            scene.tick(&[], 20e-6, 1, &Serial).unwrap();
            let lower = lowest(&scene);
            assert!(
                lower.iter().all(|z| *z > -1e-12 * EDGE),
                "{method:?} {lower:?}"
            );
            landed |= lower.iter().filter(|z| z.abs() < 1e-12 * EDGE).count() == 4;
        }
        assert!(landed, "{method:?}");
    }
}

/// What has contact in its equations takes no other force, and constraints of explicit Euler come a step late.
#[test]
fn responses_that_a_method_cannot_have_are_refused() {
    let depth = Depth::Nearest;
    let refused = |method, response| {
        let error = Scene::new(&above_a_plane(method, 0.0, response)).expect_err("refused");
        error.to_string()
    };
    let target = ContactResponse::TargetForce { depth };
    let implicit = Method::ImplicitEuler(Newton::default());
    assert!(refused(implicit, target).contains("is for explicit methods"));
    assert!(refused(Method::ExplicitEuler, target).contains("or contact by penalty"));
    for stiffness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let penalty = ContactResponse::Penalty { stiffness, depth };
        assert!(refused(Method::StoermerVerlet, penalty).contains("above 0 N/m"));
    }
    let mut spec = above_a_plane(Method::StoermerVerlet, 0.0, target);
    spec.contacts[0].friction = 0.1;
    let error = Scene::new(&spec).expect_err("friction").to_string();
    assert!(error.contains("neither friction"), "{error}");
}
