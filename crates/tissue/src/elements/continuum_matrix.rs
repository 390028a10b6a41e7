//! Matrices of a domain from the tangent of its law: K_ij = V Σ_jl T_ijkl b_i b_j.
//!
//! Nothing changes under translation, so the blocks of the first node are minus the sums of the others.

use super::domains::FourTetrahedra;
use crate::elements::ElementMatrix;
use crate::lanes::{FourTangents, LANES, Lanes, matrix_of};
use crate::law::decomposition::FourSvds;
use crate::law::{
    Constants, FourFamilies, FourPrincipalTangents, Lame, Law, Matrix9, positive_principal_tangents,
};
use crate::number::{Columns, Columns9, Number, Three, columns, dot, product, three};
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
            *change = z[p].mul_add(b[2], y[p].mul_add(b[1], x[p] * b[0]));
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
            let [x, y, z] = three(|l| self.change[9 * l + p]);
            *entry = z.mul_add(b[2], y.mul_add(b[1], x * b[0]));
        }
        block
    }
}

/// Nodes of a tetrahedron.
pub(super) const CORNERS: usize = 4;

/// Pairs of nodes (i, j ≤ i) of a tetrahedron, in ascending order.
const PAIRS: usize = CORNERS * (CORNERS + 1) / 2;

/// The place of the pair (i, j) of such pairs.
#[inline(always)]
const fn pair(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// Matrices of four tetrahedra \[N/m\]: the blocks of row node i and column node j ≤ i, each by its columns.
///
/// Those of its functions that compute are not inlined: between memory and memory the compiler works on whole registers. Before
/// [`complete`](Self::complete) the blocks with the first node are zero.
#[derive(Clone, Copy)]
pub(super) struct FourMatrices([Columns<Lanes>; PAIRS]);

impl FourMatrices {
    /// Zero.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([[[Lanes::splat(0.0); 3]; 3]; PAIRS])
    }

    /// Sets all entries to zero in place: [`zero`](Self::zero) would be copied.
    #[inline(always)]
    pub fn clear(&mut self) {
        for entry in self.0.as_flattened_mut().as_flattened_mut() {
            *entry = Lanes::splat(0.0);
        }
    }

    /// Adds those of the positive tangents of a law, with constants of each.
    #[inline(always)]
    pub fn add_positive<L: Law>(
        &mut self,
        f: &Columns<Lanes>,
        constants: &[L::Constants; LANES],
        shapes: &FourTetrahedra,
    ) {
        let svds = FourSvds::new(f);
        if L::Constants::DIRECTIONS == 0 {
            let tangents = positive_principal_tangents::<L>(&svds, constants);
            self.add_in_axes(&tangents, shapes);
        } else {
            let mut tangents = [[Lanes::splat(0.0); 9]; 9];
            L::set_positive_tangents_of_each(&svds, constants, &mut tangents);
            self.add_tangents(&tangents, shapes);
        }
    }

    /// Adds those of principal tangents.
    #[inline(never)]
    pub fn add_in_axes(&mut self, tangents: &FourPrincipalTangents, shapes: &FourTetrahedra) {
        let tangents = tangents.scaled(shapes.volumes);
        let gradients = three(|corner| tangents.in_axes(&shapes.gradients[corner]));
        self.add_blocks(|i, j| tangents.block(&gradients[i], &gradients[j]));
    }

    /// Adds those of any tangents.
    #[inline(never)]
    pub fn add_tangents(&mut self, tangents: &FourTangents, shapes: &FourTetrahedra) {
        let tangents = DomainTangent::new(tangents, shapes.volumes);
        let mut corners = [CornerTangent::zero(); CORNERS - 1];
        for (corner, b) in corners.iter_mut().zip(&shapes.gradients) {
            tangents.set_corner(*b, corner);
        }
        self.add_blocks(|i, j| {
            let block = corners[i].block(&corners[j]);
            columns(|k, i| block[3 * k + i])
        });
    }

    /// Adds those of [viscosity](crate::law::viscosity) with the moduli `lame` and `families` times `time` \[s\]: with c_i = F b_i and h_i = F H b_i
    ///
    /// ```text
    /// K_ij = V τ (λ c_i c_jᵀ + μ c_j c_iᵀ + μ (b_i·b_j) F Fᵀ + Σ m h_i h_jᵀ)
    /// ```
    #[inline(never)]
    pub fn add_viscous(
        &mut self,
        f: &Columns<Lanes>,
        lame: &Lame,
        families: &Option<FourFamilies>,
        time: f64,
        shapes: &FourTetrahedra,
    ) {
        let scale = shapes.volumes * Lanes::splat(time);
        let mu = Lanes::splat(lame.mu) * scale;
        let lambda = Lanes::splat(lame.lambda) * scale;
        let b = &shapes.gradients;
        let c = three(|i| product(f, &b[i]));
        let rows = columns(|i, k| f[k][i]);
        let left = columns(|k, i| dot(&rows[k], &rows[i]) * mu);
        self.add_blocks(|i, j| {
            let along = dot(&b[i], &b[j]);
            columns(|k, row| {
                let one = (c[i][row] * lambda).mul_add(c[j][k], left[k][row] * along);
                (c[j][row] * mu).mul_add(c[i][k], one)
            })
        });
        for (stiffness, structure) in families.iter().flatten() {
            let stiffness = *stiffness * scale;
            let h = three(|i| product(f, &product(structure, &b[i])));
            self.add_blocks(|i, j| columns(|k, row| h[i][row] * h[j][k] * stiffness));
        }
    }

    /// Adds to the blocks of the last three nodes, here 0 to 2.
    #[inline(always)]
    fn add_blocks(&mut self, block: impl Fn(usize, usize) -> Columns<Lanes>) {
        for i in 0..CORNERS - 1 {
            for j in 0..=i {
                let sum = &mut self.0[pair(i + 1, j + 1)];
                let block = block(i, j);
                *sum = columns(|k, row| sum[k][row] + block[k][row]);
            }
        }
    }

    /// Sets the blocks with the first node.
    #[inline(never)]
    pub fn complete(&mut self) {
        for i in 1..CORNERS {
            let mut sum = [[Lanes::splat(0.0); 3]; 3];
            for j in 1..CORNERS {
                sum = match j <= i {
                    true => {
                        let block = &self.0[pair(i, j)];
                        columns(|k, row| sum[k][row] - block[k][row])
                    }
                    false => {
                        let block = &self.0[pair(j, i)];
                        columns(|k, row| sum[k][row] - block[row][k])
                    }
                };
            }
            self.0[pair(i, 0)] = sum;
        }
        let [one, two, last] = [1, 2, 3].map(|i| self.0[pair(i, 0)]);
        self.0[0] = columns(|k, row| -(one[k][row] + two[k][row] + last[k][row]));
    }

    /// The block of row node i and column node j of one of them.
    #[inline(always)]
    pub fn block(&self, lane: usize, i: usize, j: usize) -> Matrix3<f64> {
        match j <= i {
            true => matrix_of(&self.0[pair(i, j)], lane),
            false => {
                let block = &self.0[pair(j, i)];
                Matrix3::from_fn(|row, k| block[row][k].0[lane])
            }
        }
    }
}
