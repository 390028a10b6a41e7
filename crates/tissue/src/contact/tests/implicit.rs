//! Implicit methods and statics.

use super::*;
use crate::testing::block_mesh;

pub fn implicit() -> [(Method, f64); 3] {
    let newton = Newton::default();
    [
        (Method::ImplicitEuler(newton), 1e-3),
        (Method::Sdirk2(newton), 1e-3),
        (Method::GuardedMidpoint(newton), 1e-3),
    ]
}

fn one() -> Newton {
    Newton {
        iterations: 1,
        must_converge: false,
        ..Newton::default()
    }
}

/// A block rests on a plane, and the plane carries its weight.
#[test]
fn a_block_rests_on_a_plane() {
    let statics = [
        (Method::QuasiStatic(Newton::default()), 1e-3),
        (Method::QuasiStatic(one()), 1e-3),
        (Method::ImplicitEuler(one()), 1e-3),
    ];
    for (method, h) in implicit().into_iter().chain(statics) {
        for friction in [0.0, 0.3] {
            let mut world = World::new(free_block([2; 3], 100.0), method);
            world.control = gravity();
            world.reach = 0.2e-3;
            world.planes = vec![Plane {
                friction,
                ..Plane::floor(-1e-6)
            }];
            let mut report = StepReport::default();
            for step in 0..200 {
                report = world.step(h).unwrap_or_else(|failure| {
                    panic!("{method:?} {friction}, step {step}: {failure}")
                });
            }
            let weight = 9.81 * world.mass();
            let force = world.force() / weight;
            assert!(
                (force - Vector3::z()).norm() < 1e-6,
                "{method:?} {friction}: {force:?} {report:?}"
            );
            let edge = world.model.mean_edge_length();
            assert!(
                world.deepest() >= -1e-3 * edge,
                "{method:?}: {}",
                world.deepest() / edge
            );
            let fastest = world.state.velocities.iter().map(|v| v.norm());
            let fastest = fastest.fold(0.0, f64::max);
            assert!(fastest < 1e-6, "{method:?} {friction}: {fastest} m/s");
        }
    }
}

/// A free body without contact is refused in statics.
#[test]
fn statics_need_something_that_holds() {
    let mut world = World::new(
        free_block([1; 3], 0.0),
        Method::QuasiStatic(Newton::default()),
    );
    world.control = gravity();
    let failure = world.step(1e-3).unwrap_err();
    assert!(matches!(failure, StepFailure::Singular { .. }));
}

/// A tool is pressed into a clamped block: in one iteration per step, and converged.
#[test]
fn a_tool_presses_a_block() {
    for method in [
        Method::QuasiStatic(Newton::default()),
        Method::QuasiStatic(one()),
        Method::ImplicitEuler(Newton::default()),
        Method::ImplicitEuler(one()),
        Method::Sdirk2(Newton::default()),
        Method::Sdirk2(one()),
    ] {
        let mesh = block_mesh([4e-3, 4e-3, 3e-3], [4, 4, 3]);
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > 1.4e-3).collect();
        let model = build_model(&mesh, &[(0, soft())], &clamped, 300.0, Vec::new()).unwrap();
        let mut world = World::new(model, method);
        world.reach = 0.3e-3;
        world.planes = vec![Plane {
            motion: Vector3::new(0.0, 0.0, 2e-5),
            friction: 0.2,
            sees: |p| p.x.abs() < 1.1e-3 && p.y.abs() < 1.1e-3,
            ..Plane::floor(-1.6e-3)
        }];
        let edge = world.model.mean_edge_length();
        let mut iterations = 0;
        for step in 0..60 {
            if step == 40 {
                world.planes[0].motion = Vector3::zeros();
            }
            let report = world
                .step(4e-3)
                .unwrap_or_else(|failure| panic!("{method:?} step {step}: {failure}"));
            iterations += report.iterations;
            let deepest = world
                .contacts
                .iter()
                .map(|c| c.gap(&world.state.positions))
                .fold(0.0, f64::min);
            assert!(
                deepest >= -1.1e-3 * edge,
                "{method:?} {step}: {}",
                deepest / edge
            );
        }
        println!("{method:?}: {iterations} iterations, {:?} N", world.force());
    }
}
