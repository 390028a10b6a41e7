//! Preconditioned conjugate gradients (Hestenes and Stiefel 1952).

use nalgebra::Vector3;

/// How a run of [`ConjugateGradients`] ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CgOutcome {
    /// Products with the matrix, without the first, which forms the residual of the initial guess.
    pub iterations: usize,
    /// |b − A x| / |b|, from the recurrence; 0 for b = 0.
    pub residual: f64,
    /// Whether the residual is at most the tolerance.
    pub converged: bool,
    /// A direction p with p·A p ≤ 0, or not finite, ended it: A is not positive definite. The node with the largest contribution to that;
    /// `x` is the last iterate before. With r·C⁻¹ r ≤ 0 it ends too, and only has not converged: C is not positive definite.
    pub negative_curvature: Option<usize>,
}

/// Working memory of the method.
#[derive(Clone, Debug)]
pub struct ConjugateGradients {
    /// The residual b − A x.
    r: Vec<Vector3<f64>>,
    /// C⁻¹ r.
    z: Vec<Vector3<f64>>,
    /// The direction.
    p: Vec<Vector3<f64>>,
    /// A p.
    q: Vec<Vector3<f64>>,
}

impl ConjugateGradients {
    /// For vectors of `nodes` nodes.
    pub fn new(nodes: usize) -> Self {
        let zeros = vec![Vector3::zeros(); nodes];
        Self {
            r: zeros.clone(),
            z: zeros.clone(),
            p: zeros.clone(),
            q: zeros,
        }
    }

    /// Solves A x = b from the initial guess in `x`, until |b − A x| ≤ `tolerance` |b|.
    ///
    /// `apply(p, q)` sets q = A p, `precondition(r, z)` sets z = C⁻¹ r; both symmetric positive definite. `tolerance` has
    /// no unit.
    ///
    /// # Panics
    /// When `b` or `x` does not have one entry per node.
    pub fn solve(
        &mut self,
        mut apply: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
        mut precondition: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
        b: &[Vector3<f64>],
        x: &mut [Vector3<f64>],
        tolerance: f64,
        max_iterations: usize,
    ) -> CgOutcome {
        let Self { r, z, p, q } = self;
        assert_eq!(
            (b.len(), x.len()),
            (r.len(), r.len()),
            "one vector per node"
        );
        let scale = dot(b, b).sqrt();
        let mut outcome = CgOutcome {
            iterations: 0,
            residual: 0.0,
            converged: true,
            negative_curvature: None,
        };
        if scale == 0.0 {
            x.fill(Vector3::zeros());
            return outcome;
        }
        r.copy_from_slice(b);
        if x.iter().any(|x| *x != Vector3::zeros()) {
            apply(x, q);
            r.iter_mut().zip(&*q).for_each(|(r, q)| *r -= q);
        }
        let mut rz = 0.0;
        loop {
            outcome.residual = dot(r, r).sqrt() / scale;
            outcome.converged = outcome.residual <= tolerance;
            if outcome.converged || outcome.iterations == max_iterations {
                return outcome;
            }
            precondition(r, z);
            let next = dot(r, z);
            if next <= 0.0 || next.is_nan() {
                return outcome;
            }
            let beta = if outcome.iterations == 0 {
                0.0
            } else {
                next / rz
            };
            rz = next;
            p.iter_mut().zip(&*z).for_each(|(p, z)| *p = z + *p * beta);
            apply(p, q);
            outcome.iterations += 1;
            let curvature = dot(p, q);
            if curvature <= 0.0 || !curvature.is_finite() {
                let contribution = |node: &usize| p[*node].dot(&q[*node]);
                let lowest =
                    (0..p.len()).min_by(|a, b| contribution(a).total_cmp(&contribution(b)));
                outcome.negative_curvature = lowest;
                return outcome;
            }
            let alpha = rz / curvature;
            x.iter_mut().zip(&*p).for_each(|(x, p)| *x += p * alpha);
            r.iter_mut().zip(&*q).for_each(|(r, q)| *r -= q * alpha);
        }
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::testing::{bits, elastic, grid, vectors};
    use crate::{BlockMatrix, Factor, Ordering, Symbolic};
    use microsim_random::Congruential;

    fn copy(r: &[Vector3<f64>], z: &mut [Vector3<f64>]) {
        z.copy_from_slice(r);
    }

    /// Divides by the diagonal blocks.
    fn jacobi(matrix: &BlockMatrix) -> impl Fn(&[Vector3<f64>], &mut [Vector3<f64>]) {
        let nodes = 0..matrix.pattern().nodes();
        let inverses: Vec<_> = nodes
            .map(|node| matrix.diagonal(node).try_inverse().unwrap())
            .collect();
        move |r, z| {
            for ((inverse, r), z) in inverses.iter().zip(r).zip(z) {
                *z = inverse * r;
            }
        }
    }

    /// Solves with new working memory.
    fn conjugate_gradients(
        apply: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
        precondition: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
        b: &[Vector3<f64>],
        x: &mut [Vector3<f64>],
        tolerance: f64,
        max_iterations: usize,
    ) -> CgOutcome {
        ConjugateGradients::new(b.len()).solve(apply, precondition, b, x, tolerance, max_iterations)
    }

    /// A bar held at one end, its stiffness growing 10⁴-fold towards the other.
    fn bar() -> (BlockMatrix, Vec<Vector3<f64>>) {
        let (positions, edges) = grid([12, 3, 3]);
        let mut matrix = elastic(&positions, &edges);
        let scale = |node: usize| 1.0 + 99.0 * (positions[node].x / 11.0).powi(3);
        for i in 0..positions.len() {
            for k in 0..matrix.pattern().row(i).len() {
                let j = matrix.pattern().row(i)[k] as usize;
                let slot = matrix.pattern().first_slot(i) + k;
                matrix.values_mut()[slot] *= scale(i) * scale(j);
            }
        }
        let fixed: Vec<bool> = positions.iter().map(|position| position.x == 0.0).collect();
        matrix.constrain(&fixed);
        (matrix, vectors(&mut Congruential(21), positions.len()))
    }

    #[test]
    fn agrees_with_the_factor() {
        let (matrix, b) = bar();
        let ordering = Ordering::natural(b.len());
        let mut factor =
            Factor::<f64>::new(Arc::new(Symbolic::analyse(matrix.pattern(), &ordering)));
        factor.factorise(&matrix, None).unwrap();
        let mut expected = b.clone();
        factor.solve(&mut expected);
        let jacobi = jacobi(&matrix);
        let tolerance = 1e-11;
        let mut x = vec![Vector3::zeros(); b.len()];
        let apply = |x: &[Vector3<f64>], y: &mut [Vector3<f64>]| matrix.multiply(x, y);
        let outcome = conjugate_gradients(apply, &jacobi, &b, &mut x, tolerance, 3000);
        assert!(
            outcome.converged
                && outcome.negative_curvature.is_none()
                && outcome.residual <= tolerance
        );
        // |x − x*| = |A⁻¹ r| ≤ tolerance |b| / λ_min; twice for the rounding of both.
        let smallest = crate::testing::dense(&matrix).symmetric_eigenvalues().min();
        let difference: Vec<_> = x.iter().zip(&expected).map(|(x, e)| x - e).collect();
        assert!(
            dot(&difference, &difference).sqrt() <= 2.0 * tolerance * dot(&b, &b).sqrt() / smallest
        );
        // Without preconditioner it takes longer on a badly scaled matrix.
        let plain = conjugate_gradients(
            apply,
            copy,
            &b,
            &mut vec![Vector3::zeros(); b.len()],
            tolerance,
            3000,
        );
        assert!(
            plain.iterations > 2 * outcome.iterations,
            "{} {}",
            plain.iterations,
            outcome.iterations
        );
        // From the solution nothing is left to do; and the same bits come again.
        assert_eq!(
            conjugate_gradients(apply, copy, &b, &mut x.clone(), 1e-10, 10).iterations,
            0
        );
        let mut again = vec![Vector3::zeros(); b.len()];
        conjugate_gradients(apply, &jacobi, &b, &mut again, tolerance, 3000);
        assert_eq!(bits(&again), bits(&x));
    }

    #[test]
    fn one_iteration_for_separate_nodes() {
        let matrix = crate::testing::random_matrix(&mut Congruential(22), 9, 0, 0.7);
        let jacobi = jacobi(&matrix);
        let b = vectors(&mut Congruential(23), 9);
        let mut x = vectors(&mut Congruential(24), 9);
        let apply = |x: &[Vector3<f64>], y: &mut [Vector3<f64>]| matrix.multiply(x, y);
        let outcome = conjugate_gradients(apply, &jacobi, &b, &mut x, 1e-14, 5);
        assert_eq!((outcome.iterations, outcome.converged), (1, true));
    }

    #[test]
    fn stops_at_negative_curvature_at_the_limit_and_at_zero() {
        let b = [Vector3::new(1.0, 1.0, 1.0)];
        let indefinite = |x: &[Vector3<f64>], y: &mut [Vector3<f64>]| {
            y[0] = Vector3::new(x[0].x, x[0].y, -3.0 * x[0].z)
        };
        let mut x = [Vector3::zeros()];
        let outcome = conjugate_gradients(indefinite, copy, &b, &mut x, 1e-10, 9);
        assert!(outcome.negative_curvature == Some(0) && !outcome.converged);
        assert_eq!(
            x[0],
            Vector3::zeros(),
            "the last iterate before: p·A p = −1 at once"
        );

        let nan = |_: &[Vector3<f64>], y: &mut [Vector3<f64>]| y[0] = Vector3::repeat(f64::NAN);
        assert!(!conjugate_gradients(nan, copy, &b, &mut x, 1e-10, 9).converged);

        let negative = |r: &[Vector3<f64>], z: &mut [Vector3<f64>]| z[0] = -r[0];
        let outcome = conjugate_gradients(copy, negative, &b, &mut x, 1e-10, 9);
        assert!(outcome.negative_curvature.is_none() && !outcome.converged);

        let scaled = |x: &[Vector3<f64>], y: &mut [Vector3<f64>]| {
            y[0] = x[0].component_mul(&Vector3::new(1.0, 2.0, 3.0))
        };
        let outcome = conjugate_gradients(scaled, copy, &b, &mut x, 1e-10, 2);
        assert!(
            !outcome.converged && outcome.iterations == 2,
            "three eigenvalues take three iterations"
        );
        assert!(conjugate_gradients(scaled, copy, &b, &mut x, 1e-10, 3).converged);

        let outcome = conjugate_gradients(scaled, copy, &[Vector3::zeros()], &mut x, 1e-10, 3);
        assert_eq!(
            (outcome.converged, outcome.residual, x[0]),
            (true, 0.0, Vector3::zeros())
        );
    }
}
