//! How large a step may be.
//!
//! For M x'' + K x = 0 Störmer–Verlet is stable while h·√λ_max < 2, λ_max the largest eigenvalue of M⁻¹K; the exact drag
//! factor does not lower the limit (NUMERICS 3.1). λ_max is that of the rest shape; finite deformation is covered by the
//! safety factor (NUMERICS 3.1: at 0.6 random offsets of 20 % of a cell stay bounded).

use crate::elements::{Configuration, ElementMatrix, Tangent};
use crate::model::TissueModel;
use nalgebra::{Matrix3, Vector3};

/// Recommended share of the stability limit (NUMERICS 3.1).
pub const SAFETY: f64 = 0.6;

/// Steps of the power iteration in [`stable_step`]. From 20 on the estimate stays within 3 % of λ_max (NUMERICS 3.2).
const POWER_STEPS: usize = 40;

/// The power iteration approaches λ_max from below; this factor covers what is missing (NUMERICS 3.2).
const POWER_MARGIN: f64 = 1.1;

/// Which matrix of the rest shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The stiffness K.
    Stiffness,
    /// The damping matrix D of Kelvin–Voigt viscosity.
    Damping,
}

/// Upper bound of the largest eigenvalue of M⁻¹K [1/s²] or M⁻¹D [1/s]: the largest over the free nodes of S_i/m_i, S_i = Σ_e
/// Σ_j ‖K^e_ij‖ (Frobenius). For an element ½ k C² the terms are k |g_i| |g_j|: this is (G) of NUMERICS 3.2. Clamped nodes do
/// not move: they have no row and no column.
pub fn gershgorin_bound(model: &TissueModel, part: Part) -> f64 {
    let w = model.inverse_masses();
    let mut sums = vec![0.0; model.node_count()];
    each_matrix(model, part, |nodes, matrix| {
        for (i, &row) in nodes.iter().enumerate() {
            for (j, &column) in nodes.iter().enumerate() {
                if w[column as usize] > 0.0 {
                    sums[row as usize] += matrix.block(i, j).norm();
                }
            }
        }
    });
    sums.iter().zip(w).map(|(s, w)| s * w).fold(0.0, f64::max)
}

/// Largest eigenvalue of M⁻¹K [1/s²] or M⁻¹D [1/s] at rest by `steps` steps of power iteration, from below.
pub fn power_iteration(model: &TissueModel, part: Part, steps: usize) -> f64 {
    let w = model.inverse_masses();
    // Fixed numbers without symmetry, so that no eigenvector is missed.
    let mut seed = 1u64;
    let mut next = || {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut x: Vec<Vector3<f64>> = w
        .iter()
        .map(|&w| {
            let direction = Vector3::new(next(), next(), next());
            if w > 0.0 { direction } else { Vector3::zeros() }
        })
        .collect();
    let mut entries: Vec<([u32; 2], Matrix3<f64>)> = Vec::new();
    each_matrix(model, part, |nodes, matrix| {
        for (i, &row) in nodes.iter().enumerate() {
            for (j, &column) in nodes.iter().enumerate() {
                entries.push(([row, column], *matrix.block(i, j)));
            }
        }
    });
    let mut lambda = 0.0;
    for _ in 0..steps {
        // y = K x, Rayleigh quotient x·Kx / x·Mx, then x = M⁻¹ y, scaled.
        let mut y = vec![Vector3::zeros(); x.len()];
        for ([row, column], block) in &entries {
            y[*row as usize] += block * x[*column as usize];
        }
        let (mut xkx, mut xmx, mut size) = (0.0, 0.0, 0.0f64);
        for (i, &w) in w.iter().enumerate() {
            if w > 0.0 {
                xkx += x[i].dot(&y[i]);
                xmx += x[i].norm_squared() / w;
            }
            x[i] = y[i] * w;
            size = size.max(x[i].amax());
        }
        if xmx == 0.0 || size == 0.0 {
            return 0.0;
        }
        lambda = xkx / xmx;
        x.iter_mut().for_each(|v| *v /= size);
    }
    lambda
}

/// The longest step [s] at the share `safety` of the stability limit of explicit methods that take viscous forces from a known
/// velocity: h²λ + 2hΛ = 4·safety² (NUMERICS 3.1, q < 4 − 2δ), λ and Λ of stiffness and damping the smaller of the Gershgorin
/// bound and the estimate by power iteration with its margin. Infinite for a body without stiffness or without a free node.
pub fn stable_step(model: &TissueModel, safety: f64) -> f64 {
    let largest = |part| {
        let estimate = POWER_MARGIN * power_iteration(model, part, POWER_STEPS);
        gershgorin_bound(model, part).min(estimate)
    };
    let viscous = model.sets().iter().any(|set| set.is_viscous());
    let damping = if viscous { largest(Part::Damping) } else { 0.0 };
    let stiffness = largest(Part::Stiffness);
    // The positive root, in the form that does not cancel.
    let room = 4.0 * safety * safety;
    room / (damping + (damping * damping + room * stiffness).sqrt())
}

/// Calls `visit` with nodes and matrix of every element of the rest shape, set after set in ascending order.
fn each_matrix(model: &TissueModel, part: Part, mut visit: impl FnMut(&[u32], &ElementMatrix)) {
    let still = vec![Vector3::zeros(); model.node_count()];
    let mut matrix = ElementMatrix::new();
    for set in model.sets() {
        let internal = set.initial_internal();
        let at = Configuration {
            positions: model.rest_positions(),
            velocities: &still,
            internal: &internal,
        };
        for element in 0..set.count() {
            match part {
                Part::Stiffness => set.stiffness(element, &at, Tangent::Exact, &mut matrix),
                Part::Damping => set.damping(element, &at, &mut matrix),
            }
            visit(set.nodes(element), &matrix);
        }
    }
}

#[cfg(test)]
mod tests {
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
        each_matrix(model, Part::Stiffness, |nodes, matrix| {
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
}
