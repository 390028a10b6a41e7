//! Implicit methods and statics.

use super::*;
use crate::newton::NewtonOptions;
use crate::solver_implicit::{DistortionOptions, ImplicitScheme, SolverImplicit};
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
            let mut report = StepReport::without_residual(0);
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

/// A wavy tool against a clamped block: of the forces the tool has what the elements leave, where it touches; elsewhere there is a gap and
/// no force. For a small depth they are those of the linear complementarity problem of the compliance matrix, solved by projected
/// Gauss–Seidel to rounding.
#[test]
fn forces_are_those_of_the_complementarity_problem() {
    let mesh = block_mesh([5e-3, 4e-3, 3e-3], [5, 4, 3]);
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > 1.4e-3).collect();
    let model = build_model(&mesh, &[(0, soft())], &clamped, 0.0, Vec::new()).unwrap();
    let edge = model.mean_edge_length();
    let nodes: Vec<usize> = (0..model.node_count())
        .filter(|&node| model.rest_positions()[node].z < -1.4e-3)
        .collect();
    let bump = |p: &Vector3<f64>| 4e-6 * libm::sin(1500.0 * p.x) * libm::cos(900.0 * p.y) - 4e-6;
    for (method, depth, tolerance) in [
        (Method::QuasiStatic(Newton::default()), 5e-6, 0.01),
        (Method::QuasiStatic(Newton::default()), 4e-4, f64::INFINITY),
        (Method::QuasiStatic(one()), 5e-6, 0.02),
    ] {
        let mut world = World::new(model.clone(), method);
        world.reach = 0.3 * edge;
        world.planes = vec![Plane {
            motion: Vector3::z() * depth,
            sees: |p| p.z < -1.4e-3,
            bump,
            ..Plane::floor(-1.5e-3)
        }];
        let report = world.step(1.0).unwrap();
        if method == Method::QuasiStatic(Newton::default()) {
            // Forces of elements and contacts, on each node.
            let mut left = crate::Forces::new(&model)
                .compute(&model, &world.state, &world.control, &Serial)
                .to_vec();
            let strongest = world
                .contacts
                .iter()
                .map(|c| c.normal_force)
                .fold(0.0, f64::max);
            for contact in &world.contacts {
                left[contact.nodes[0] as usize] += contact.force();
                let gap = contact.gap(&world.state.positions);
                assert!(gap > -1e-5 * edge, "{} edges", gap / edge);
                assert!(
                    contact.normal_force == 0.0 || gap < 1e-5 * edge,
                    "{} N over {} edges",
                    contact.normal_force,
                    gap / edge
                );
            }
            for (node, force) in left.iter().enumerate() {
                let left = if model.is_clamped(node) {
                    0.0
                } else {
                    force.norm()
                };
                assert!(
                    left < 1e-3 * strongest,
                    "{left} N of {strongest} N, {report:?}"
                );
            }
        }
        if tolerance.is_finite() {
            let exact = complementarity(&model, &nodes, |node| {
                -1.5e-3 + depth + bump(&model.rest_positions()[node])
            });
            let strongest = exact.iter().copied().fold(0.0, f64::max);
            let open = exact.iter().filter(|p| **p == 0.0).count();
            assert!(open > 3 && open + 3 < nodes.len(), "{open} are open");
            for (node, exact) in nodes.iter().zip(&exact) {
                let found = world.contacts.iter().find(|c| c.nodes[0] as usize == *node);
                let found = found.map_or(0.0, |c| c.normal_force);
                assert!(
                    (found - exact).abs() < tolerance * strongest,
                    "{method:?}: {found} N, not {exact} N of {strongest} N"
                );
            }
        }
    }
}

/// Forces \[N\] along z that keep `nodes` of a linear body at rest above `heights` \[m\].
fn complementarity(
    model: &TissueModel,
    nodes: &[usize],
    height: impl Fn(usize) -> f64,
) -> Vec<f64> {
    use crate::elements::Tangent;
    use crate::system::{MatrixCoefficients, System};
    use microsim_contact_solver::LinearSystem;
    let mut system = System::new(model);
    let none = MatrixCoefficients {
        damping: 0.0,
        rate: 0.0,
    };
    system.assemble(model, &State::at_rest(model), none, Tangent::Exact);
    let fixed: Vec<bool> = (0..model.node_count())
        .map(|n| model.is_clamped(n))
        .collect();
    system.factorise(&fixed).unwrap();
    let mut compliance = Vec::new();
    for &node in nodes {
        let mut x = vec![Vector3::zeros(); model.node_count()];
        x[node] = Vector3::z();
        system.solve(&mut x, 1e-12).unwrap();
        compliance.push(nodes.iter().map(|&other| x[other].z).collect::<Vec<f64>>());
    }
    let mut forces = vec![0.0f64; nodes.len()];
    for _ in 0..3000 {
        for (i, &node) in nodes.iter().enumerate() {
            let moved: f64 = compliance[i].iter().zip(&forces).map(|(c, f)| c * f).sum();
            let gap = model.rest_positions()[node].z + moved - height(node);
            forces[i] = (forces[i] - gap / compliance[i][i]).max(0.0);
        }
    }
    forces
}

/// A clamped block that a wall is deep inside at the start is pushed out of it by no force that moves it on.
#[test]
fn an_old_overlap_of_a_clamped_block_is_undone_in_peace() {
    for (method, h) in implicit() {
        let mesh = block_mesh([3e-3; 3], [3; 3]);
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > 1.4e-3).collect();
        let model = build_model(&mesh, &[(0, soft())], &clamped, 200.0, Vec::new()).unwrap();
        let edge = model.mean_edge_length();
        let mut world = World::new(model, method);
        world.reach = 0.3 * edge;
        world.planes = vec![Plane::floor(-1e-3)];
        let mut most = 0.0f64;
        for step in 0..200 {
            world
                .step(h)
                .unwrap_or_else(|failure| panic!("{method:?} {step}: {failure}"));
            most = most.max(world.state.energies(&world.model).total());
        }
        assert!(
            world.deepest() >= -2e-3 * edge,
            "{}",
            world.deepest() / edge
        );
        let end = world.state.energies(&world.model).total();
        assert!(most < 1.3 * end, "{method:?}: {most} J, at rest {end} J");
    }
}

/// Nodes go no further than they may for what is undone, and those that go less far go as far as without that bound.
#[test]
fn undone_overlaps_move_no_node_far() {
    let mesh = block_mesh([3e-3; 3], [3; 3]);
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > 1.4e-3).collect();
    let moved = |longest: f64| {
        let model = build_model(&mesh, &[(0, soft())], &clamped, 200.0, Vec::new()).unwrap();
        let edge = model.mean_edge_length();
        let mut options = NewtonOptions::default();
        options.contact_solvers.overlap.longest = longest;
        let mut world = World::new(model, Method::ImplicitEuler(one()));
        world.solver = Box::new(SolverImplicit::with_options(
            &world.model,
            ImplicitScheme::BackwardEuler,
            one(),
            &options,
            DistortionOptions::default(),
        ));
        world.reach = 0.3 * edge;
        world.planes = vec![Plane::floor(-1e-3)];
        world.step(8e-3).unwrap();
        let moved = world.state.positions.iter().zip(&mesh.positions);
        let moved: Vec<f64> = moved.map(|(x, rest)| (x - rest).norm() / edge).collect();
        moved
    };
    let free = moved(1.0);
    let most = free.iter().fold(0.0f64, |most, of| most.max(*of));
    assert!(most > 0.01 && most < 1.0, "{most}");
    let bound = 0.5 * most;
    for (bounded, free) in moved(bound).iter().zip(&free) {
        // Positions of millimetres are rounded at 1e-16 of an edge.
        assert!(
            (bounded - free.min(bound)).abs() < 1e-12,
            "{bounded} {free}"
        );
    }
}

/// Clamps that jump onto a tool: the first iteration keeps the gaps too, in statics and in time.
#[test]
fn clamps_that_move_against_a_tool_keep_gaps() {
    for method in [
        Method::QuasiStatic(Newton::default()),
        Method::QuasiStatic(one()),
        Method::ImplicitEuler(one()),
    ] {
        let mesh = block_mesh([3e-3; 3], [3; 3]);
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.z > 1.4e-3).collect();
        let model = build_model(&mesh, &[(0, soft())], &clamped, 200.0, Vec::new()).unwrap();
        let edge = model.mean_edge_length();
        let mut world = World::new(model, method);
        world.reach = 0.3 * edge;
        world.planes = vec![Plane::floor(-1.55e-3)];
        for step in 1..=10 {
            let down = Vector3::z() * (-5e-5 * f64::from(step));
            let clamps = world.model.clamped().iter();
            world.control.clamped_positions = clamps
                .map(|&node| world.model.rest_positions()[node as usize] + down)
                .collect();
            let report = world.step(1e-2).unwrap();
            assert!(
                world.deepest() >= -0.02 * edge,
                "{method:?} {step}: {} {report:?}",
                world.deepest() / edge
            );
        }
        assert!(world.force().z > 1e-3);
    }
}
