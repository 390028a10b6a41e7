//! How well data determine constants: intervals of confidence and correlations from the derivatives of the residuals.
//!
//! Linearised at the least squares the constants have the covariance s² (JᵀJ)⁻¹ with s² = Σr²/(N − n) and J the derivatives of the N stresses
//! by the n constants (Seber & Wild 2003, 5.1). It holds for errors of measurement that are independent and of one size.

use nalgebra::DMatrix;

/// Singular values below this, relative to the largest one of columns of length 1, are those of combinations that the data do not determine:
/// derivatives by differences have about eight digits.
const SINGULAR: f64 = 1e-6;
/// Smallest part of a constant in such a combination that makes it undetermined.
const PART: f64 = 0.1;

/// What the derivatives give.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Confidence {
    /// Half of the interval of 95 % of each constant, in SI; `None` where the data do not determine it.
    pub half_widths: Vec<Option<f64>>,
    /// Coefficients of correlation of pairs of constants, the first one's index below the second one's.
    pub correlations: Vec<(usize, usize, f64)>,
}

impl Confidence {
    /// From the derivatives \[Pa per unit\], one column per constant, and the root mean square of the residuals \[Pa\].
    pub fn new(derivatives: &DMatrix<f64>, rms: f64) -> Self {
        let (rows, constants) = derivatives.shape();
        if constants == 0 {
            return Self {
                half_widths: Vec::new(),
                correlations: Vec::new(),
            };
        }
        let freedom = rows - constants;
        let variance = rms * rms * rows as f64 / freedom as f64;
        let lengths: Vec<f64> = derivatives.column_iter().map(|c| c.norm()).collect();
        let mut scaled = derivatives.clone();
        for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
            if *length > 0.0 {
                column /= *length;
            }
        }
        // Of JᵀJ, which has the squares of the singular values.
        let eigen = (scaled.transpose() * &scaled).symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let mut covariance = DMatrix::zeros(constants, constants);
        let mut determined: Vec<bool> = lengths.iter().map(|length| *length > 0.0).collect();
        for (value, vector) in eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
        {
            if *value > SINGULAR * SINGULAR * largest {
                covariance += vector * vector.transpose() / *value;
            } else {
                for (determined, part) in determined.iter_mut().zip(vector.iter()) {
                    *determined &= part.abs() < PART;
                }
            }
        }
        let factor = student_95(freedom) * variance.sqrt();
        let half_width = |index: usize| {
            let width = factor * covariance[(index, index)].sqrt() / lengths[index];
            determined[index].then_some(width)
        };
        let mut correlations = Vec::new();
        for first in 0..constants {
            for second in first + 1..constants {
                let product = covariance[(first, first)] * covariance[(second, second)];
                if determined[first] && determined[second] {
                    let correlation = covariance[(first, second)] / product.sqrt();
                    correlations.push((first, second, correlation));
                }
            }
        }
        Self {
            half_widths: (0..constants).map(half_width).collect(),
            correlations,
        }
    }
}

/// The t of Student's distribution that 95 % lie within, by the expansion about the normal one (Abramowitz & Stegun 26.7.5): its error is
/// 0.13 % with three degrees of freedom, and falls as their fifth power.
fn student_95(freedom: usize) -> f64 {
    let z = 1.959_963_984_540_054;
    let n = freedom as f64;
    let x = z * z;
    let terms = [
        (x + 1.0) / 4.0,
        ((5.0 * x + 16.0) * x + 3.0) / 96.0,
        (((3.0 * x + 19.0) * x + 17.0) * x - 15.0) / 384.0,
        ((((79.0 * x + 776.0) * x + 1482.0) * x - 1920.0) * x - 945.0) / 92_160.0,
    ];
    let series = terms.iter().rev().fold(0.0, |sum, term| (sum + term) / n);
    z * (1.0 + series)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the table of Abramowitz & Stegun (26.10).
    #[test]
    fn student_s_t_is_that_of_the_table() {
        for (freedom, expected, error) in [
            (3, 3.182, 2e-3),
            (5, 2.571, 4e-4),
            (10, 2.228, 3e-4),
            (30, 2.042, 3e-4),
            (100_000, 1.960, 1e-4),
        ] {
            let t = student_95(freedom);
            assert!((t / expected - 1.0).abs() < error, "{freedom}: {t}");
        }
    }

    /// A straight line through (x, y): the textbook's standard errors of intercept and slope are s √(Σx²/(N Σ(x − x̄)²)) and
    /// s/√Σ(x − x̄)², their correlation −x̄/√(Σx²/N). x = 1, 2, 3, 4, 5: x̄ = 3, Σx² = 55, Σ(x − x̄)² = 10.
    #[test]
    fn intervals_of_a_line_are_those_of_the_textbook() {
        let x = [1.0, 2.0, 3.0, 4.0, 5.0];
        let derivatives = DMatrix::from_fn(5, 2, |row, column| [1.0, x[row]][column]);
        let rms = 0.3;
        let s = (0.09 * 5.0 / 3.0_f64).sqrt();
        let confidence = Confidence::new(&derivatives, rms);
        let expected = [s * (55.0 / 50.0_f64).sqrt(), s / 10.0_f64.sqrt()];
        for (half, expected) in confidence.half_widths.iter().zip(expected) {
            let half = half.expect("determined");
            assert!((half / (student_95(3) * expected) - 1.0).abs() < 1e-12);
        }
        let [(0, 1, correlation)] = confidence.correlations[..] else {
            panic!("{confidence:?}");
        };
        assert!((correlation + 3.0 / 11.0_f64.sqrt()).abs() < 1e-12);
    }

    /// Of two constants that act as their sum alone, neither is determined; a third one is. One without effect is not either.
    #[test]
    fn what_acts_as_a_sum_alone_is_not_determined() {
        let derivatives = DMatrix::from_fn(6, 4, |row, column| {
            let x = row as f64;
            [x, 2.0 * x, 1.0, 0.0][column]
        });
        let found = Confidence::new(&derivatives, 1.0);
        let determined: Vec<bool> = found.half_widths.iter().map(Option::is_some).collect();
        assert_eq!(determined, [false, false, true, false]);
        assert_eq!(found.correlations, []);
    }
}
