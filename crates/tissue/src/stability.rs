//! How large a step may be.
//!
//! For M x'' + K x = 0 Störmer–Verlet is stable while h·√λ_max < 2, λ_max the largest eigenvalue of M⁻¹K; the exact drag
//! factor does not lower the limit (NUMERICS 3.1). λ_max is that of the rest shape; finite deformation is covered by the
//! safety factor (NUMERICS 3.1: at 0.6 random offsets of 20 % of a cell stay bounded).

use crate::energies::volume_derivative;
use crate::model::TissueModel;
use nalgebra::Vector3;

/// Recommended share of the stability limit (NUMERICS 3.1).
pub const SAFETY: f64 = 0.6;

/// Steps of the power iteration in [`stable_step`]. From 20 on the estimate stays within 3 % of λ_max (NUMERICS 3.2).
const POWER_STEPS: usize = 40;

/// The power iteration approaches λ_max from below; this factor covers what is missing (NUMERICS 3.2).
const POWER_MARGIN: f64 = 1.1;

/// Upper bound of λ_max [1/s²]: max over the free nodes of S_i/m_i, S_i = Σ_c k_c |g_ci| Σ_j |g_cj| (G of NUMERICS 3.2).
/// Clamped nodes do not move: they have no row and no column.
pub fn gershgorin_bound(model: &TissueModel) -> f64 {
    let w = model.inverse_masses();
    let free = |node: u32| if w[node as usize] > 0.0 { 1.0 } else { 0.0 };
    let mut sums = vec![0.0; model.node_count()];
    for spring in model.springs() {
        // |g| = 1 at both ends.
        let total = free(spring.nodes[0]) + free(spring.nodes[1]);
        for node in spring.nodes {
            sums[node as usize] += spring.stiffness * total;
        }
    }
    for (element, gradients) in rest_gradients(model) {
        let volume = &model.volumes()[element];
        let total: f64 = (0..4)
            .map(|k| free(volume.nodes[k]) * gradients[k].norm())
            .sum();
        for (node, g) in volume.nodes.iter().zip(&gradients) {
            sums[*node as usize] += volume.stiffness * g.norm() * total;
        }
    }
    sums.iter().zip(w).map(|(s, w)| s * w).fold(0.0, f64::max)
}

/// λ_max [1/s²] of the rest shape by `steps` steps of power iteration, from below.
pub fn power_iteration(model: &TissueModel, steps: usize) -> f64 {
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
    let gradients: Vec<_> = rest_gradients(model).map(|(_, g)| g).collect();
    let mut lambda = 0.0;
    for _ in 0..steps {
        // y = K x, Rayleigh quotient x·Kx / x·Mx, then x = M⁻¹ y, scaled.
        let mut y = vec![Vector3::zeros(); x.len()];
        for spring in model.springs() {
            let [i, j] = spring.nodes.map(|n| n as usize);
            let direction =
                (model.rest_positions()[j] - model.rest_positions()[i]) / spring.rest_length;
            let force = direction * (spring.stiffness * direction.dot(&(x[j] - x[i])));
            y[i] -= force;
            y[j] += force;
        }
        for (volume, g) in model.volumes().iter().zip(&gradients) {
            let nodes = volume.nodes.map(|n| n as usize);
            let rate: f64 = (0..4).map(|k| g[k].dot(&x[nodes[k]])).sum();
            for k in 0..4 {
                y[nodes[k]] += g[k] * (volume.stiffness * rate);
            }
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

/// The longest step [s] at the share `safety` of the stability limit: 2·safety/√λ, λ the smaller of the Gershgorin bound
/// and the estimate by power iteration with its margin. Infinite for a body without stiffness or without a free node.
pub fn stable_step(model: &TissueModel, safety: f64) -> f64 {
    let lambda = gershgorin_bound(model).min(POWER_MARGIN * power_iteration(model, POWER_STEPS));
    2.0 * safety / lambda.sqrt()
}

/// Gradients of the volume of each element at rest [m²].
fn rest_gradients(model: &TissueModel) -> impl Iterator<Item = (usize, [Vector3<f64>; 4])> {
    model.volumes().iter().enumerate().map(|(element, volume)| {
        let corners = volume
            .nodes
            .map(|node| &model.rest_positions()[node as usize]);
        (element, volume_derivative(corners))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{SpringVolume, SpringVolumeSpec};
    use crate::model::Spring;
    use microsim_mesh::Block;
    use nalgebra::DMatrix;

    fn block(cells: [usize; 3], clamp: bool) -> TissueModel {
        let mesh = Block {
            center: [0.0; 3],
            size: [2e-3, 2e-3, 1e-3],
            cells,
        }
        .mesh()
        .unwrap();
        let spec = SpringVolumeSpec {
            stretch_modulus: 25e3,
            volume_modulus: 5e4,
            density: 1060.0,
            drag: 0.0,
        };
        let clamped: Vec<bool> = mesh
            .positions
            .iter()
            .map(|p| clamp && p.x < -0.9e-3)
            .collect();
        TissueModel::new(&mesh, &SpringVolume::from_moduli(spec).unwrap(), &clamped).unwrap()
    }

    /// λ_max of the assembled M^-½ K M^-½ by a dense eigen-solve.
    fn dense_lambda(model: &TissueModel) -> f64 {
        let n = model.node_count();
        let mut k = DMatrix::<f64>::zeros(3 * n, 3 * n);
        let mut add = |nodes: &[u32], g: &[Vector3<f64>], stiffness: f64| {
            for (a, ga) in nodes.iter().zip(g) {
                for (b, gb) in nodes.iter().zip(g) {
                    let root = (model.inverse_masses()[*a as usize]
                        * model.inverse_masses()[*b as usize])
                        .sqrt();
                    for r in 0..3 {
                        for c in 0..3 {
                            k[(3 * *a as usize + r, 3 * *b as usize + c)] +=
                                stiffness * ga[r] * gb[c] * root;
                        }
                    }
                }
            }
        };
        for s in model.springs() {
            let [i, j] = s.nodes.map(|i| model.rest_positions()[i as usize]);
            let u = (j - i) / s.rest_length;
            add(&s.nodes, &[-u, u], s.stiffness);
        }
        for (element, g) in rest_gradients(model) {
            let volume = &model.volumes()[element];
            add(&volume.nodes, &g, volume.stiffness);
        }
        k.symmetric_eigenvalues().max()
    }

    #[test]
    fn the_bound_is_above_and_the_power_iteration_just_below_the_true_value() {
        for (cells, clamp) in [([2, 2, 1], false), ([2, 2, 2], true), ([4, 2, 1], true)] {
            let model = block(cells, clamp);
            let exact = dense_lambda(&model);
            let bound = gershgorin_bound(&model);
            let estimate = power_iteration(&model, POWER_STEPS);
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

    #[test]
    fn one_oscillator_has_the_known_limit() {
        // A mass on a spring to a fixed point: λ = k/m, and (G) is exact.
        let spring = Spring {
            nodes: [0, 1],
            rest_length: 1.0,
            stiffness: 8.0,
        };
        let positions = vec![Vector3::zeros(), Vector3::x()];
        let model = TissueModel::assemble(
            positions,
            vec![1.0, 2.0],
            &[true, false],
            vec![spring],
            vec![],
            0.0,
        );
        assert_eq!(gershgorin_bound(&model), 4.0);
        assert!((power_iteration(&model, 3) - 4.0).abs() < 1e-14);
        assert_eq!(stable_step(&model, 1.0), 1.0, "h·√λ = 2 at h = 1 s");
    }

    #[test]
    fn a_body_that_cannot_move_has_no_limit() {
        let positions = vec![Vector3::zeros(), Vector3::x()];
        let spring = Spring {
            nodes: [0, 1],
            rest_length: 1.0,
            stiffness: 8.0,
        };
        let model = TissueModel::assemble(
            positions,
            vec![1.0; 2],
            &[true; 2],
            vec![spring],
            vec![],
            0.0,
        );
        assert_eq!(stable_step(&model, SAFETY), f64::INFINITY);
    }
}
