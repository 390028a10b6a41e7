//! Matrices of a domain from the tangent of its law: K_ij = V Σ_jl T_ijkl b_i b_j.
//!
//! Nothing changes under translation, so the blocks of the first node are minus the sums of the others.

use crate::elements::ElementMatrix;
use crate::law::decomposition::SignedSvd;
use crate::law::{Lame, Law, Matrix9};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Sets `out`, which is zero, to the matrix of the tangent `tangent` [Pa] over a domain of `volume` [m³] with these gradients.
pub(super) fn set_tangent(
    tangent: &Matrix9,
    volume: f64,
    gradient: impl Fn(usize) -> Vector3<f64>,
    out: &mut ElementMatrix,
) {
    for column in 1..out.nodes() {
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
        for row in 1..=column {
            let b = gradient(row);
            *out.block_mut(row, column) = Matrix3::from_fn(|i, k| {
                change[(i, k)] * b[0] + change[(i + 3, k)] * b[1] + change[(i + 6, k)] * b[2]
            });
        }
    }
    complete(out);
}

/// Sets `out`, which is zero, to the matrix of the nearest tangent without negative eigenvalues. The gradients are turned into
/// the principal axes, where the tangent is sparse, instead of the tangent out of them.
pub(super) fn set_positive_tangent<L: Law>(
    f: &Matrix3<f64>,
    lame: &Lame,
    volume: f64,
    gradient: impl Fn(usize) -> Vector3<f64>,
    out: &mut ElementMatrix,
) {
    let svd = SignedSvd::new(f);
    let back = svd.u.transpose();
    let tangent = L::principal_tangent(&svd.stretches, lame).positive();
    for column in 1..out.nodes() {
        let b = svd.v.tr_mul(&gradient(column)) * volume;
        for row in 1..=column {
            let a = svd.v.tr_mul(&gradient(row));
            *out.block_mut(row, column) = svd.u * tangent.block(&a, &b) * back;
        }
    }
    complete(out);
}

/// Completes a matrix of which only the upper triangle without the first node is there.
fn complete(out: &mut ElementMatrix) {
    for column in 1..out.nodes() {
        for row in 1..column {
            *out.block_mut(column, row) = out.block(row, column).transpose();
        }
    }
    let mut corner = Matrix3::zeros();
    for row in 1..out.nodes() {
        let mut sum = Matrix3::zeros();
        for column in 1..out.nodes() {
            sum += out.block(row, column);
        }
        corner += sum;
        *out.block_mut(row, 0) = -sum;
        *out.block_mut(0, row) = -sum.transpose();
    }
    // Symmetric but for rounding.
    *out.block_mut(0, 0) = (corner + corner.transpose()) * 0.5;
}
