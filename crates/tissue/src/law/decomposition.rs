//! Small dense algebra of a deformation gradient: signed singular values, rotation, symmetric eigenvalues.
//!
//! All of it is iterative with plain arithmetic and square roots in fixed order, so the bits are the same on every machine.
//! Of a matrix with a number that is not finite one of the singular values or eigenvalues is not finite; nothing panics.

mod four;

pub use four::FourSvds;

use crate::lanes::{LANES, four_columns};
use crate::number::{Columns, Number, columns_of, cross, dot};
use nalgebra::{Matrix3, Vector3};

/// F = U diag(σ) Vᵀ with proper rotations U and V and σ1 ≥ σ2 ≥ |σ3|: σ3 has the sign of det F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedSvd {
    /// U.
    pub u: Matrix3<f64>,
    /// σ.
    pub stretches: Vector3<f64>,
    /// V.
    pub v: Matrix3<f64>,
}

/// Sweeps of a Jacobi iteration: it converges quadratically, 4 to 6 are usual.
const SWEEPS: usize = 30;

/// Columns with a smaller cosine between them are orthogonal to rounding.
const ORTHOGONAL: f64 = 4.0 * f64::EPSILON;

/// The pairs of axes of a sweep.
const PAIRS: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

impl SignedSvd {
    /// One-sided Jacobi iteration (Hestenes): rotates the columns of F until they are orthogonal. It never forms FᵀF, so small
    /// singular values are as exact as F itself.
    pub fn new(f: &Matrix3<f64>) -> Self {
        let scale = f.amax();
        if scale == 0.0 {
            return Self {
                u: Matrix3::identity(),
                stretches: Vector3::zeros(),
                v: Matrix3::identity(),
            };
        }
        let mut a = f / scale;
        let mut v = Matrix3::identity();
        for _ in 0..SWEEPS {
            let mut done = true;
            for [p, q] in PAIRS {
                let (alpha, beta) = (a.column(p).norm_squared(), a.column(q).norm_squared());
                let gamma = a.column(p).dot(&a.column(q));
                if gamma.abs() > ORTHOGONAL * (alpha * beta).sqrt() {
                    done = false;
                    let (cosine, sine) = rotation(beta - alpha, 2.0 * gamma);
                    rotate_columns(&mut a, p, q, cosine, sine);
                    rotate_columns(&mut v, p, q, cosine, sine);
                }
            }
            if done {
                break;
            }
        }
        // Descending; a swap with a change of sign keeps V a proper rotation.
        for [p, q] in [[0, 1], [1, 2], [0, 1]] {
            if a.column(p).norm_squared() < a.column(q).norm_squared() {
                rotate_columns(&mut a, p, q, 0.0, 1.0);
                rotate_columns(&mut v, p, q, 0.0, 1.0);
            }
        }
        let columns = [0, 1, 2].map(|k| a.column(k).into_owned());
        let u1 = columns[0].normalize();
        let across = columns[1] - u1 * u1.dot(&columns[1]);
        let u2 = if across.norm_squared() > 0.0 {
            // Once more, for what rounding has left along u1 when σ2 is tiny.
            let across = across.normalize();
            (across - u1 * u1.dot(&across)).normalize()
        } else {
            perpendicular(&u1)
        };
        let u3 = u1.cross(&u2);
        let stretches = Vector3::new(
            u1.dot(&columns[0]),
            u2.dot(&columns[1]),
            u3.dot(&columns[2]),
        );
        Self {
            u: Matrix3::from_columns(&[u1, u2, u3]),
            stretches: stretches * scale,
            v,
        }
    }

    /// The rotation of the polar decomposition, U Vᵀ.
    pub fn rotation(&self) -> Matrix3<f64> {
        self.u * self.v.transpose()
    }
}

/// The largest singular value of each of these matrices, in their order.
pub fn largest_stretches(f: impl IntoIterator<Item = Matrix3<f64>>) -> Vec<f64> {
    let mut rest = f.into_iter();
    let mut stretches = Vec::with_capacity(rest.size_hint().0);
    while let Some(first) = rest.next() {
        let mut four = [first; LANES];
        let mut count = 1;
        for (place, f) in four[1..].iter_mut().zip(&mut rest) {
            *place = f;
            count += 1;
        }
        let [largest, ..] = FourSvds::new(&four_columns(&four)).stretches;
        stretches.extend(&largest.0[..count]);
    }
    stretches
}

/// Cosine and sine of the Jacobi rotation that makes [[a, g/2], [g/2, a + difference]] diagonal, by the smaller angle.
#[inline]
fn rotation(difference: f64, g: f64) -> (f64, f64) {
    let zeta = difference / g;
    let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    (cosine, cosine * tangent)
}

/// Columns p, q ← cosine p − sine q, sine p + cosine q.
#[inline]
fn rotate_columns(m: &mut Matrix3<f64>, p: usize, q: usize, cosine: f64, sine: f64) {
    for row in 0..3 {
        let (x, y) = (m[(row, p)], m[(row, q)]);
        m[(row, p)] = cosine * x - sine * y;
        m[(row, q)] = sine * x + cosine * y;
    }
}

/// A unit vector at a right angle to the unit vector `u`.
fn perpendicular(u: &Vector3<f64>) -> Vector3<f64> {
    let axis = match u.iamin() {
        0 => Vector3::x(),
        1 => Vector3::y(),
        _ => Vector3::z(),
    };
    u.cross(&axis).normalize()
}

/// Newton's iteration is used while det F is at least this fraction of the cube of the mean stretch.
const WELL_SHAPED: f64 = 0.02;

/// The square of the last step of Newton's iteration: the error left is half of it.
const NEWTON_DONE: f64 = 1e-15;

/// Steps of Newton's iteration; from stretches within a factor of ten, seven do.
const NEWTON_STEPS: usize = 16;

/// The proper rotation R nearest to F, that of F = R S with S symmetric; for an inverted F (det F < 0) the axis of the smallest
/// stretch counts as the inverted one. Two equal smallest stretches of an inverted F leave a choice, which falls alike
/// every time.
///
/// Newton's iteration X ← (X + X⁻ᵀ)/2 (Higham 1986) for well shaped F, [`SignedSvd`] for the others.
#[inline(always)]
pub fn rotation_of(f: &Matrix3<f64>) -> Matrix3<f64> {
    let (mut cofactor, mut determinant) = cofactor(f);
    let mean_square = f.norm_squared() / 3.0;
    let limit = WELL_SHAPED * WELL_SHAPED * mean_square * mean_square * mean_square;
    if determinant > 0.0 && determinant * determinant > limit {
        let mut x = *f;
        for _ in 0..NEWTON_STEPS {
            let next = x * 0.5 + cofactor * (0.5 / determinant);
            let change = (next - x).norm_squared();
            x = next;
            if change < NEWTON_DONE {
                return x;
            }
            (cofactor, determinant) = self::cofactor(&x);
        }
    }
    rotation_by_svd(f)
}

/// Apart from the common case.
#[cold]
fn rotation_by_svd(f: &Matrix3<f64>) -> Matrix3<f64> {
    SignedSvd::new(f).rotation()
}

/// ∂(det F)/∂F and det F.
#[inline(always)]
pub fn cofactor(f: &Matrix3<f64>) -> (Matrix3<f64>, f64) {
    let (cofactor, j) = cofactor_of(&columns_of(f));
    (Matrix3::from(cofactor), j)
}

/// As [`cofactor`], of one matrix or of four.
#[inline(always)]
pub(crate) fn cofactor_of<N: Number>([a, b, c]: &Columns<N>) -> (Columns<N>, N) {
    let bc = cross(b, c);
    let j = dot(a, &bc);
    ([bc, cross(c, a), cross(a, b)], j)
}

/// Eigenvalues, in no order, and eigenvectors (columns of a proper rotation) of a symmetric matrix, by cyclic Jacobi rotations
/// from a start that is the end most of the time.
pub fn symmetric_eigen(m: &Matrix3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let mut vectors = four::eigenvectors_of_one(m);
    let mut a = vectors.tr_mul(&(m * vectors));
    for _ in 0..SWEEPS {
        let mut done = true;
        for [p, q] in PAIRS {
            let off = a[(p, q)];
            // Relative to the whole matrix: what is smaller moves no eigenvalue by more than rounding does.
            if off.abs() <= ORTHOGONAL * a.amax() {
                continue;
            }
            done = false;
            let (cosine, sine) = rotation(a[(q, q)] - a[(p, p)], 2.0 * off);
            rotate_columns(&mut a, p, q, cosine, sine);
            let mut rows = a.transpose();
            rotate_columns(&mut rows, p, q, cosine, sine);
            a = rows.transpose();
            rotate_columns(&mut vectors, p, q, cosine, sine);
        }
        if done {
            break;
        }
    }
    (a.diagonal(), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::numbers;

    /// A few operations of rounding on numbers of the size of the matrix.
    const ROUNDING: f64 = 4e-15;

    fn random_matrix(next: &mut impl FnMut() -> f64) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| next())
    }

    fn random_rotation(next: &mut impl FnMut() -> f64) -> Matrix3<f64> {
        let (a, b) = (
            Vector3::from_fn(|_, _| next()),
            Vector3::from_fn(|_, _| next()),
        );
        let x = a.normalize();
        let y = (b - x * x.dot(&b)).normalize();
        let y = (y - x * x.dot(&y)).normalize();
        Matrix3::from_columns(&[x, y, x.cross(&y)])
    }

    /// Random matrices and those that are hard: repeated, tiny and vanishing singular values, reflections, extreme sizes.
    fn matrices() -> Vec<Matrix3<f64>> {
        let mut next = numbers();
        let mut all = Vec::new();
        for _ in 0..300 {
            all.push(random_matrix(&mut next));
        }
        for stretches in [
            [1.0, 1.0, 1.0],
            [1.0, 1.0, -1.0],
            [2.0, 2.0, 0.5],
            [2.0, 0.5, 0.5],
            [2.0, 0.5, -0.5],
            [1.0, 1e-9, 1e-9],
            [1.0, 1e-9, -1e-14],
            [1.0, 1.0 - 1e-12, 1.0 - 2e-12],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1e-170, 1e-200],
            [0.0, 0.0, 0.0],
            [1e-250, 1e-251, 1e-252],
            [1e200, 3e199, -1e199],
        ] {
            let diagonal = Matrix3::from_diagonal(&Vector3::from(stretches));
            all.push(diagonal);
            for _ in 0..10 {
                let (u, v) = (random_rotation(&mut next), random_rotation(&mut next));
                all.push(u * diagonal * v.transpose());
            }
        }
        all
    }

    fn is_rotation(r: &Matrix3<f64>) -> bool {
        (r.transpose() * r - Matrix3::identity()).amax() < ROUNDING && r.determinant() > 0.0
    }

    #[test]
    fn the_signed_decomposition_restores_the_matrix() {
        for f in matrices() {
            let svd = SignedSvd::new(&f);
            let restored = svd.u * Matrix3::from_diagonal(&svd.stretches) * svd.v.transpose();
            assert!((restored - f).amax() <= ROUNDING * f.amax(), "{f} {svd:?}");
            assert!(is_rotation(&svd.u) && is_rotation(&svd.v), "{f} {svd:?}");
            let s = svd.stretches;
            // Equal up to rounding counts as descending.
            let slack = ROUNDING * s[0];
            assert!(
                s[0] >= 0.0 && s[0] + slack >= s[1] && s[1] + slack >= s[2].abs(),
                "{s}"
            );
        }
    }

    #[test]
    fn four_at_once_are_as_those_of_one() {
        let mut all = matrices();
        // Near rest, where the work is.
        let mut next = numbers();
        for size in [0.0, 1e-12, 1e-6, 1e-2, 0.3] {
            for _ in 0..40 {
                let strain = random_matrix(&mut next) * size;
                all.push(random_rotation(&mut next) * (Matrix3::identity() + strain));
            }
        }
        let mut direct = 0;
        for f in all.as_chunks::<LANES>().0 {
            let columns = four_columns(f);
            let (_, is_exact) = four::direct(&columns);
            direct += is_exact.into_iter().filter(|is_exact| *is_exact).count();
            let svds = FourSvds::new(&columns);
            for (lane, f) in f.iter().enumerate() {
                let svd = svds.of(lane);
                let bound = 3.0 * (four::COSINE + ROUNDING) * f.amax();
                let diagonal = Matrix3::from_diagonal(&svd.stretches);
                let error = (svd.u * diagonal * svd.v.transpose() - f).amax();
                assert!(error <= bound, "{f} {svd:?}");
                assert!(is_rotation(&svd.u) && is_rotation(&svd.v), "{f} {svd:?}");
                let difference = (SignedSvd::new(f).stretches - svd.stretches).amax();
                assert!(difference <= bound, "{f} {svd:?}");
            }
        }
        assert!(direct > all.len() / 2, "{direct} of {}", all.len());
    }

    #[test]
    fn small_singular_values_keep_their_digits() {
        // Columns of very different size: exact to relative rounding with one-sided Jacobi (Demmel & Veselić 1992), lost with
        // an eigen-decomposition of FᵀF.
        let mut next = numbers();
        for _ in 0..50 {
            let sizes = Vector3::new(1.0, 1e-7, -1e-13);
            let f = random_rotation(&mut next) * Matrix3::from_diagonal(&sizes);
            let error = SignedSvd::new(&f).stretches.component_div(&sizes) - Vector3::repeat(1.0);
            assert!(error.amax() < ROUNDING, "{error}");
        }
    }

    #[test]
    fn the_rotation_is_that_of_the_polar_decomposition() {
        for f in matrices() {
            let r = rotation_of(&f);
            assert!(is_rotation(&r), "{f} {r}");
            let s = r.transpose() * f;
            assert!(
                (s - s.transpose()).amax() <= ROUNDING * f.amax(),
                "RᵀF is symmetric: {f} {s}"
            );
            let trace = SignedSvd::new(&f).stretches.sum();
            assert!(
                (s.trace() - trace).abs() <= ROUNDING * f.amax(),
                "and has the signed singular values"
            );
        }
    }

    #[test]
    fn both_ways_to_the_rotation_agree() {
        let mut next = numbers();
        for _ in 0..300 {
            let f = Matrix3::identity() + random_matrix(&mut next) * 0.6;
            let [smallest, second] = [2, 1].map(|k| SignedSvd::new(&f).stretches[k]);
            // The rotation reacts to rounding by 1/(σ2 + σ3).
            let error = (rotation_of(&f) - SignedSvd::new(&f).rotation()).amax();
            assert!(error * (smallest + second) < 2.0 * ROUNDING, "{f} {error}");
        }
    }

    #[test]
    fn eigenvalues_and_vectors_of_symmetric_matrices() {
        for f in matrices() {
            let m = f + f.transpose();
            let (values, vectors) = symmetric_eigen(&m);
            let restored = vectors * Matrix3::from_diagonal(&values) * vectors.transpose();
            assert!((restored - m).amax() <= ROUNDING * m.amax(), "{m}");
            assert!(is_rotation(&vectors), "{m} {vectors}");
        }
    }

    #[test]
    fn the_cofactor_is_the_derivative_of_the_determinant() {
        for f in matrices().into_iter().take(100) {
            let (cofactor, determinant) = cofactor(&f);
            // Laplace: cof(F)ᵀ F = det F.
            let error = cofactor.transpose() * f - Matrix3::identity() * determinant;
            assert!(error.amax() < ROUNDING, "{error}");
            assert!((determinant - f.determinant()).abs() < ROUNDING);
        }
    }

    #[test]
    fn what_is_not_finite_shows_without_panic() {
        let mut f = Matrix3::identity();
        f[(1, 2)] = f64::NAN;
        assert!(!SignedSvd::new(&f).stretches.iter().all(|s| s.is_finite()));
        let _ = rotation_of(&f);
        assert!(!symmetric_eigen(&f).0.iter().all(|s| s.is_finite()));
    }
}
