//! The contract for springs, triangles and volumes; collapsed, flat and inverted elements; plasticity; projection.

use super::*;
use crate::elements::contract;
use crate::testing::numbers;

/// Random positions of `n` nodes in a cube of edge two.
fn cloud(n: usize, next: &mut impl FnMut() -> f64) -> Vec<Vector3<f64>> {
    (0..n)
        .map(|_| Vector3::new(next(), next(), next()))
        .collect()
}

/// Some elements over the six nodes of a cloud, with values of order one.
fn set<M: Measure<N>, const N: usize>(
    next: &mut impl FnMut() -> f64,
    damping: f64,
) -> ConstraintSet<M, N> {
    let nodes = [[0, 1, 2, 3], [4, 2, 1, 5], [3, 0, 5, 1]];
    ConstraintSet::new(nodes.map(|nodes: [u32; 4]| Constraint {
        nodes: std::array::from_fn(|i| nodes[i]),
        rest: 0.6 + 0.5 * next(),
        stiffness: 2.0 + next(),
        damping: damping * (1.0 + 0.5 * next()),
    }))
}

fn check_contract<M: Measure<N>, const N: usize>() {
    let mut next = numbers();
    let mut sides = [false; 2];
    for case in 0..60 {
        let positions = cloud(6, &mut next);
        let velocities = cloud(6, &mut next);
        let mut set = set::<M, N>(&mut next, if case % 2 == 0 { 0.0 } else { 0.7 });
        let corners: Vec<_> = set
            .nodes
            .iter()
            .map(|e| e.map(|node| positions[node as usize]))
            .collect();
        // Differences of a length or an area need one that is not much smaller than δ.
        if M::EXPONENT < 3 && corners.iter().any(|p| M::value(p.each_ref()) < 0.2) {
            continue;
        }
        for (p, rest) in corners.iter().zip(&set.rest) {
            sides[usize::from(M::value(p.each_ref()) > *rest)] = true;
        }
        contract::check(&set, &positions, &velocities, &[]);
        // With internal variables: other rest values, stiffer.
        set = set.with_plasticity(PLASTICITY);
        contract::check(
            &set,
            &positions,
            &velocities,
            &[0.3, 0.5, 0.9, 1.0, 1.7, 2.5],
        );
    }
    assert_eq!(
        sides, [true; 2],
        "elements in tension and in compression were tried"
    );
}

const PLASTICITY: Plasticity = Plasticity {
    yield_strain: 0.1,
    creep_rate: 2.0,
    max_strain: 1.0,
    hardening: 3.0,
    max_stiffening: 4.0,
};

#[test]
fn springs_keep_the_contract() {
    check_contract::<Length, 2>();
}

#[test]
fn triangles_keep_the_contract() {
    check_contract::<Area, 3>();
}

#[test]
fn volumes_of_both_signs_keep_the_contract() {
    check_contract::<Volume, 4>();
    let mut next = numbers();
    let mut signs = [false; 2];
    for _ in 0..60 {
        let p: [_; 4] = std::array::from_fn(|_| Vector3::new(next(), next(), next()));
        signs[usize::from(Volume::value(p.each_ref()) > 0.0)] = true;
    }
    assert_eq!(signs, [true; 2], "both signs occur among such numbers");
}

#[test]
fn the_rest_state_has_no_energy_and_no_force() {
    let p = cloud(4, &mut numbers());
    let still = vec![Vector3::zeros(); 4];
    let at = Configuration {
        positions: &p,
        velocities: &still,
        internal: &[],
    };
    let constraint = |rest| (rest, 3.0, 1.0);
    fn of<const N: usize>((rest, stiffness, damping): (f64, f64, f64)) -> [Constraint<N>; 1] {
        let nodes = std::array::from_fn(|i| i as u32);
        [Constraint {
            nodes,
            rest,
            stiffness,
            damping,
        }]
    }
    let sets: [&dyn Elements; 3] = [
        &Springs::new(of(constraint(Length::value([&p[0], &p[1]])))),
        &Areas::new(of(constraint(Area::value([&p[0], &p[1], &p[2]])))),
        &Volumes::new(of(constraint(Volume::value([&p[0], &p[1], &p[2], &p[3]])))),
    ];
    for set in sets {
        assert_eq!(set.energy(&at), 0.0);
        let mut forces = vec![Vector3::zeros(); 4];
        set.add_forces(
            0..1,
            &at,
            &mut NodeWindow {
                first: 0,
                values: &mut forces,
            },
        );
        // The volume of the gradient is e1·g1, that of the mesh another order of the same products.
        assert!(forces.iter().all(|f| f.norm() < 1e-15), "{forces:?}");
    }
}

#[test]
fn a_collapsed_spring_and_a_collapsed_triangle_exert_no_force_and_no_nan() {
    let p = [Vector3::new(0.1, 0.2, 0.3); 3];
    let (length, g) = Length::gradient([&p[0], &p[1]]);
    assert_eq!((length, g), (0.0, [Vector3::zeros(); 2]));
    let (area, g) = Area::gradient(p.each_ref());
    assert_eq!((area, g), (0.0, [Vector3::zeros(); 3]));
    for tangent in [Tangent::Exact, Tangent::Positive] {
        let mut out = ElementMatrix::new();
        out.reset(3);
        Length::add_curvature([&p[0], &p[1]], 1.0, tangent, &mut out);
        Area::add_curvature(p.each_ref(), 1.0, tangent, &mut out);
        assert_eq!(*out.block(0, 1), nalgebra::Matrix3::zeros());
    }
    // No absolute epsilon: a spring of 1e-12 m pushes like any other.
    let (_, g) = Length::gradient([&Vector3::zeros(), &(Vector3::y() * 1e-12)]);
    assert_eq!(g, [-Vector3::y(), Vector3::y()]);
    // A triangle that is flat but not a point: its nodes in line, no normal, no force.
    let line = [0.0, 1.0, 3.0].map(|x| Vector3::x() * x);
    assert_eq!(Area::gradient(line.each_ref()).1, [Vector3::zeros(); 3]);
}

#[test]
fn the_volume_force_turns_a_flat_and_an_inverted_tetrahedron_back() {
    let base = [Vector3::zeros(), Vector3::x(), Vector3::y()];
    for height in [0.0, -0.5, -1.0] {
        let tip = Vector3::z() * height;
        let (value, g) = Volume::gradient([&base[0], &base[1], &base[2], &tip]);
        assert!(value <= 0.0);
        let force = g[3] * (1.0 / 6.0 - value);
        assert!(
            force.z > 0.0,
            "the force on the tip points to the positive side"
        );
    }
}

#[test]
fn plastic_flow_of_a_set_moves_rest_values_once_per_element() {
    // Held at a stretch of 1.5: one spring yields, one does not.
    let springs = Springs::new([1.0, 1.45].map(|rest| Constraint {
        nodes: [0, 1],
        rest,
        stiffness: 8.0,
        damping: 1.0,
    }))
    .with_plasticity(PLASTICITY);
    let positions = [Vector3::zeros(), Vector3::x() * 1.5];
    let mut internal = springs.initial_internal();
    assert_eq!(internal, [1.0, 1.45, 1.0, 1.0]);
    assert!(springs.flow(&positions, &mut internal, 0.2), "it hardens");
    let end = 1.5 / 1.1;
    let expected = end + (1.0 - end) * libm::exp(-2.0 * 1.1 * 0.2);
    assert!((internal[0] - expected).abs() < 1e-15);
    assert_eq!((internal[1], internal[3]), (1.45, 1.0));
    assert!((internal[2] - (1.0 + 3.0 * (expected - 1.0))).abs() < 1e-14);
    // The energy is that of the new rest value and stiffness.
    let at = Configuration {
        positions: &positions,
        velocities: &positions,
        internal: &internal,
    };
    let c = 1.5 - expected;
    let other = 0.5 * 8.0 * 0.05 * 0.05;
    assert!((springs.energy(&at) - 0.5 * 8.0 * internal[2] * c * c - other).abs() < 1e-14);
}

/// At a corner that is at rest the matrix is k g gᵀ: norms and traces of its blocks are those given without it.
fn check_rest<M: Measure<N>, const N: usize>() {
    let mut next = numbers();
    let positions = cloud(6, &mut next);
    let mut set = set::<M, N>(&mut next, 0.0);
    for (nodes, rest) in set.nodes.iter().zip(&mut set.rest) {
        *rest = M::value(nodes.map(|node| &positions[node as usize]));
    }
    let at = Configuration {
        positions: &positions,
        velocities: &positions,
        internal: &[],
    };
    let (mut norms, mut traces, mut matrix) = (Vec::new(), Vec::new(), ElementMatrix::new());
    for element in 0..set.count() {
        set.rest_norms(element, &positions, &mut norms);
        set.rest_traces(element, &positions, &mut traces);
        set.stiffness(element, &at, Tangent::Exact, &mut matrix);
        let largest = norms.iter().copied().fold(0.0, f64::max);
        assert_eq!((norms.len(), traces.len()), (N * N, N));
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            assert!((norms[i * N + j] - matrix.block(i, j).norm()).abs() <= 1e-12 * largest);
        }
        for (i, trace) in traces.iter().enumerate() {
            assert!((trace - matrix.block(i, i).trace()).abs() <= 1e-12 * largest);
        }
    }
}

#[test]
fn norms_and_traces_at_rest_are_those_of_the_matrices() {
    check_rest::<Length, 2>();
    check_rest::<Area, 3>();
    check_rest::<Volume, 4>();
}

#[test]
fn factors_scale_stiffness_and_damping() {
    let mut next = numbers();
    let set = set::<Length, 2>(&mut next, 1.0);
    let mut scaled = set.clone();
    for (element, factor) in [1.0, 0.5, 0.25].into_iter().enumerate() {
        scaled.scale(element, factor);
        assert_eq!(scaled.stiffness[element], factor * set.stiffness[element]);
        assert_eq!(scaled.damping[element], factor * set.damping[element]);
    }
}

#[test]
fn a_projection_solves_the_linear_spring_exactly() {
    // One implicit step of x'' = −k x − k_d x' with m = 2 from rest at x = 0.3, in closed form; the constraint is linear in x.
    let (k, k_d, m, h, x) = (50.0, 3.0, 2.0, 0.1, 0.3);
    let spring = Springs::new([Constraint {
        nodes: [0, 1],
        rest: 1.0,
        stiffness: k,
        damping: k_d,
    }]);
    let previous = [Vector3::zeros(), Vector3::x() * (1.0 + x)];
    let mut positions = previous;
    let constraints = spring.constraints().unwrap();
    constraints.project(
        0,
        &mut positions,
        &previous,
        &[0.0, 1.0 / m],
        &[],
        &mut [0.0],
        h,
    );
    // m (x' − x) = −h² k x' − h k_d (x' − x)
    let expected = (m + h * k_d) * x / (m + h * k_d + h * h * k);
    assert!((positions[1].x - 1.0 - expected).abs() < 1e-15);
    assert_eq!(positions[0], previous[0]);
}
