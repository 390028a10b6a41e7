//! Friction, impact and overlaps, in all methods.

use super::*;
use nalgebra::UnitVector3;

fn all() -> Vec<(Method, f64)> {
    let xpbd = Method::Xpbd {
        substeps: 10,
        iterations: 2,
    };
    let mut all = explicit().to_vec();
    all.extend(super::implicit::implicit());
    all.push((xpbd, 1e-3));
    all
}

/// Gravity as on a slope of this angle.
fn slope(angle: f64) -> Control {
    Control {
        gravity: Vector3::new(libm::sin(angle), 0.0, -libm::cos(angle)) * 9.81,
        ..Control::default()
    }
}

/// Below the angle of friction a block stays, above it slides with g (sin − μ cos).
#[test]
fn a_block_on_a_slope_sticks_or_slides() {
    let friction = 0.4;
    let angle = libm::atan(friction);
    for (method, h) in all() {
        for share in [0.97, 1.1] {
            let mut world = World::new(free_block([3, 2, 1], 0.0), method);
            world.reach = if method.is_explicit() { 0.0 } else { 0.1e-3 };
            world.control = slope(share * angle);
            world.planes = vec![Plane {
                friction,
                ..Plane::floor(0.0)
            }];
            let time = 0.1;
            let steps = (time / h) as usize;
            let mut half = Vector3::zeros();
            for step in 0..steps {
                if step == steps / 2 {
                    half = world.velocity();
                }
                world
                    .step(h)
                    .unwrap_or_else(|failure| panic!("{method:?} {step}: {failure}"));
            }
            let acceleration = (world.velocity() - half).x / (0.5 * time);
            let g = world.control.gravity;
            let wanted = (g.x + friction * g.z).max(0.0);
            if share < 1.0 {
                let speed = world.velocity().norm();
                assert!(speed < 1e-3 * 9.81 * time, "{method:?}: {speed} m/s");
            } else {
                assert!(
                    (acceleration / wanted - 1.0).abs() < 0.01,
                    "{method:?}: {acceleration} m/s², not {wanted}"
                );
            }
            let mut touching = world.contacts.iter().filter(|c| c.normal_force > 0.0);
            assert!(touching.clone().count() > 0, "{method:?}");
            assert!(
                touching.all(|c| c.is_sliding == (share > 1.0)),
                "{method:?}"
            );
            let edge = world.model.mean_edge_length();
            assert!(world.deepest() > -0.01 * edge, "{method:?}");
        }
    }
}

/// Two blocks that hit one another head-on: momentum is conserved, energy never rises, no node gets past the other.
#[test]
fn blocks_that_hit_each_other_keep_momentum() {
    let one = free_block([3, 2, 2], 0.0);
    let model = TissueModel::union(&[&one, &one]);
    let nodes = one.node_count() as u32;
    for (method, h) in all() {
        let mut world = World::new(model.clone(), method);
        let gap = 0.05e-3;
        for node in 0..nodes as usize {
            world.state.positions[node].x += 3e-3 + gap;
            world.state.velocities[node].x = -0.3;
            world.state.velocities[node + nodes as usize].x = 0.5;
        }
        let low = |node: &u32| one.rest_positions()[*node as usize].x < -1.49e-3;
        for a in (0..nodes).filter(low) {
            let mut there = one.rest_positions()[a as usize];
            there.x = 1.5e-3;
            let b = one
                .rest_positions()
                .iter()
                .position(|p| (p - there).norm() < 1e-9);
            world.pairs.push([a, b.unwrap() as u32 + nodes]);
        }
        world.reach = if method.is_explicit() { 0.0 } else { 0.1e-3 };
        let before = world.velocity();
        let start = world.state.energies(&world.model).total();
        let (mut most, mut deepest) = (0.0f64, 0.0f64);
        for step in 0..(0.02 / h) as usize {
            world
                .step(h)
                .unwrap_or_else(|failure| panic!("{method:?} {step}: {failure}"));
            most = most.max(world.state.energies(&world.model).total());
            deepest = deepest.min(world.deepest());
        }
        let edge = world.model.mean_edge_length();
        let change = (world.velocity() - before).norm();
        assert!(change < 1e-12 * 0.5, "{method:?}: {change} m/s");
        assert!(
            most <= start * (1.0 + 1e-9),
            "{method:?}: {most} of {start}"
        );
        assert!(deepest >= -1e-3 * edge, "{method:?}: {}", deepest / edge);
        // They have parted: what was 0.8 m/s of approach is none.
        let part = |nodes: std::ops::Range<usize>| -> f64 {
            nodes.map(|node| world.state.velocities[node].x).sum()
        };
        let nodes = nodes as usize;
        assert!(part(0..nodes) > part(nodes..2 * nodes), "{method:?}");
    }
}

/// A block is pulled over a plane by a spring load that grows: it sticks until μ N, then slides, and the plane holds μ N.
#[test]
fn a_pulled_block_slips_at_the_force_of_friction() {
    for (method, h) in all() {
        let mut world = World::new(free_block([2, 2, 1], 10.0), method);
        let friction = 0.5;
        world.reach = if method.is_explicit() { 0.0 } else { 0.1e-3 };
        world.planes = vec![Plane {
            friction,
            ..Plane::floor(0.0)
        }];
        let nodes = world.model.node_count();
        let weight = 9.81 * world.mass();
        let steps = (0.4 / h) as usize;
        let (mut held, mut holds) = (0.0f64, 0.0);
        for step in 0..steps {
            // The pull grows to 1.5 times what friction holds, along x, at all nodes.
            let pull = 1.5 * friction * weight * step as f64 / steps as f64;
            world.control = gravity();
            world.control.forces = (0..nodes as u32)
                .map(|node| {
                    let share = world.model.masses()[node as usize] / world.mass();
                    (node, Vector3::x() * (pull * share))
                })
                .collect();
            world
                .step(h)
                .unwrap_or_else(|failure| panic!("{method:?} {step}: {failure}"));
            if pull < 0.98 * friction * weight {
                held = held.max(world.velocity().x);
            }
            if step >= steps - steps / 5 {
                holds -= world.force().x / (steps / 5) as f64;
            }
        }
        assert!(held < 2e-3, "{method:?}: {held} m/s");
        assert!(world.velocity().x > 0.1);
        let share = holds / (friction * weight);
        assert!((share - 1.0).abs() < 0.01, "{method:?}: {share} of μ N");
    }
}

/// A free block with a wall deep inside is taken out of it as a whole: nothing flies, nothing is strained.
#[test]
fn old_overlaps_are_undone_in_peace() {
    for (method, h) in all() {
        let mut world = World::new(free_block([3; 3], 0.0), method);
        world.reach = if method.is_explicit() { 0.0 } else { 0.1e-3 };
        let normal = UnitVector3::new_normalize(Vector3::new(0.2, 0.1, 1.0));
        world.planes = vec![Plane {
            normal: *normal,
            ..Plane::floor(1.0e-3)
        }];
        let mut most = 0.0f64;
        for step in 0..(0.05 / h) as usize {
            world
                .step(h)
                .unwrap_or_else(|failure| panic!("{method:?} {step}: {failure}"));
            most = most.max(world.state.energies(&world.model).total());
        }
        let edge = world.model.mean_edge_length();
        assert!(world.deepest() > -0.01 * edge, "{method:?}");
        // Springs at rest have forces of rounding.
        assert!(most < 1e-20, "{method:?}: {most} J");
    }
}
