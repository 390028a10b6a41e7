//! Laws of the form Ψ = a(I) + b(J), I = tr FᵀF, J = det F: stress and tangent from the derivatives of a and b.

use super::Matrix9;
use nalgebra::Matrix3;

/// Derivatives of a and b at some F [Pa].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InvariantDerivatives {
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
