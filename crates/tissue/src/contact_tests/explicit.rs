//! Explicit methods.

use super::*;
use crate::state::NodeTarget;
use crate::testing::numbers;

/// Nodes under a plane, in any motion, land on it to rounding; the force of the contact, as a load, takes the node to the same
/// place (NUMERICS 2).
#[test]
fn nodes_land_on_a_surface_by_the_force_that_is_told() {
    for (method, h) in explicit() {
        for drag in [0.0, 300.0] {
            let mut world = World::new(free_block([2; 3], drag), method);
            let mut next = numbers();
            let edge = world.model.mean_edge_length();
            for p in &mut world.state.positions {
                *p += Vector3::new(next(), next(), next()) * (0.05 * edge);
            }
            for _ in 0..3 {
                world.step(h).unwrap();
            }
            let before = world.state.clone();
            let height = before.positions.iter().map(|p| p.z).fold(1.0, f64::min);
            world.planes = vec![Plane {
                motion: Vector3::new(0.0, 1e-4, 0.3 * edge),
                friction: 0.3,
                ..Plane::floor(height)
            }];
            world.step(h).unwrap();
            let height = world.planes[0].height;
            assert!(world.contacts.len() > 4, "{}", world.contacts.len());
            for contact in &world.contacts {
                let z = world.state.positions[contact.nodes[0] as usize].z;
                let miss = (z - height).abs();
                assert!(miss <= 1e-10 * edge, "{method:?}: {miss}");
                assert!(contact.normal_force > 0.0);
                let most = 0.3 * contact.normal_force * (1.0 + 1e-12);
                assert!(
                    contact.friction_force.norm() <= most && contact.friction_force.z.abs() < 1e-12
                );
            }
            let mut pushed = World::new(world.model.clone(), method);
            pushed.state = before.clone();
            for contact in &world.contacts {
                let load = (contact.nodes[0], contact.force());
                pushed.control.forces.push(load);
            }
            // Velocity Verlet carries the acceleration of the start: a load must be in that. In the joint form a force acts in the
            // half steps before and after.
            if method == Method::VelocityVerlet {
                let factor = libm::exp(-0.5 * drag * h);
                let both = 1.0 + factor * factor;
                for (node, force) in &pushed.control.forces {
                    let node = *node as usize;
                    pushed.state.accelerations[node] += force * both / pushed.model.masses()[node];
                }
            }
            pushed.step(h).unwrap();
            for (a, b) in world.state.positions.iter().zip(&pushed.state.positions) {
                let miss = (a - b).norm();
                assert!(miss < 1e-9 * edge, "{method:?} {drag}: {miss}");
            }
        }
    }
}

/// Explicit Euler: a force of any size moves the node one step later only.
#[test]
fn explicit_euler_misses() {
    let step = |force: f64| {
        let mut world = World::new(free_block([1; 3], 0.0), Method::ExplicitEuler);
        world.control.forces = vec![(0, Vector3::new(force, 0.0, 0.0))];
        let mut solver = Method::ExplicitEuler.solver(&world.model).unwrap();
        let (model, state) = (&world.model, &mut world.state);
        solver
            .step(model, state, &world.control, &[], 1e-5, &Serial)
            .unwrap();
        world.state.positions
    };
    assert_eq!(step(0.0), step(1.0));
}

/// Nodes pressed against a tool, and one with a target, come to rest: |v| → 0 while springs pull at them.
#[test]
fn held_nodes_come_to_rest() {
    for (method, h) in explicit() {
        let mesh = block_mesh([2e-3; 3], [2; 3]);
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > 0.9e-3).collect();
        let model = build_model(&mesh, &[(0, soft())], &clamped, 1000.0, Vec::new()).unwrap();
        let mut world = World::new(model, method);
        world.planes = vec![Plane {
            motion: Vector3::new(0.0, 0.0, 1e-6),
            friction: 0.5,
            ..Plane::floor(-1e-3)
        }];
        let node = mesh.positions.iter().position(|p| p.norm() < 1e-9).unwrap();
        let target = Vector3::new(2e-4, 0.0, 0.0);
        for step in 0..4000 {
            if step == 200 {
                world.planes[0].motion = Vector3::zeros();
            }
            let aim = NodeTarget {
                node: node as u32,
                target,
                overlap: target - world.state.positions[node],
            };
            world.step_with_targets(&[aim], h).unwrap();
        }
        let fastest = world.state.velocities.iter().map(|v| v.norm());
        let fastest = fastest.fold(0.0, f64::max);
        assert!(fastest < 1e-9, "{method:?}: {fastest} m/s");
        assert!(world.contacts.len() == 9 && world.force().z > 1e-3);
    }
}

/// A block that falls on a plane comes to rest on it, and the plane carries its weight.
#[test]
fn a_block_rests_on_a_plane() {
    for (method, h) in explicit() {
        let mut world = World::new(free_block([2; 3], 300.0), method);
        world.control = gravity();
        world.planes = vec![Plane {
            friction: 0.3,
            ..Plane::floor(-1e-6)
        }];
        for _ in 0..8000 {
            world.step(h).unwrap();
        }
        let weight = 9.81 * world.mass();
        let force = world.force() / weight;
        assert!(
            (force - Vector3::z()).norm() < 1e-6,
            "{method:?}: {force:?}"
        );
        assert!(world.deepest() >= -1e-10 * world.model.mean_edge_length());
        let fastest = world.state.velocities.iter().map(|v| v.norm());
        let fastest = fastest.fold(0.0, f64::max);
        assert!(fastest < 1e-7, "{method:?}: {fastest} m/s");
    }
}

/// A free block deep in a plane is taken out as a whole: no energy at all. A clamped one is pushed out at a speed that adds
/// little to the energy of the shape that it has in the end.
#[test]
fn an_old_overlap_is_undone_in_peace() {
    for (method, h) in explicit() {
        let mut world = World::new(free_block([3; 3], 0.0), method);
        world.planes = vec![Plane::floor(1.5e-3)];
        for _ in 0..40 {
            world.step(h).unwrap();
            assert!(world.force().norm() < 1e-12, "{method:?}");
        }
        let edge = world.model.mean_edge_length();
        assert!(world.deepest() >= -1e-9 * edge, "{}", world.deepest());
        // Springs at rest have forces of rounding.
        let energy = world.state.energies(&world.model).total();
        assert!(energy < 1e-20, "{method:?}: {energy} J");

        let mesh = block_mesh([3e-3; 3], [3; 3]);
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > 1.4e-3).collect();
        let model = build_model(&mesh, &[(0, soft())], &clamped, 200.0, Vec::new()).unwrap();
        let mut world = World::new(model, method);
        world.planes = vec![Plane::floor(-1e-3)];
        let mut most = 0.0f64;
        for _ in 0..9000 {
            world.step(h).unwrap();
            most = most.max(world.state.energies(&world.model).total());
        }
        assert!(world.deepest() >= -1e-9 * edge);
        let end = world.state.energies(&world.model).total();
        assert!(most < 1.3 * end, "{method:?}: {most} J, at rest {end} J");
    }
}
