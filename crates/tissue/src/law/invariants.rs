//! Laws of the form Ψ = a(I) + b(J), I = tr FᵀF, J = det F: stress and tangent from the derivatives of a and b.

use super::Matrix9;
use nalgebra::{Matrix3, Vector3};

/// Derivatives of a and b at some F [Pa].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvariantDerivatives {
    /// a'.
    pub a1: f64,
    /// a''.
    pub a2: f64,
    /// b'.
    pub b1: f64,
    /// b''.
    pub b2: f64,
}

/// P = 2a' F + b' cof F.
#[inline]
pub(super) fn stress(f: &Matrix3<f64>, cofactor: &Matrix3<f64>, a1: f64, b1: f64) -> Matrix3<f64> {
    f * (2.0 * a1) + cofactor * b1
}

/// ∂P/∂F = 2a' 1 + 4a'' F⊗F + b'' cof⊗cof + b' ∂cof/∂F.
#[inline]
pub(super) fn tangent(
    f: &Matrix3<f64>,
    cofactor: &Matrix3<f64>,
    d: &InvariantDerivatives,
) -> Matrix9 {
    let (f_entries, c_entries) = (f.as_slice(), cofactor.as_slice());
    let mut tangent = Matrix9::zeros();
    for q in 0..9 {
        let (along_f, along_c) = (4.0 * d.a2 * f_entries[q], d.b2 * c_entries[q]);
        for p in 0..9 {
            tangent[(p, q)] = f_entries[p] * along_f + c_entries[p] * along_c;
        }
        tangent[(q, q)] += 2.0 * d.a1;
    }
    // ∂cof_ij/∂F_kl = ε_ikm ε_jln F_mn.
    for j in 0..3 {
        for (l, n, sign_columns) in [
            (((j + 1) % 3), ((j + 2) % 3), 1.0),
            (((j + 2) % 3), ((j + 1) % 3), -1.0),
        ] {
            for i in 0..3 {
                let (next, last) = ((i + 1) % 3, (i + 2) % 3);
                let factor = sign_columns * d.b1;
                tangent[(i + 3 * j, next + 3 * l)] += factor * f[(last, n)];
                tangent[(i + 3 * j, last + 3 * l)] -= factor * f[(next, n)];
            }
        }
    }
    tangent
}

impl InvariantDerivatives {
    /// All of them times `factor`.
    #[inline(always)]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            a1: factor * self.a1,
            a2: factor * self.a2,
            b1: factor * self.b1,
            b2: factor * self.b2,
        }
    }

    /// The 3×3 block Σ_jl ∂P_ij/∂F_kl b_j c_l: what a displacement of the node with the gradient `c` does to the force on the
    /// one with the gradient `b`, from `fb` = F b, `cb` = (cof F) b and the same of `c`. With cof F (u × v) = Fu × Fv the part
    /// of ∂cof/∂F is the cross product with −F (b × c).
    #[inline(always)]
    pub fn block(
        &self,
        f: &Matrix3<f64>,
        [b, fb, cb]: &[Vector3<f64>; 3],
        [c, fc, cc]: &[Vector3<f64>; 3],
    ) -> Matrix3<f64> {
        let across = b.cross(c) * self.b1;
        let w = [0, 1, 2]
            .map(|i| f[(i, 0)] * across[0] + f[(i, 1)] * across[1] + f[(i, 2)] * across[2]);
        let round = 2.0 * self.a1 * (b[0] * c[0] + b[1] * c[1] + b[2] * c[2]);
        let (along_f, along_c) = (fc * (4.0 * self.a2), cc * self.b2);
        let outer = |i: usize, k: usize| fb[i] * along_f[k] + cb[i] * along_c[k];
        Matrix3::new(
            outer(0, 0) + round,
            outer(0, 1) + w[2],
            outer(0, 2) - w[1],
            outer(1, 0) - w[2],
            outer(1, 1) + round,
            outer(1, 2) + w[0],
            outer(2, 0) + w[1],
            outer(2, 1) - w[0],
            outer(2, 2) + round,
        )
    }
}
