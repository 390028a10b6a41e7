//! The tangent of an isotropic law in the axes of the principal stretches, and its nearest positive form.
//!
//! With F = U diag(σ) Vᵀ, δP = U T(Uᵀ δF V) Vᵀ. At a diagonal F isotropy leaves of the 81 entries of T only a 3×3 block of the
//! stretches and, for each pair of axes, a 2×2 block [[a, b], [b, a]] of the shears (Sifakis & Barbič 2012; Smith, de Goes, Kim
//! 2019). Its eigenvalues are cut off at zero block by block, which gives the nearest tangent without negative ones.

use super::decomposition::{FourSvds, SignedSvd, symmetric_eigen};
use super::elasticity::Matrix9;
use crate::lanes::{FourTangents, FourVectors, LANES, Lanes, lanes};
use crate::number::{
    Columns, Columns9, Number, Three, columns, columns_of, product, three, transposed_product,
};
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
        let entries = Entries {
            stretch: columns_of(&self.stretch),
            direct: self.direct,
            crossed: self.crossed,
        };
        let mut tangent = [[0.0; 9]; 9];
        let (u, v) = (columns_of(&svd.u), columns_of(&svd.v));
        rotate(&entries, &u, &v, &mut tangent);
        tangent.into()
    }
}

/// The entries of a [`PrincipalTangent`], of one element or of four.
struct Entries<N> {
    stretch: Columns<N>,
    direct: Three<N>,
    crossed: Three<N>,
}

/// The principal tangents of four elements, with their axes.
pub struct FourPrincipalTangents {
    entries: Entries<Lanes>,
    u: Columns<Lanes>,
    v: Columns<Lanes>,
}

impl FourPrincipalTangents {
    /// Of four elements at F = U diag(σ) Vᵀ.
    #[inline(always)]
    pub fn new(of: &[PrincipalTangent; LANES], f: &FourSvds) -> Self {
        let stretch = |i: usize, k: usize| Lanes(lanes(|lane| of[lane].stretch[(i, k)]));
        Self {
            entries: Entries {
                stretch: columns(|k, i| stretch(i, k)),
                direct: three(|pair| Lanes(lanes(|lane| of[lane].direct[pair]))),
                crossed: three(|pair| Lanes(lanes(|lane| of[lane].crossed[pair]))),
            },
            u: f.u,
            v: f.v,
        }
    }

    /// Sets `tangents` to [`rotated`](PrincipalTangent::rotated) of all of them: the same bits.
    ///
    /// A function of its own, which is not inlined: between memory and memory the compiler works on whole registers.
    #[inline(never)]
    pub fn set_tangents(&self, tangents: &mut FourTangents) {
        rotate(&self.entries, &self.u, &self.v, tangents);
    }

    /// The same times a factor.
    #[inline(always)]
    pub fn scaled(&self, factor: Lanes) -> Self {
        let entries = &self.entries;
        Self {
            entries: Entries {
                stretch: columns(|k, i| entries.stretch[k][i] * factor),
                direct: three(|pair| entries.direct[pair] * factor),
                crossed: three(|pair| entries.crossed[pair] * factor),
            },
            ..*self
        }
    }

    /// Vᵀ b of a gradient b \[1/m\].
    #[inline(always)]
    pub fn in_axes(&self, gradient: &FourVectors) -> FourVectors {
        transposed_product(&self.v, gradient)
    }

    /// Σ_jl T_ijkl b_j d_l, column after column, for the gradients b of the row and d of the column [in these axes](Self::in_axes): there
    ///
    /// ```text
    /// k_pp = S_pp b_p d_p + Σ_(q ≠ p) D_pq b_q d_q        k_pq = S_pq b_p d_q + C_pq b_q d_p
    /// ```
    ///
    /// with the entries S of stretches, D direct and C crossed of shears; then U k Uᵀ.
    #[inline(always)]
    pub fn block(&self, row: &FourVectors, column: &FourVectors) -> Columns<Lanes> {
        let Entries {
            stretch,
            direct,
            crossed,
        } = &self.entries;
        let along = three(|p| row[p] * column[p]);
        // The pair of two axes has the place of the third one.
        let sheared = three(|p| {
            let (q, r) = ((p + 1) % 3, (p + 2) % 3);
            direct[q].mul_add(along[r], direct[r] * along[q])
        });
        let k = columns(|q, p| match p == q {
            true => stretch[p][p].mul_add(along[p], sheared[p]),
            false => {
                let of_shears = crossed[3 - p - q] * row[q] * column[p];
                (stretch[q][p] * row[p]).mul_add(column[q], of_shears)
            }
        });
        let half = three(|q| product(&self.u, &k[q]));
        // (U k) Uᵀ: column l is Σ_q (U k)_q U_lq.
        let rows = columns(|l, q| self.u[q][l]);
        three(|l| product(&half, &rows[l]))
    }
}

/// Sets `tangent` to Σ T_abcd Q_ab ⊗ Q_cd.
#[inline(always)]
fn rotate<N: Number>(of: &Entries<N>, u: &Columns<N>, v: &Columns<N>, tangent: &mut Columns9<N>) {
    let axes = |a: usize, b: usize| outer(&u[a], &v[b]);
    let stretches = [axes(0, 0), axes(1, 1), axes(2, 2)];
    let mut pairs = [([N::of(0.0); 9], [N::of(0.0); 9]); 9];
    for (k, stretch) in stretches.iter().enumerate() {
        let mut image = [N::of(0.0); 9];
        add(&mut image, &stretches[0], of.stretch[k][0]);
        add(&mut image, &stretches[1], of.stretch[k][1]);
        add(&mut image, &stretches[2], of.stretch[k][2]);
        pairs[k] = (*stretch, image);
    }
    for (k, [i, j]) in PAIRS.into_iter().enumerate() {
        let (one, other) = (axes(i, j), axes(j, i));
        for (place, a, b) in [(3 + k, one, other), (6 + k, other, one)] {
            let mut image = [N::of(0.0); 9];
            add(&mut image, &a, of.direct[k]);
            add(&mut image, &b, of.crossed[k]);
            pairs[place] = (a, image);
        }
    }
    for (q, column) in tangent.iter_mut().enumerate() {
        let mut sum = [N::of(0.0); 9];
        for (deformation, image) in &pairs {
            add(&mut sum, deformation, image[q]);
        }
        *column = sum;
    }
}

/// u vᵀ, column after column.
#[inline(always)]
fn outer<N: Number>(u: &Three<N>, v: &Three<N>) -> [N; 9] {
    let mut entries = [N::of(0.0); 9];
    for (p, entry) in entries.iter_mut().enumerate() {
        *entry = u[p % 3] * v[p / 3];
    }
    entries
}

/// Adds a change of F, column after column, times a factor.
#[inline(always)]
fn add<N: Number>(sum: &mut [N; 9], other: &[N; 9], factor: N) {
    for (entry, other) in sum.iter_mut().zip(other) {
        *entry = other.mul_add(factor, *entry);
    }
}

/// Whether a symmetric matrix has positive eigenvalues only (Sylvester): saves the common case the eigenvalues.
fn is_positive(m: &Matrix3<f64>) -> bool {
    let minor = m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(0, 1)];
    m[(0, 0)] > 0.0 && minor > 0.0 && m.determinant() > 0.0
}
