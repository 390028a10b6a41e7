//! Laws of the form Ψ = a(I) + b(J), I = tr FᵀF, J = det F: stress and tangent from the derivatives of a and b.

use super::{Matrix9, PrincipalTangent};
use nalgebra::{Matrix3, Vector3};

/// Derivatives of a and b at some F \[Pa\].
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
#[inline(always)]
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

/// ∂P/∂F at F = diag(`stretches`).
#[inline]
pub(super) fn principal_tangent(
    stretches: &Vector3<f64>,
    d: &InvariantDerivatives,
) -> PrincipalTangent {
    let [x, y, z] = [stretches[0], stretches[1], stretches[2]];
    let areas = [y * z, z * x, x * y];
    let of_areas = [d.b1 * x, d.b1 * y, d.b1 * z];
    let entry =
        |i: usize, j: usize| 4.0 * d.a2 * stretches[i] * stretches[j] + d.b2 * areas[i] * areas[j];
    let direct = 2.0 * d.a1;
    let (yz, zx, xy) = (
        entry(1, 2) + of_areas[0],
        entry(2, 0) + of_areas[1],
        entry(0, 1) + of_areas[2],
    );
    PrincipalTangent {
        stretch: Matrix3::new(
            entry(0, 0) + direct,
            xy,
            zx,
            xy,
            entry(1, 1) + direct,
            yz,
            zx,
            yz,
            entry(2, 2) + direct,
        ),
        direct: [direct; 3],
        crossed: of_areas.map(|b| -b),
    }
}
