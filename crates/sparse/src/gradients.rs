//! Preconditioned conjugate gradients (Hestenes and Stiefel 1952) and the block-Jacobi preconditioner.

use nalgebra::{Matrix3, Vector3};

use crate::{BlockMatrix, NotPositive};

/// How a run of [`conjugate_gradients`] ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CgOutcome {
    /// Products with the matrix, without the first, which forms the residual of the initial guess.
    pub iterations: usize,
    /// |b − A x| / |b|, from the recurrence; 0 for b = 0.
    pub residual: f64,
    /// Whether the residual is at most the tolerance.
    pub converged: bool,
    /// Whether a direction p with p·A p ≤ 0, or not finite, ended it, or r·C⁻¹ r ≤ 0: A or the preconditioner C is not
    /// positive definite. `x` is the last iterate before.
    pub negative_curvature: bool,
}

/// Solves A x = b from the initial guess in `x`, until |b − A x| ≤ `tolerance` |b|.
///
/// `apply(p, q)` sets q = A p, `precondition(r, z)` sets z = C⁻¹ r; both symmetric positive definite. `tolerance` has
/// no unit.
///
/// # Panics
/// When `b` and `x` differ in length.
pub fn conjugate_gradients(
    mut apply: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
    mut precondition: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
    b: &[Vector3<f64>],
    x: &mut [Vector3<f64>],
    tolerance: f64,
    max_iterations: usize,
) -> CgOutcome {
    assert_eq!(b.len(), x.len(), "one vector per node");
    let scale = dot(b, b).sqrt();
    let mut outcome = CgOutcome { iterations: 0, residual: 0.0, converged: true, negative_curvature: false };
    if scale == 0.0 {
        x.fill(Vector3::zeros());
        return outcome;
    }
    let mut q = vec![Vector3::zeros(); b.len()];
    apply(x, &mut q);
    let mut r: Vec<Vector3<f64>> = b.iter().zip(&q).map(|(b, q)| b - q).collect();
    let mut z = vec![Vector3::zeros(); b.len()];
    let mut p = z.clone();
    let mut rz = 0.0;
    loop {
        outcome.residual = dot(&r, &r).sqrt() / scale;
        outcome.converged = outcome.residual <= tolerance;
        if outcome.converged || outcome.iterations == max_iterations {
            return outcome;
        }
        precondition(&r, &mut z);
        let next = dot(&r, &z);
        if !(next > 0.0) {
            outcome.negative_curvature = true;
            return outcome;
        }
        let beta = if outcome.iterations == 0 { 0.0 } else { next / rz };
        rz = next;
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + *p * beta);
        apply(&p, &mut q);
        outcome.iterations += 1;
        let curvature = dot(&p, &q);
        if !(curvature > 0.0 && curvature < f64::INFINITY) {
            outcome.negative_curvature = true;
            return outcome;
        }
        let alpha = rz / curvature;
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += p * alpha);
        r.iter_mut().zip(&q).for_each(|(r, q)| *r -= q * alpha);
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// The inverses of the diagonal blocks.
#[derive(Clone, Debug)]
pub struct BlockJacobi {
    inverses: Vec<Matrix3<f64>>,
}

impl BlockJacobi {
    /// Inverts the diagonal blocks; those of nodes marked in `fixed` count as the identity.
    ///
    /// # Errors
    /// When a diagonal block is not positive definite or not finite.
    pub fn new(matrix: &BlockMatrix, fixed: Option<&[bool]>) -> Result<Self, NotPositive> {
        let invert = |node: usize| {
            if fixed.is_some_and(|fixed| fixed[node]) {
                return Ok(Matrix3::identity());
            }
            let inverse = matrix.diagonal(node).cholesky().map(|factor| factor.inverse());
            inverse.filter(|inverse| inverse.iter().all(|v| v.is_finite())).ok_or(NotPositive { node })
        };
        Ok(Self { inverses: (0..matrix.pattern().nodes()).map(invert).collect::<Result<_, _>>()? })
    }

    /// z = C⁻¹ r.
    pub fn apply(&self, r: &[Vector3<f64>], z: &mut [Vector3<f64>]) {
        for ((inverse, r), z) in self.inverses.iter().zip(r).zip(z) {
            *z = inverse * r;
        }
    }
}
