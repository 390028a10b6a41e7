//! Dense matrices of a few hundred rows, factored by the kernels of a front.

use crate::factor::{load, store};
use crate::kernels::{factor_panel, solve_backward, solve_forward, triangle_start};
use crate::real::{Octet, WIDTH};

/// Cholesky factor A = L Lᵀ of dense symmetric matrices, with its workspace: nothing is allocated while matrices do not grow.
#[derive(Clone, Debug, Default)]
pub struct DenseFactor {
    /// Rows; none without a factor.
    count: usize,
    /// The lower triangle, filled up to whole strips with rows of the identity.
    strips: Vec<Octet<f64>>,
    least: Vec<f64>,
    x: Vec<Octet<f64>>,
    sums: Vec<Octet<f64>>,
}

impl DenseFactor {
    /// Factors a matrix of `count` rows, row after row; what is above the diagonal is not read.
    ///
    /// # Errors
    /// When a pivot is not positive or not finite, with its row; there is no factor then.
    ///
    /// # Panics
    /// When the matrix is not square.
    pub fn factorise(&mut self, matrix: &[f64], count: usize) -> Result<(), usize> {
        assert_eq!(matrix.len(), count * count, "a square matrix");
        self.count = 0;
        let triangle = count.div_ceil(WIDTH);
        self.strips.clear();
        self.strips.resize(triangle_start(triangle), Octet::ZERO);
        for row in 0..WIDTH * triangle {
            let (strip, lane) = (&mut self.strips[triangle_start(row / WIDTH)..], row % WIDTH);
            if row < count {
                let entries = &matrix[row * count..][..=row];
                for (octet, entry) in strip.iter_mut().zip(entries) {
                    octet.0[lane] = *entry;
                }
            } else {
                strip[row].0[lane] = 1.0;
            }
        }
        self.least.resize(WIDTH * triangle, 0.0);
        factor_panel(&mut self.strips, triangle, &self.least)?;
        self.count = count;
        Ok(())
    }

    /// Solves A x = b in place.
    ///
    /// # Panics
    /// When the last factorisation failed or there was none, or `x` does not have one number per row.
    pub fn solve(&mut self, x: &mut [f64]) {
        assert_eq!(x.len(), self.count, "one number per row of the factor");
        if self.count == 0 {
            return;
        }
        let triangle = self.count.div_ceil(WIDTH);
        self.x.resize(triangle, Octet::ZERO);
        self.sums.resize(WIDTH * triangle, Octet::ZERO);
        load(&mut self.x, x);
        solve_forward(&self.strips, &mut self.x, &mut []);
        solve_backward(&self.strips, &mut self.x, &[], &mut self.sums);
        store(&self.x, x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_random::Congruential;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn solutions_are_those_of_another_factor() {
        let mut random = Congruential(3);
        let mut factor = DenseFactor::default();
        // Larger and smaller in turn: what is left of the one before has no effect.
        for count in [1, 40, 7, 8, 9, 33, 100, 2] {
            let half = DMatrix::from_fn(count, count, |_, _| random.number());
            let matrix = &half * half.transpose() + DMatrix::identity(count, count);
            let b = DVector::from_fn(count, |_, _| random.number());
            let expected = matrix.clone().cholesky().expect("definite").solve(&b);
            // Above the diagonal anything may stand.
            let rows = DMatrix::from_fn(count, count, |column, row| {
                if column > row {
                    f64::NAN
                } else {
                    matrix[(row, column)]
                }
            });
            factor.factorise(rows.as_slice(), count).expect("definite");
            let mut x = b.clone();
            factor.solve(x.as_mut_slice());
            // Wilkinson: rounding of either, relative, is below a few count ε times the condition number, here below 1 + count².
            let condition = 1.0 + (count * count) as f64;
            let bound = 8.0 * count as f64 * f64::EPSILON * condition * expected.norm();
            assert!((x - expected).norm() <= bound, "{count} rows");
        }
    }

    #[test]
    fn what_is_not_positive_has_no_factor() {
        let mut factor = DenseFactor::default();
        assert_eq!(factor.factorise(&[1.0, 0.0, 2.0, 3.0], 2), Err(1));
        assert_eq!(factor.factorise(&[f64::NAN], 1), Err(0));
        assert_eq!(factor.factorise(&[f64::INFINITY], 1), Err(0));
        assert_eq!(factor.factorise(&[], 0), Ok(()));
        factor.solve(&mut []);
    }
}
