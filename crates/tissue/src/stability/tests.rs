//! Bounds against dense eigenvalues, closed forms, the check after hardening, remedies.

use super::*;
use crate::elements::{Constraint, Springs};
use crate::testing::{build, soft_block};
use nalgebra::DMatrix;
use std::sync::Arc;

fn block(cells: [usize; 3], clamp: bool) -> TissueModel {
    build(&soft_block(cells), |p| clamp && p.x < -0.9e-3)
}

/// λ_max of the assembled M^-½ K M^-½ by a dense eigen-solve.
fn dense_lambda(model: &TissueModel) -> f64 {
    let n = model.node_count();
    let mut k = DMatrix::<f64>::zeros(3 * n, 3 * n);
    each_matrix(
        model,
        &State::at_rest(model),
        Part::Stiffness,
        |nodes, matrix| {
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
        },
    );
    k.symmetric_eigenvalues().max()
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
