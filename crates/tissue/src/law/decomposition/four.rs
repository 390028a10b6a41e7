//! Signed singular values of four matrices at once, without iteration, from the eigenvectors of FᵀF.
//!
//! Shifted and scaled, FᵀF has the eigenvalues 2 cos θ, 2 cos(θ ± 2π/3) (Smith 1961). The one of largest size is
//! at least √3 away from the others, so that its vector is exact to rounding; one rotation around it does the rest (Eberly 2014).

use super::SignedSvd;
use crate::lanes::{
    FourVectors, LANES, Lanes, lanes, matrix_of, set_matrix, set_vector, vector_of,
};
use crate::number::{Columns, cross, dot, product, three};
use nalgebra::Matrix3;
use std::ops::Range;

/// The decompositions of four matrices, the columns of each.
#[derive(Clone, Copy, Debug)]
pub struct FourSvds {
    /// U.
    pub u: Columns<Lanes>,
    /// σ.
    pub stretches: FourVectors,
    /// V.
    pub v: Columns<Lanes>,
}

impl FourSvds {
    /// As [`SignedSvd::new`], in a fraction of the time unless stretches are very unequal.
    ///
    /// A function of its own, which is not inlined: between memory and memory the compiler works on whole registers.
    #[inline(never)]
    pub fn new(f: &Columns<Lanes>) -> Self {
        let (mut svds, is_exact) = direct(f);
        for lane in (0..LANES).filter(|lane| !is_exact[*lane]) {
            let SignedSvd { u, stretches, v } = SignedSvd::new(&matrix_of(f, lane));
            set_matrix(&mut svds.u, lane, &u);
            set_vector(&mut svds.stretches, lane, &stretches);
            set_matrix(&mut svds.v, lane, &v);
        }
        svds
    }

    /// One of them.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> SignedSvd {
        SignedSvd {
            u: matrix_of(&self.u, lane),
            stretches: vector_of(&self.stretches, lane),
            v: matrix_of(&self.v, lane),
        }
    }
}

/// √3.
const ROOT_OF_THREE: f64 = 1.732_050_807_568_877_2;

/// Coefficients of the start of [`isolated_root`]: with √3 and 1/6 before them it has the values √3, 2 and the slopes 1/6, 1/9 at
/// the ends.
const SQUARE: f64 = -0.021_260_3;
const CUBE: f64 = 0.002_457_1;

/// Largest cosine between columns that count as orthogonal: F is restored to that fraction of its largest stretch. With stretches within a
/// factor of two the roundings of FᵀF leave less.
pub(super) const COSINE: f64 = 32.0 * f64::EPSILON;

/// Squares of the largest stretch of which squares of squares neither overflow nor vanish.
const SIZES: Range<f64> = 1e-20..1e20;

/// Least ratio of the squares of the second and the first stretch.
const UNEQUAL: f64 = 1e-6;

/// Added to what may vanish where eigenvalues are equal, and any axes are eigenvectors.
const TINY: f64 = 1e-100;

/// The decompositions, and of which of them the stretches are near enough to each other for FᵀF to have retained their digits.
#[inline(always)]
pub(super) fn direct(f: &Columns<Lanes>) -> (FourSvds, [bool; LANES]) {
    let mut v = eigenvectors(&gram(f));
    let mut a = three(|k| product(f, &v[k]));
    for [p, q] in [[0, 1], [1, 2], [0, 1]] {
        let squares = [dot(&a[p], &a[p]), dot(&a[q], &a[q])];
        exchange_where_above(squares, &mut a, p, q);
        exchange_where_above(squares, &mut v, p, q);
    }
    let is_exact = are_orthogonal(&a);
    let u1 = normalised(&a[0]);
    let along = dot(&u1, &a[1]);
    let u2 = normalised(&three(|i| a[1][i] - along * u1[i]));
    let u = [u1, u2, cross(&u1, &u2)];
    let stretches = three(|k| dot(&u[k], &a[k]));
    (FourSvds { u, stretches, v }, is_exact)
}

/// Columns p, q ← −q, p where the square of q is above that of p: V stays a proper rotation.
#[inline(always)]
fn exchange_where_above(squares: [Lanes; 2], columns: &mut [FourVectors; 3], p: usize, q: usize) {
    let [first, second] = squares;
    let (x, y) = (columns[p], columns[q]);
    columns[p] = three(|i| second.where_above(first, -y[i], x[i]));
    columns[q] = three(|i| second.where_above(first, x[i], y[i]));
}

/// Whether descending columns are at right angles but for rounding, and none but the last vanishes.
#[inline(always)]
fn are_orthogonal(a: &[FourVectors; 3]) -> [bool; LANES] {
    let squares = three(|k| dot(&a[k], &a[k]));
    let products = three(|pair| {
        let [p, q] = [[0, 1], [0, 2], [1, 2]][pair];
        let product = dot(&a[p], &a[q]);
        [product * product, squares[p] * squares[q]]
    });
    lanes(|lane| {
        let [first, second] = [squares[0].0[lane], squares[1].0[lane]];
        let is_normal = SIZES.contains(&first) && second > UNEQUAL * first;
        is_normal
            && products
                .iter()
                .all(|[square, bound]| square.0[lane] <= COSINE * COSINE * bound.0[lane])
    })
}

#[inline(always)]
fn normalised(v: &FourVectors) -> FourVectors {
    let scale = Lanes::splat(1.0) / dot(v, v).sqrt();
    three(|i| v[i] * scale)
}

/// A proper rotation V with VᵀmV diagonal but for some roundings of a symmetric `m`, and some rotation where squares of the entries
/// of m overflow or vanish.
pub(super) fn eigenvectors_of_one(m: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |k: usize| [0, 1, 2].map(|i| Lanes::splat(m[(i, k)]));
    let v = eigenvectors(&[column(0), column(1), column(2)]);
    Matrix3::from_fn(|i, k| v[k][i].0[0])
}

/// FᵀF.
#[inline(always)]
fn gram(f: &[FourVectors; 3]) -> [FourVectors; 3] {
    let [xx, yy, zz] = three(|k| dot(&f[k], &f[k]));
    let [yz, zx, xy] = [dot(&f[1], &f[2]), dot(&f[2], &f[0]), dot(&f[0], &f[1])];
    [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]
}

/// The columns of such rotations of four.
#[inline(always)]
fn eigenvectors(m: &[FourVectors; 3]) -> [FourVectors; 3] {
    let m = deviator(m);
    let first = isolated_eigenvector(&m);
    let [t, w] = complement(&first);
    let (along_t, along_w) = (product(&m, &t), product(&m, &w));
    let difference = dot(&w, &along_w) - dot(&t, &along_t);
    let coupling = Lanes::splat(2.0) * dot(&t, &along_w);
    let [cosine, sine] = smaller_turn(difference, coupling);
    let second = three(|i| t[i] * cosine - w[i] * sine);
    let third = three(|i| t[i] * sine + w[i] * cosine);
    [first, second, third]
}

/// A symmetric matrix without its trace and with squares of eigenvalues that sum to 6.
#[inline(always)]
fn deviator(m: &[FourVectors; 3]) -> [FourVectors; 3] {
    let of = Lanes::splat;
    let [[xx, xy, zx], [_, yy, yz], [_, _, zz]] = *m;
    let mean = (xx + yy + zz) * of(1.0 / 3.0);
    let [xx, yy, zz] = [xx - mean, yy - mean, zz - mean];
    let squares = dot(&[xx, yy, zz], &[xx, yy, zz]);
    let products = dot(&[yz, zx, xy], &[yz, zx, xy]);
    let square = squares * of(1.0 / 6.0) + products * of(1.0 / 3.0);
    let scale = of(1.0) / (square + of(TINY)).sqrt();
    let [xx, yy, zz] = [xx * scale, yy * scale, zz * scale];
    let [yz, zx, xy] = [yz * scale, zx * scale, xy * scale];
    [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]
}

/// The eigenvector of the eigenvalue of largest size.
#[inline(always)]
fn isolated_eigenvector(m: &[FourVectors; 3]) -> FourVectors {
    let determinant = dot(&m[0], &cross(&m[1], &m[2]));
    let root = isolated_root(determinant.abs().min(Lanes::splat(2.0))).copysign(determinant);
    let mut m = *m;
    for (k, column) in m.iter_mut().enumerate() {
        column[k] = column[k] - root;
    }
    // All of them are along the vector; the longest has kept most digits.
    let mut longest = cross(&m[0], &m[1]);
    let mut square = dot(&longest, &longest);
    for [a, b] in [[1, 2], [2, 0]] {
        let other = cross(&m[a], &m[b]);
        let other_square = dot(&other, &other);
        longest = three(|i| other_square.where_above(square, other[i], longest[i]));
        square = other_square.max(square);
    }
    normalised(&longest)
}

/// The largest root of β³ − 3β = `d` for d of 0 to 2; it is simple, and from √3 to 2.
#[inline(always)]
fn isolated_root(d: Lanes) -> Lanes {
    let of = Lanes::splat;
    let mut root = of(ROOT_OF_THREE) + d * (of(1.0 / 6.0) + d * (of(SQUARE) + d * of(CUBE)));
    // From an error of 1e-4, which each step squares.
    for _ in 0..2 {
        let square = root * root;
        root = root - (root * (square - of(3.0)) - d) / (of(3.0) * square - of(3.0));
    }
    root
}

/// Two unit vectors that make a proper rotation with the unit vector `u` before them (Duff et al. 2017).
#[inline(always)]
fn complement(u: &FourVectors) -> [FourVectors; 2] {
    let one = Lanes::splat(1.0);
    let sign = one.copysign(u[2]);
    let a = -(one / (sign + u[2]));
    let b = u[0] * u[1] * a;
    [
        [one + sign * u[0] * u[0] * a, sign * b, -(sign * u[0])],
        [b, sign + u[1] * u[1] * a, -u[1]],
    ]
}

/// Cosine and sine of the Jacobi rotation that makes [[a, g/2], [g/2, a + difference]] diagonal, by the smaller angle.
#[inline(always)]
fn smaller_turn(difference: Lanes, g: Lanes) -> [Lanes; 2] {
    let x = difference.abs() + (difference * difference + g * g).sqrt() + Lanes::splat(TINY);
    let y = g * Lanes::splat(1.0).copysign(difference);
    let scale = Lanes::splat(1.0) / (x * x + y * y).sqrt();
    [x * scale, y * scale]
}
