//! Gershgorin's bound of the largest eigenvalue of M⁻¹K and M⁻¹D (NUMERICS 3.2).

use crate::elements::{Configuration, ElementMatrix, Tangent};
use crate::model::TissueModel;
use crate::state::State;
use nalgebra::Vector3;

/// Which matrix of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The stiffness K.
    Stiffness,
    /// The damping matrix D of Kelvin–Voigt viscosity.
    Damping,
}

/// Upper bound of the largest eigenvalue of M⁻¹K \[1/s²\] or M⁻¹D \[1/s\] at rest: the largest over the free nodes of S_i/m_i,
/// S_i = Σ_e Σ_j ‖K^e_ij‖ (Frobenius). For an element ½ k C² the terms are k |g_i| |g_j|: this is (G) of NUMERICS 3.2.
/// Clamped nodes do not move: they have no row and no column.
pub fn gershgorin_bound(model: &TissueModel, part: Part) -> f64 {
    gershgorin_bound_at(model, &State::at_rest(model), part)
}

/// [`gershgorin_bound`] at the positions and internal variables of `state`; it bounds the sizes of negative eigenvalues too.
pub fn gershgorin_bound_at(model: &TissueModel, state: &State, part: Part) -> f64 {
    let sums = row_sums(model, state, part);
    let bounds = sums.iter().zip(model.inverse_masses()).map(|(s, w)| s * w);
    bounds.fold(0.0, f64::max)
}

impl TissueModel {
    /// A bound of λ_max at rest \[1/s²\], that of Gershgorin: how fast the body answers. Edits leave it what it was at the start, as the
    /// characteristic length.
    pub(crate) fn rate_bound(&self) -> f64 {
        *self
            .rate_bound
            .get_or_init(|| gershgorin_bound(self, Part::Stiffness))
    }
}

/// S_i of every node \[N/m or N·s/m\].
pub(crate) fn row_sums(model: &TissueModel, state: &State, part: Part) -> Vec<f64> {
    let w = model.inverse_masses();
    let mut sums = vec![0.0; model.node_count()];
    each_matrix(model, state, part, |nodes, matrix| {
        for (i, &row) in nodes.iter().enumerate() {
            for (j, &column) in nodes.iter().enumerate() {
                if w[column as usize] > 0.0 {
                    sums[row as usize] += matrix.block(i, j).norm();
                }
            }
        }
    });
    sums
}

/// Calls `visit` with nodes and matrix of every element, set after set in ascending order.
pub(crate) fn each_matrix(
    model: &TissueModel,
    state: &State,
    part: Part,
    mut visit: impl FnMut(&[u32], &ElementMatrix),
) {
    let still = vec![Vector3::zeros(); model.node_count()];
    let mut matrix = ElementMatrix::new();
    for (index, set) in model.sets().iter().enumerate() {
        if part == Part::Damping && !set.is_viscous() {
            continue;
        }
        let at = Configuration {
            velocities: &still,
            ..state.configuration(model, index)
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
