//! Matrices of a domain from the tangent of its law: K_ij = V Σ_jl T_ijkl b_i b_j.
//!
//! Nothing changes under translation, so the blocks of the first node are minus the sums of the others.

use crate::elements::ElementMatrix;
use crate::lanes::{FourTangents, FourVectors, Lanes};
use crate::law::Matrix9;
use crate::number::{Columns9, Number, Three};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Sets `out`, which is zero, to the matrix of the tangent `tangent` \[Pa\] over a domain of `volume` \[m³\] with these gradients.
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

/// V T of a domain or of four, in the order in which it meets the gradients: `[j][9 l + 3 k + i]` is V T_ijkl \[N·m\].
pub(super) struct DomainTangent<N>([[N; 27]; 3]);

impl<N: Number> DomainTangent<N> {
    /// That of the tangent with these columns \[Pa\] over `volume` \[m³\].
    #[inline(always)]
    pub fn new(tangent: &Columns9<N>, volume: N) -> Self {
        let mut ordered = [[N::of(0.0); 27]; 3];
        for (j, ordered) in ordered.iter_mut().enumerate() {
            for (l, k, i) in (0..27).map(|p| (p / 9, p / 3 % 3, p % 3)) {
                ordered[9 * l + 3 * k + i] = volume * tangent[k + 3 * l][i + 3 * j];
            }
        }
        Self(ordered)
    }

    /// Sets `corner` to that of a node with the gradient `b`.
    #[inline(always)]
    pub fn set_corner(&self, b: Three<N>, corner: &mut CornerTangent<N>) {
        let [x, y, z] = &self.0;
        corner.b = b;
        for (p, change) in corner.change.iter_mut().enumerate() {
            *change = x[p] * b[0] + y[p] * b[1] + z[p] * b[2];
        }
    }
}

/// What deformations do to the force on one node.
#[derive(Clone, Copy)]
pub(super) struct CornerTangent<N> {
    b: Three<N>,
    /// `[9 l + 3 k + i]` is V Σ_j T_ijkl b_j \[N\].
    change: [N; 27],
}

impl<N: Number> CornerTangent<N> {
    /// Of no node.
    #[inline(always)]
    pub fn zero() -> Self {
        Self {
            b: [N::of(0.0); 3],
            change: [N::of(0.0); 27],
        }
    }

    /// The block of this node and the node of `column`, column after column.
    #[inline(always)]
    pub fn block(&self, column: &Self) -> [N; 9] {
        let b = &column.b;
        let mut block = [N::of(0.0); 9];
        for (p, entry) in block.iter_mut().enumerate() {
            let [x, y, z] = [0, 9, 18].map(|l| self.change[l + p]);
            *entry = x * b[0] + y * b[1] + z * b[2];
        }
        block
    }
}

/// The blocks of four tetrahedra, those of row node i and column node j at `[i][j]`, each column after column \[N/m\].
pub(super) type FourMatrices = [[[Lanes; 9]; CORNERS]; CORNERS];

/// Nodes of a tetrahedron.
pub(super) const CORNERS: usize = 4;

/// Those of these tangents \[Pa\], volumes \[m³\] and gradients.
///
/// A function of its own, which is not inlined: between memory and memory the compiler works on whole registers.
#[inline(never)]
pub(super) fn set_matrices(
    tangents: &FourTangents,
    volumes: Lanes,
    gradients: &[FourVectors; CORNERS],
    matrices: &mut FourMatrices,
) {
    let tangents = DomainTangent::new(tangents, volumes);
    let mut corners = [CornerTangent::zero(); CORNERS];
    for (corner, b) in corners.iter_mut().zip(gradients) {
        tangents.set_corner(*b, corner);
    }
    for (row, blocks) in matrices.iter_mut().enumerate() {
        for (block, column) in blocks.iter_mut().zip(&corners) {
            *block = corners[row].block(column);
        }
    }
}
