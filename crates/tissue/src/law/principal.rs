//! The tangent of an isotropic law in the axes of the principal stretches, and its nearest positive form.
//!
//! With F = U diag(σ) Vᵀ, δP = U T(Uᵀ δF V) Vᵀ. At a diagonal F isotropy leaves of the 81 entries of T only a 3×3 block of the
//! stretches and, for each pair of axes, a 2×2 block [[a, b], [b, a]] of the shears (Sifakis & Barbič 2012; Smith, de Goes, Kim
//! 2019). Its eigenvalues are cut off at zero block by block, which gives the nearest tangent without negative ones.

use super::Matrix9;
use super::decomposition::{SignedSvd, symmetric_eigen};
use nalgebra::{Matrix3, Vector3};

/// The pairs of axes, in the order of the entries of a shear.
const PAIRS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// T [Pa].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalTangent {
    /// ∂P_ii/∂F_jj.
    pub stretch: Matrix3<f64>,
    /// ∂P_ij/∂F_ij = ∂P_ji/∂F_ji of the pairs (2,3), (3,1), (1,2).
    pub direct: [f64; 3],
    /// ∂P_ij/∂F_ji of the same pairs.
    pub crossed: [f64; 3],
}

impl PrincipalTangent {
    /// The entries of ∂P/∂F at a diagonal F.
    pub fn from_tangent(tangent: &Matrix9) -> Self {
        let entry = |i: usize, j: usize, k: usize, l: usize| tangent[(i + 3 * j, k + 3 * l)];
        Self {
            stretch: Matrix3::from_fn(|i, j| entry(i, i, j, j)),
            direct: PAIRS.map(|[i, j]| entry(i, j, i, j)),
            crossed: PAIRS.map(|[i, j]| entry(i, j, j, i)),
        }
    }

    /// The nearest one without negative eigenvalues.
    pub fn positive(&self) -> Self {
        let stretch = if is_positive(&self.stretch) {
            self.stretch
        } else {
            let (values, vectors) = symmetric_eigen(&self.stretch);
            let cut = Matrix3::from_diagonal(&values.map(|value| value.max(0.0)));
            vectors * cut * vectors.transpose()
        };
        let (mut direct, mut crossed) = (self.direct, self.crossed);
        for (a, b) in direct.iter_mut().zip(&mut crossed) {
            let (sum, difference) = ((*a + *b).max(0.0), (*a - *b).max(0.0));
            (*a, *b) = (0.5 * (sum + difference), 0.5 * (sum - difference));
        }
        Self {
            stretch,
            direct,
            crossed,
        }
    }

    /// The 3×3 block Σ_jl T_ijkl a_j b_l: what a displacement of the node with the gradient `b` does to the force on the one
    /// with the gradient `a`, both in principal axes.
    #[inline]
    pub fn block(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
        let mut block = Matrix3::from_fn(|i, k| self.stretch[(i, k)] * a[i] * b[k]);
        for ([i, j], (direct, crossed)) in
            PAIRS.into_iter().zip(self.direct.iter().zip(&self.crossed))
        {
            block[(i, i)] += direct * a[j] * b[j];
            block[(j, j)] += direct * a[i] * b[i];
            block[(i, j)] += crossed * a[j] * b[i];
            block[(j, i)] += crossed * a[i] * b[j];
        }
        block
    }

    /// ∂P/∂F at F = U diag(σ) Vᵀ.
    pub fn rotated(&self, svd: &SignedSvd) -> Matrix9 {
        let gradients: [Vector3<f64>; 3] = [0, 1, 2].map(|j| svd.v.row(j).transpose());
        let mut tangent = Matrix9::zeros();
        for j in 0..3 {
            for l in 0..3 {
                let block = svd.u * self.block(&gradients[j], &gradients[l]) * svd.u.transpose();
                tangent
                    .fixed_view_mut::<3, 3>(3 * j, 3 * l)
                    .copy_from(&block);
            }
        }
        tangent
    }
}

/// Whether a symmetric matrix has positive eigenvalues only (Sylvester): saves the common case the eigenvalues.
fn is_positive(m: &Matrix3<f64>) -> bool {
    let minor = m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(0, 1)];
    m[(0, 0)] > 0.0 && minor > 0.0 && m.determinant() > 0.0
}
