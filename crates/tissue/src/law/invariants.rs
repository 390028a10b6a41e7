//! Laws of the form Ψ = a(I) + b(J), I = tr FᵀF, J = det F: stress and tangent from the derivatives of a and b.

use super::{Matrix9, PrincipalTangent};
use crate::number::{Columns, Columns9, Number, columns_of, entries};
use nalgebra::{Matrix3, Vector3};

/// Derivatives of a and b at some F \[Pa\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct InvariantDerivatives<N = f64> {
    /// a'.
    pub a1: N,
    /// a''.
    pub a2: N,
    /// b'.
    pub b1: N,
    /// b''.
    pub b2: N,
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
    let mut tangent = [[0.0; 9]; 9];
    set_tangent(&columns_of(f), &columns_of(cofactor), d, &mut tangent);
    tangent.into()
}

/// As [`tangent`], of one matrix or of four.
#[inline(always)]
pub(super) fn set_tangent<N: Number>(
    f: &Columns<N>,
    cofactor: &Columns<N>,
    d: &InvariantDerivatives<N>,
    tangent: &mut Columns9<N>,
) {
    let (f_entries, c_entries) = (entries(f), entries(cofactor));
    for (q, column) in tangent.iter_mut().enumerate() {
        let (along_f, along_c) = (N::of(4.0) * d.a2 * f_entries[q], d.b2 * c_entries[q]);
        for (p, entry) in column.iter_mut().enumerate() {
            *entry = f_entries[p] * along_f + c_entries[p] * along_c;
        }
        column[q] = column[q] + N::of(2.0) * d.a1;
    }
    // ∂cof_ij/∂F_kl = ε_ikm ε_jln F_mn.
    for j in 0..3 {
        for (l, n, factor) in [
            ((j + 1) % 3, (j + 2) % 3, d.b1),
            ((j + 2) % 3, (j + 1) % 3, -d.b1),
        ] {
            for i in 0..3 {
                let (next, last) = ((i + 1) % 3, (i + 2) % 3);
                let row = i + 3 * j;
                let (a, b) = (next + 3 * l, last + 3 * l);
                tangent[a][row] = tangent[a][row] + factor * f[n][last];
                tangent[b][row] = tangent[b][row] - factor * f[n][next];
            }
        }
    }
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
