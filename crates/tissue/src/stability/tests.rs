//! Bounds against dense eigenvalues, closed forms, the check after hardening, remedies.

use super::*;
use crate::elements::{Constraint, Elements, Plasticity, Springs, Volumes};
use crate::executor::Serial;
use crate::flow::flow;
use crate::gershgorin::each_matrix;
use crate::method::Method;
use crate::state::Control;
use crate::testing::{build, soft_block};
use nalgebra::{DMatrix, DVector, Vector3};
use std::sync::Arc;

fn block(cells: [usize; 3], clamp: bool) -> TissueModel {
    build(&soft_block(cells), |p| clamp && p.x < -0.9e-3)
}

fn dense_lambda(model: &TissueModel) -> f64 {
    dense_eigenvalues(model, &State::at_rest(model)).max()
}

/// Eigenvalues of the assembled M^-½ K M^-½ by a dense eigen-solve.
fn dense_eigenvalues(model: &TissueModel, state: &State) -> DVector<f64> {
    let n = model.node_count();
    let mut k = DMatrix::<f64>::zeros(3 * n, 3 * n);
    each_matrix(model, state, Part::Stiffness, |nodes, matrix| {
        for (a, &row) in nodes.iter().enumerate() {
            for (b, &column) in nodes.iter().enumerate() {
                let w = [row, column].map(|node| model.inverse_masses()[node as usize]);
                let root = (w[0] * w[1]).sqrt();
                for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                    k[(3 * row as usize + r, 3 * column as usize + c)] +=
                        matrix.block(a, b)[(r, c)] * root;
                }
            }
        }
    });
    k.symmetric_eigenvalues()
}

#[test]
fn the_bound_is_above_and_the_power_iteration_just_below_the_true_value() {
    for (cells, clamp) in [([2, 2, 1], false), ([2, 2, 2], true), ([4, 2, 1], true)] {
        let model = block(cells, clamp);
        let exact = dense_lambda(&model);
        let bound = gershgorin_bound(&model, Part::Stiffness);
        let estimate = power_iteration(&model, Part::Stiffness, POWER_STEPS);
        assert!(bound >= exact, "{bound} < {exact}");
        assert!(
            bound <= 4.0 * exact,
            "NUMERICS 3.2: the bound is 2.8–3.5 times too large, here {}",
            bound / exact
        );
        assert!(
            estimate <= exact * (1.0 + 1e-10) && estimate * POWER_MARGIN >= exact,
            "{estimate} {exact}"
        );
    }
}

/// A mass of 2 kg on a spring of 8 N/m and 0.5 N·s/m to another one of 1 kg.
fn pair(clamped: [bool; 2], damping: f64) -> TissueModel {
    let spring = Constraint {
        nodes: [0, 1],
        rest: 1.0,
        stiffness: 8.0,
        damping,
    };
    TissueModel::assemble(
        vec![Vector3::zeros(), Vector3::x()],
        vec![1.0, 2.0],
        &clamped,
        vec![],
        1.0,
        vec![Arc::new(Springs::new([spring]))],
        0.0,
    )
}

#[test]
fn one_oscillator_has_the_known_limit() {
    // A mass on a spring to a fixed point: λ = k/m, and (G) is exact.
    let model = pair([true, false], 0.0);
    assert_eq!(gershgorin_bound(&model, Part::Stiffness), 4.0);
    assert!((power_iteration(&model, Part::Stiffness, 3) - 4.0).abs() < 1e-14);
    assert_eq!(stable_step(&model, 1.0), 1.0, "h·√λ = 2 at h = 1 s");
    // With c = k_d/m = ¼ per second: h² 4 + 2 h/4 = 4.
    let step = stable_step(&pair([true, false], 0.5), 1.0);
    assert!((4.0 * step * step + 0.5 * step - 4.0).abs() < 1e-14);
}

#[test]
fn a_body_that_cannot_move_has_no_limit() {
    assert_eq!(stable_step(&pair([true; 2], 0.0), SAFETY), f64::INFINITY);
}

#[test]
fn hardening_shortens_the_step_and_the_check_notices() {
    // Stretched to 1.5 a spring that hardens to four times k, on a mass of 2 kg: the limit halves.
    let plasticity = Plasticity {
        yield_strain: 0.1,
        creep_rate: 50.0,
        max_strain: 1.0,
        hardening: 20.0,
        max_stiffening: 4.0,
    };
    let spring = Constraint {
        nodes: [0, 1],
        rest: 1.0,
        stiffness: 8.0,
        damping: 0.0,
    };
    let set = Springs::new([spring]).with_plasticity(plasticity);
    let model = TissueModel::assemble(
        vec![Vector3::zeros(), Vector3::x()],
        vec![1.0, 2.0],
        &[true, false],
        vec![],
        1.0,
        vec![Arc::new(set)],
        0.0,
    );
    let mut state = State::at_rest(&model);
    let first = stable_step(&model, 1.0);
    assert_eq!(first, 1.0);
    state.positions[1].x = 1.5;
    assert!(flow(&model, &mut state, 1.0), "it has grown stiffer");
    assert!(!flow(&model, &mut state, 1e-9), "and does not grow again");
    assert_eq!(state.internal[1], 4.0);
    let second = stable_step_at(&model, &state, 1.0);
    // The spring is in tension: across it the bound counts a little more.
    assert!(second <= 0.5 && second > 0.49, "{second}");
    // A faint motion along the spring about its new rest length: what the first step breaks, the second does not.
    let size = |h: f64| {
        let mut state = state.clone();
        let rest = state.internal[0];
        state.positions[1].x = rest + 1e-6;
        let mut solver = Method::VelocityVerlet.solver(&model).unwrap();
        let mut largest = 0.0f64;
        for _ in 0..30 {
            let control = Control::default();
            solver
                .step(&model, &mut state, &control, &[], h, &Serial)
                .unwrap();
            largest = largest.max((state.positions[1].x - rest).abs());
        }
        largest
    };
    // h·ω = 3.8 and 1.9; bounded by 1/√(1 − 0.95²) = 3.2 times the start.
    assert!(size(0.95 * first) > 1e-2 && size(0.95 * second) < 3.3e-6);
}

#[test]
fn a_deformed_shape_has_its_own_bound_and_its_own_eigenvalue() {
    let model = block([2, 2, 2], true);
    let mut state = State::at_rest(&model);
    assert_eq!(
        stable_step(&model, SAFETY),
        stable_step_at(&model, &state, SAFETY)
    );
    for p in &mut state.positions {
        p.z *= 0.5;
    }
    let exact = dense_eigenvalues(&model, &state);
    let largest = exact.amax();
    let estimate = power_iteration_at(&model, &state, Part::Stiffness, 200);
    assert!(
        estimate <= largest * (1.0 + 1e-10) && estimate * 1.03 > largest,
        "{estimate} {largest}"
    );
    assert!(gershgorin_bound_at(&model, &state, Part::Stiffness) >= largest);
}

/// A block of which one inner node has moved towards its neighbour by the fraction `close` of the edge, as a cut would leave it;
/// rest lengths and volumes are those of this mesh.
fn sliver(close: f64, factors: Option<Vec<Vec<f64>>>) -> TissueModel {
    let mut mesh = soft_block([3, 3, 3]);
    let edge = mesh.positions[1].x - mesh.positions[0].x;
    mesh.positions[21].x += close * edge;
    let clamped = vec![false; mesh.positions.len()];
    let density = vec![1060.0; mesh.tets.len()];
    let springs = mesh.edges().into_iter().map(|nodes| {
        let [i, j] = nodes.map(|node| mesh.positions[node as usize]);
        let rest = (j - i).norm();
        // Plain constants: a short spring is as stiff as a long one.
        Constraint {
            nodes,
            rest,
            stiffness: 10.0,
            damping: 0.0,
        }
    });
    let volumes = mesh
        .tets
        .iter()
        .zip(mesh.volumes())
        .map(|(nodes, rest)| Constraint {
            nodes: *nodes,
            rest,
            stiffness: 5e4 / rest,
            damping: 0.0,
        });
    let (mut springs, mut volumes) = (Springs::new(springs), Volumes::new(volumes));
    if let Some(factors) = factors {
        let of = |set: usize| factors[set].iter().copied().enumerate();
        of(0).for_each(|(element, factor)| springs.scale(element, factor));
        of(1).for_each(|(element, factor)| volumes.scale(element, factor));
    }
    let sets: Vec<Arc<dyn Elements>> = vec![Arc::new(springs), Arc::new(volumes)];
    TissueModel::new(&mesh, &density, &clamped, sets, 0.0).unwrap()
}

#[test]
fn mass_floor_and_stiffness_cap_make_a_given_step_stable() {
    // A step that would do for the block without its sliver, s = 0.6.
    let (model, s) = (sliver(0.99, None), 0.6);
    let state = State::at_rest(&model);
    let whole = sliver(0.0, None);
    let h = 2.0 * s / gershgorin_bound(&whole, Part::Stiffness).sqrt();
    let limit = |model: &TissueModel| {
        h * dense_eigenvalues(model, &State::at_rest(model))
            .max()
            .sqrt()
    };
    assert!(limit(&model) > 2.0, "{}", limit(&model));
    let added = mass_floor(&model, &state, h, s);
    let floored = model.clone().with_added_inertia(added.clone());
    let capped = sliver(0.99, Some(stiffness_cap(&model, &state, h, s)));
    for remedied in [&floored, &capped] {
        // NUMERICS 3.5: below 2 s by Gershgorin, and not by far more than it is pessimistic.
        let limit = limit(remedied);
        assert!(limit <= 2.0 * s && limit > 0.25 * 2.0 * s, "{limit}");
        let mut state = State::at_rest(remedied);
        state.positions[21] *= 1.0 + 1e-6;
        let mut solver = Method::StoermerVerlet.solver(remedied).unwrap();
        for _ in 0..2000 {
            let control = Control::default();
            solver
                .step(remedied, &mut state, &control, &[], h, &Serial)
                .unwrap();
        }
        let moved = state
            .positions
            .iter()
            .zip(remedied.rest_positions())
            .map(|(p, r)| (p - r).norm());
        assert!(moved.fold(0.0, f64::max) < 1e-7 * model.mean_edge_length().max(1.0));
    }
    // Neither touches what needs nothing, and masses stay.
    let grown = added.iter().filter(|added| **added > 0.0).count();
    assert!(added.iter().all(|added| *added >= 0.0));
    assert_eq!(floored.masses(), model.masses());
    assert!(grown > 0 && grown < model.node_count() / 2, "{grown}");
    let none = mass_floor(&model, &state, 0.1 * h, s);
    assert!(none.iter().all(|added| *added == 0.0));
    assert!(
        stiffness_cap(&model, &state, 0.1 * h, s)
            .iter()
            .flatten()
            .all(|f| *f == 1.0)
    );
}

/// The largest displacement from rest, over that at the start, of a mass that a floor at this fraction of the limit has made heavier, in 2,000 steps; it hangs
/// on a spring so stiff that it needs one, with these damping \[N·s/m\] and drag \[1/s\]. Of one oscillator Gershgorin's bound is exact.
fn growth(method: &Method, damping: f64, drag: f64, safety: f64) -> f64 {
    let (h, start) = (2.0, 1e-9);
    let mut model = pair([true, false], damping);
    model.drags = vec![(0..2, drag)];
    let remedied = floor_nodes(&mut model, &[0, 1], method, h, safety);
    assert!(remedied.nodes == 1 && remedied.added > 0.0);
    let mut state = State::at_rest(&model);
    state.positions[1].x += start;
    let mut solver = method.solver(&model).unwrap();
    let mut largest = 0.0_f64;
    for _ in 0..2000 {
        let control = Control::default();
        let step = solver.step(&model, &mut state, &control, &[], h, &Serial);
        largest = largest.max((state.positions[1].x - 1.0).abs() / start);
        if step.is_err() || largest > 1e3 {
            break;
        }
    }
    largest
}

/// The floor of each method holds it and goes no further: 2 % within the limit it stays bounded, 2 % beyond it does not.
#[test]
fn the_floor_of_a_method_is_at_its_own_limit() {
    let cases = [
        (Method::StoermerVerlet, 0.0, 0.4),
        (Method::StoermerVerlet, 8.0, 0.4),
        (Method::SymplecticEuler, 0.0, 0.4),
        (Method::SymplecticEuler, 8.0, 0.4),
        (Method::VelocityVerlet, 0.0, 0.4),
        (Method::VelocityVerlet, 8.0, 0.0),
        (Method::VelocityVerletLagged, 0.0, 0.0),
        (Method::VelocityVerletLagged, 0.0, 0.1),
        (Method::VelocityVerletLagged, 8.0, 0.1),
    ];
    for (method, damping, drag) in cases {
        let growths = [0.98, 1.02].map(|safety| growth(&method, damping, drag, safety));
        assert!(
            growths[0] < 1e2 && growths[1] > 1e3,
            "{method:?}, {damping} N·s/m, {drag}/s: {growths:?}"
        );
    }
}

#[test]
fn delingettes_estimate_is_far_below_the_limit_of_one_oscillator() {
    // NUMERICS 3.3: 4m/h² over m/(π² h²) is 4π² = 39.5.
    let (mass, h) = (2e-3, 1e-4);
    let ratio = 4.0 * mass / (h * h) / delingette_stiffness(mass, h);
    assert!((ratio - 39.478).abs() < 1e-3);
}
