//! One domain, projected as position-based methods do, against the forces of the same set.

use crate::elements::{
    Configuration, Continuum, Elements, NodeWindow, Smoothed, SmoothingDomains, Tetrahedra,
};
use crate::law::{Lame, NeoHookeanPolynomial, StableNeoHookean};
use crate::testing::{numbers, soft_block};
use microsim_mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

const LAME: Lame = Lame {
    mu: 4e3,
    lambda: 3e4,
};

/// Tetrahedra, and domains around nodes, with both constants and with one of them.
fn sets(mesh: &TetMesh, relaxation_time: f64) -> Vec<Arc<dyn Elements>> {
    type L = NeoHookeanPolynomial;
    let all: Vec<u32> = (0..mesh.tets.len() as u32).collect();
    let mut sets: Vec<Arc<dyn Elements>> = Vec::new();
    for lame in [
        LAME,
        Lame {
            lambda: 0.0,
            ..LAME
        },
        Lame { mu: 0.0, ..LAME },
    ] {
        let tetrahedra = Tetrahedra::new(mesh, &all);
        sets.push(Arc::new(Continuum::<L>::new(
            tetrahedra,
            lame,
            relaxation_time,
        )));
        let nodes = SmoothingDomains::around_nodes(mesh, &all);
        sets.push(Arc::new(Smoothed::<L>::new(nodes, lame, relaxation_time)));
    }
    sets
}

/// Unequal masses \[kg\] of the size of a cell's.
fn masses(mesh: &TetMesh) -> Vec<f64> {
    let mut next = numbers();
    mesh.positions
        .iter()
        .map(|_| 1e-7 * (1.5 + next()))
        .collect()
}

/// Strains of order 0.3.
fn deformed(mesh: &TetMesh) -> Vec<Vector3<f64>> {
    let map = Matrix3::new(1.1, 0.3, -0.2, -0.4, 0.9, 0.1, 0.2, 0.1, 1.05);
    let mut next = numbers();
    let moved = mesh.positions.iter();
    moved
        .map(|p| map * p + Vector3::from_fn(|_, _| next()) * 1e-4)
        .collect()
}

/// Positions after one projection of one element that starts without multipliers.
fn project(
    set: &dyn Elements,
    element: usize,
    positions: &[Vector3<f64>],
    previous: &[Vector3<f64>],
    masses: &[f64],
    h: f64,
) -> Vec<Vector3<f64>> {
    let constraints = set.constraints().unwrap();
    let inverse: Vec<f64> = masses.iter().map(|m| 1.0 / m).collect();
    let mut moved = positions.to_vec();
    let mut multipliers = vec![0.0; constraints.multipliers()];
    constraints.project(
        element,
        &mut moved,
        previous,
        &inverse,
        &[],
        &mut multipliers,
        h,
    );
    moved
}

#[test]
fn the_rest_shape_stays_where_it_is() {
    let mesh = soft_block([2, 2, 1]);
    let masses = masses(&mesh);
    for set in sets(&mesh, 0.1) {
        // A step that is short and one that is far beyond every explicit limit.
        for h in [1e-6, 1e-2] {
            let moved = project(
                set.as_ref(),
                3,
                &mesh.positions,
                &mesh.positions,
                &masses,
                h,
            );
            for (a, b) in moved.iter().zip(&mesh.positions) {
                assert!(
                    (a - b).amax() < 1e-15,
                    "a millimetre, to rounding: {}",
                    a - b
                );
            }
        }
    }
}

#[test]
fn in_a_short_step_the_projection_is_the_force() {
    let mesh = soft_block([2, 2, 1]);
    let masses = masses(&mesh);
    let previous = deformed(&mesh);
    let mut next = numbers();
    let velocities: Vec<Vector3<f64>> = mesh
        .positions
        .iter()
        .map(|_| Vector3::from_fn(|_, _| next()) * 0.1)
        .collect();
    // ω² = λ·(1e-3 m)/(1e-7 kg) = 3e8 / s² and 5 more for the many tetrahedra at a node: h ω ≈ 4e-4, and τ h ω² ≈ 2e-4.
    let (h, time) = (1e-8, 1e-5);
    for relaxation_time in [0.0, time] {
        for set in sets(&mesh, relaxation_time) {
            for element in [0, 5] {
                let predicted: Vec<_> = previous
                    .iter()
                    .zip(&velocities)
                    .map(|(p, v)| p + v * h)
                    .collect();
                let moved = project(set.as_ref(), element, &predicted, &previous, &masses, h);
                let mut forces = vec![Vector3::zeros(); mesh.positions.len()];
                let at = Configuration {
                    positions: &previous,
                    velocities: &velocities,
                    internal: &[],
                };
                let mut window = NodeWindow {
                    first: 0,
                    values: &mut forces,
                };
                set.add_forces(element..element + 1, &at, &mut window);
                let scale = forces.iter().map(|f| f.amax()).fold(0.0, f64::max);
                for node in set.nodes(element) {
                    let node = *node as usize;
                    let felt = (moved[node] - predicted[node]) * (masses[node] / (h * h));
                    let error = (felt - forces[node]).amax() / scale;
                    assert!(error < 2e-3, "{error:e}");
                }
            }
        }
    }
}

#[test]
fn a_projection_keeps_momentum() {
    let mesh = soft_block([2, 2, 1]);
    let masses = masses(&mesh);
    let positions = deformed(&mesh);
    for set in sets(&mesh, 0.0) {
        let moved = project(set.as_ref(), 2, &positions, &positions, &masses, 1e-3);
        let (mut linear, mut angular, mut size) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for ((p, q), m) in positions.iter().zip(&moved).zip(&masses) {
            linear += (q - p) * *m;
            angular += p.cross(&(q - p)) * *m;
            size += (q - p).norm() * m;
        }
        assert!(size > 0.0 && linear.norm() < 1e-13 * size);
        // Lever arms of 1e-3 m.
        assert!(angular.norm() < 1e-16 * size, "{angular}");
    }
}

#[test]
fn an_inverted_element_comes_back() {
    // One regular tetrahedron with a corner pushed through the opposite face, and no inertia from step to step.
    let mesh = regular_tetrahedron();
    let set = Continuum::<NeoHookeanPolynomial>::new(Tetrahedra::new(&mesh, &[0]), LAME, 0.0);
    let volume = |p: &[Vector3<f64>]| microsim_mesh::signed_volume(&p[0], &p[1], &p[2], &p[3]);
    let mut positions = mesh.positions.clone();
    let opposite = (positions[1] + positions[2] + positions[3]) / 3.0;
    positions[0] = opposite * 1.5 - positions[0] * 0.5;
    assert!(volume(&positions) < 0.0);
    // h² times the largest stiffness per mass is 1, see the last test: at the explicit limit.
    let masses = vec![1e-7; 4];
    let h = (inertia(&mesh, 1e-7) / (volume(&mesh.positions) * EXPANSION)).sqrt();
    for _ in 0..300 {
        positions = project(&set, 0, &positions, &positions, &masses, h);
    }
    let share = volume(&positions) / volume(&mesh.positions);
    assert!((share - 1.0).abs() < 1e-6, "{share}");
}

#[test]
fn other_laws_are_no_constraints() {
    let mesh = soft_block([1, 1, 1]);
    let tetrahedra = Tetrahedra::new(&mesh, &[0]);
    let set = Continuum::<StableNeoHookean>::new(tetrahedra, LAME, 0.0);
    assert!(set.constraints().is_none());
}

/// Corners of a cube of 1 mm.
fn regular_tetrahedron() -> TetMesh {
    let corners = [
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, -1.0],
        [1.0, -1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    let positions = corners.map(|c| Vector3::from(c) * 0.5e-3);
    TetMesh::new(positions.to_vec(), vec![[0, 1, 2, 3]], vec![0])
}

/// Σ m |X|² \[kg·m²\].
fn inertia(mesh: &TetMesh, mass: f64) -> f64 {
    mesh.positions.iter().map(|p| mass * p.norm_squared()).sum()
}

/// Second derivative of the energy density by a for F = (1 + a) 1 \[Pa\].
const EXPANSION: f64 = 6.0 * LAME.mu + 9.0 * LAME.lambda;

/// A regular tetrahedron that expands uniformly, x = (1 + a) X, is an oscillator with one degree of freedom: V·(6μ + 9λ) a²/2
/// of energy, τ times that of damping, Σ m |X|² of inertia. Released from rest length with a speed, implicit Euler leaves the
/// fraction 1/(1 + h²ω² (1 + τ/h)) of the displacement that it would have freely.
#[test]
fn viscosity_slows_an_expansion_as_implicit_euler_does() {
    let mesh = regular_tetrahedron();
    let (mass, way) = (1e-7, 1e-6);
    let volume = mesh.volumes()[0];
    let square = volume * EXPANSION / inertia(&mesh, mass);
    // Short enough that the elastic part matters little, and what gradients that change do to it even less.
    let h = 0.01 / square.sqrt();
    for ratio in [1e2, 1e4, 1e6] {
        let domains = Tetrahedra::new(&mesh, &[0]);
        let set = Continuum::<NeoHookeanPolynomial>::new(domains, LAME, ratio * h);
        let constraints = set.constraints().unwrap();
        let mut positions: Vec<_> = mesh.positions.iter().map(|p| p * (1.0 + way)).collect();
        let mut multipliers = vec![0.0; constraints.multipliers()];
        for _ in 0..2000 {
            constraints.project(
                0,
                &mut positions,
                &mesh.positions,
                &[1.0 / mass; 4],
                &[],
                &mut multipliers,
                h,
            );
        }
        let left = (positions[0].norm() / mesh.positions[0].norm() - 1.0) / way;
        let expected = 1.0 / (1.0 + 1e-4 * (1.0 + ratio));
        assert!((left / expected - 1.0).abs() < 2e-4, "{left} {expected}");
    }
}
