//! Matrices of a domain from the tangent of its law: K_ij = V Σ_jl T_ijkl b_i b_j.

use crate::elements::ElementMatrix;
use crate::law::decomposition::SignedSvd;
use crate::law::{Lame, Law, Matrix9};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Adds the matrix of the tangent `tangent` [Pa] over a domain of `volume` [m³] with these gradients.
pub(super) fn add_tangent(
    tangent: &Matrix9,
    volume: f64,
    gradient: impl Fn(usize) -> Vector3<f64>,
    out: &mut ElementMatrix,
) {
    for column in 0..out.nodes() {
        // ∂P/∂x of the node: 9 × 3.
        let b = gradient(column) * volume;
        let mut change = SMatrix::<f64, 9, 3>::zeros();
        for k in 0..3 {
            for l in 0..3 {
                for p in 0..9 {
                    change[(p, k)] += tangent[(p, k + 3 * l)] * b[l];
                }
            }
        }
        for row in 0..=column {
            let b = gradient(row);
            let block = Matrix3::from_fn(|i, k| {
                change[(i, k)] * b[0] + change[(i + 3, k)] * b[1] + change[(i + 6, k)] * b[2]
            });
            add_pair(row, column, &block, out);
        }
    }
}

/// Adds the matrix of the nearest tangent without negative eigenvalues. The gradients are turned into the principal axes,
/// where the tangent is sparse, instead of the tangent out of them.
pub(super) fn add_positive_tangent<L: Law>(
    f: &Matrix3<f64>,
    lame: &Lame,
    volume: f64,
    gradient: impl Fn(usize) -> Vector3<f64>,
    out: &mut ElementMatrix,
) {
    let svd = SignedSvd::new(f);
    let tangent = L::principal_tangent(&svd.stretches, lame).positive();
    for column in 0..out.nodes() {
        let b = svd.v.tr_mul(&gradient(column)) * volume;
        for row in 0..=column {
            let a = svd.v.tr_mul(&gradient(row));
            let block = svd.u * tangent.block(&a, &b) * svd.u.transpose();
            add_pair(row, column, &block, out);
        }
    }
}

/// Adds a block and, off the diagonal, its transpose at the mirrored place.
fn add_pair(row: usize, column: usize, block: &Matrix3<f64>, out: &mut ElementMatrix) {
    *out.block_mut(row, column) += block;
    if row != column {
        *out.block_mut(column, row) += block.transpose();
    }
}
