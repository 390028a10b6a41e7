//! The tangent of an isotropic law in the axes of the principal stretches, and its nearest positive form.
//!
//! With F = U diag(σ) Vᵀ, δP = U T(Uᵀ δF V) Vᵀ. At a diagonal F isotropy leaves of the 81 entries of T only a 3×3 block of the
//! stretches and, for each pair of axes, a 2×2 block [[a, b], [b, a]] of the shears (Sifakis & Barbič 2012; Smith, de Goes, Kim
//! 2019). Its eigenvalues are cut off at zero block by block, which gives the nearest tangent without negative ones.

use super::decomposition::{SignedSvd, symmetric_eigen};
use super::elasticity::Matrix9;
use nalgebra::Matrix3;

/// The pairs of axes, in the order of the entries of a shear.
const PAIRS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// Tangent ∂P/∂F \[Pa\] of an isotropic law at F = diag(σ), without the entries that are zero by isotropy.
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

    /// ∂P/∂F at F = U diag(σ) Vᵀ: Σ T_abcd Q_ab ⊗ Q_cd with Q_ab the outer product of the axes a of U and b of V.
    pub fn rotated(&self, svd: &SignedSvd) -> Matrix9 {
        let axes = |a: usize, b: usize| Deformation::outer(&svd.u, a, &svd.v, b);
        let stretches = [axes(0, 0), axes(1, 1), axes(2, 2)];
        let mut pairs = [(Deformation::ZERO, Deformation::ZERO); 9];
        for (k, stretch) in stretches.iter().enumerate() {
            let mut image = stretches[0].scaled(self.stretch[(0, k)]);
            image.add(&stretches[1], self.stretch[(1, k)]);
            image.add(&stretches[2], self.stretch[(2, k)]);
            pairs[k] = (*stretch, image);
        }
        for (k, [i, j]) in PAIRS.into_iter().enumerate() {
            let (one, other) = (axes(i, j), axes(j, i));
            for (place, a, b) in [(3 + k, one, other), (6 + k, other, one)] {
                let mut image = a.scaled(self.direct[k]);
                image.add(&b, self.crossed[k]);
                pairs[place] = (a, image);
            }
        }
        let mut tangent = Matrix9::zeros();
        for (q, out) in tangent.as_mut_slice().chunks_exact_mut(9).enumerate() {
            let mut column = Deformation::ZERO;
            for (deformation, image) in &pairs {
                column.add(deformation, image.0[q]);
            }
            out.copy_from_slice(&column.0);
        }
        tangent
    }
}

/// A change of F, column after column.
#[derive(Clone, Copy)]
struct Deformation([f64; 9]);

impl Deformation {
    const ZERO: Self = Self([0.0; 9]);

    /// Column `a` of `u` times column `b` of `v`.
    #[inline(always)]
    fn outer(u: &Matrix3<f64>, a: usize, v: &Matrix3<f64>, b: usize) -> Self {
        let mut entries = [0.0; 9];
        for (p, entry) in entries.iter_mut().enumerate() {
            *entry = u[(p % 3, a)] * v[(p / 3, b)];
        }
        Self(entries)
    }

    #[inline(always)]
    fn scaled(mut self, factor: f64) -> Self {
        self.0.iter_mut().for_each(|entry| *entry *= factor);
        self
    }

    #[inline(always)]
    fn add(&mut self, other: &Self, factor: f64) {
        for (entry, other) in self.0.iter_mut().zip(&other.0) {
            *entry += other * factor;
        }
    }
}

/// Whether a symmetric matrix has positive eigenvalues only (Sylvester): saves the common case the eigenvalues.
fn is_positive(m: &Matrix3<f64>) -> bool {
    let minor = m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(0, 1)];
    m[(0, 0)] > 0.0 && minor > 0.0 && m.determinant() > 0.0
}
