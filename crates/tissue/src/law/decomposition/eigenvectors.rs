//! Eigenvectors of four symmetric matrices at once, without iteration: a start that leaves Jacobi's rotations little to do.
//!
//! Shifted and scaled, a symmetric matrix has the eigenvalues 2 cos θ, 2 cos(θ ± 2π/3) (Smith 1961). The one of largest size is
//! at least √3 away from the others, so that its vector is exact to rounding; one rotation around it does the rest (Eberly 2014).

use crate::elements::lanes::{
    FourVectors, LANES, Lanes, cross_of_four, dot_of_four, product_of_four,
};
use nalgebra::Matrix3;

/// √3.
const ROOT_OF_THREE: f64 = 1.732_050_807_568_877_2;

/// Coefficients of the start of [`isolated_root`]: with √3 and 1/6 before them it has the values √3, 2 and the slopes 1/6, 1/9 at
/// the ends.
const SQUARE: f64 = -0.021_260_3;
const CUBE: f64 = 0.002_457_1;

/// Least squares that numbers are divided by: equal eigenvalues, of which any axes are eigenvectors.
const TINY: f64 = 1e-200;

/// Of each symmetric matrix, of size one, a proper rotation V with VᵀmV diagonal but for some roundings.
pub(super) fn eigenvectors_of_four(matrices: &[Matrix3<f64>; LANES]) -> [Matrix3<f64>; LANES] {
    let m = normalised(matrices);
    let first = isolated_eigenvector(&m);
    let [t, w] = complement(&first);
    let (along_t, along_w) = (product_of_four(&m, &t), product_of_four(&m, &w));
    let difference = dot_of_four(&w, &along_w) - dot_of_four(&t, &along_t);
    let coupling = Lanes::splat(2.0) * dot_of_four(&t, &along_w);
    let [cosine, sine] = smaller_turn(difference, coupling);
    let second = [0, 1, 2].map(|i| t[i] * cosine - w[i] * sine);
    let third = [0, 1, 2].map(|i| t[i] * sine + w[i] * cosine);
    [0, 1, 2, 3].map(|lane| {
        let column = |v: &FourVectors| [v[0].0[lane], v[1].0[lane], v[2].0[lane]];
        Matrix3::from([column(&first), column(&second), column(&third)])
    })
}

/// The matrices, column after column, without their traces and with squares of eigenvalues that sum to 6.
#[inline(always)]
fn normalised(matrices: &[Matrix3<f64>; LANES]) -> [FourVectors; 3] {
    let entry = |i: usize, k: usize| Lanes(matrices.map(|m| m[(i, k)]));
    let of = Lanes::splat;
    let [xx, yy, zz] = [entry(0, 0), entry(1, 1), entry(2, 2)];
    let [yz, zx, xy] = [entry(1, 2), entry(2, 0), entry(0, 1)];
    let mean = (xx + yy + zz) * of(1.0 / 3.0);
    let [xx, yy, zz] = [xx - mean, yy - mean, zz - mean];
    let squares = dot_of_four(&[xx, yy, zz], &[xx, yy, zz]);
    let products = dot_of_four(&[yz, zx, xy], &[yz, zx, xy]);
    let square = squares * of(1.0 / 6.0) + products * of(1.0 / 3.0);
    let scale = of(1.0) / (square + of(TINY)).sqrt();
    [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]].map(|column| column.map(|entry| entry * scale))
}

/// The eigenvector of the eigenvalue of largest size.
#[inline(always)]
fn isolated_eigenvector(m: &[FourVectors; 3]) -> FourVectors {
    let determinant = dot_of_four(&m[0], &cross_of_four(&m[1], &m[2]));
    let root = isolated_root(determinant.abs().min(Lanes::splat(2.0))).copysign(determinant);
    let mut m = *m;
    for (k, column) in m.iter_mut().enumerate() {
        column[k] = column[k] - root;
    }
    // All of them are along the vector; the longest has kept most digits.
    let mut longest = cross_of_four(&m[0], &m[1]);
    let mut square = dot_of_four(&longest, &longest);
    for [a, b] in [[1, 2], [2, 0]] {
        let other = cross_of_four(&m[a], &m[b]);
        let other_square = dot_of_four(&other, &other);
        longest = [0, 1, 2].map(|i| other_square.where_above(square, other[i], longest[i]));
        square = other_square.max(square);
    }
    let scale = Lanes::splat(1.0) / square.sqrt();
    longest.map(|entry| entry * scale)
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
    let scale = Lanes::splat(1.0) / (x * x + y * y + Lanes::splat(TINY * TINY)).sqrt();
    [x * scale, y * scale]
}
