//! Least squares: searches of the Levenberg–Marquardt method (Moré 1978, crate `levenberg-marquardt`) from many starts.
//!
//! Sums of squares of laws with an exponential have several minima. Starts are the first points of a Halton sequence, which fill the ranges
//! of all constants evenly, so that the same data give the same constants.

use crate::measurements::Measurements;
use crate::model::LawModel;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_search::storage::Owned;
use nalgebra_search::{DMatrix, DVector, Dyn};

/// Searches.
const STARTS: usize = 24;
/// Evaluations of a search per constant and one more: four times MINPACK's default for problems whose valleys are curved.
const PATIENCE: usize = 400;
/// Difference of coordinates for derivatives: the cube root of the rounding unit, best for central ones.
const DIFFERENCE: f64 = 6e-6;
/// Bases of the Halton sequence: more than a law has constants.
const BASES: [u32; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
/// What residuals count as, relative to the data, where nothing can be computed.
const NOTHING: f64 = 1e3;

/// Where a search ended.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Minimum {
    /// All constants, the fixed ones too.
    pub values: Vec<f64>,
    /// Root mean square of the residuals \[Pa\].
    pub rms: f64,
}

/// A search: some constants are free.
pub(crate) struct Search<'a> {
    pub model: &'a LawModel,
    pub data: &'a Measurements,
    /// Measured stresses \[Pa\].
    pub measured: Vec<f64>,
    /// Their root mean square \[Pa\].
    pub scale: f64,
    /// Values of all constants; those of free ones mean nothing.
    pub values: Vec<f64>,
    /// Indices of the free constants.
    pub free: Vec<usize>,
}

impl Search<'_> {
    /// Where all searches ended, the best one first; equal ones in the order of their starts.
    pub fn minima(&self) -> Vec<Minimum> {
        let mut minima: Vec<Minimum> = (1..=STARTS)
            .filter_map(|index| self.minimum(index))
            .collect();
        minima.sort_by(|a, b| a.rms.total_cmp(&b.rms));
        minima
    }

    fn minimum(&self, index: usize) -> Option<Minimum> {
        let start = self.free.iter().zip(BASES).map(|(constant, base)| {
            let constant = &self.model.constants()[*constant];
            constant.start(radical_inverse(index as u32, base))
        });
        let problem = Least {
            search: self,
            at: DVector::from_iterator(self.free.len(), start),
        };
        let (found, _) = LevenbergMarquardt::new()
            .with_patience(PATIENCE)
            .minimize(problem);
        let values = self.values_at(&found.at);
        let predicted = self.model.stresses(&values, self.data)?;
        let rms = root_mean_square(predicted.iter().zip(&self.measured).map(|(a, b)| a - b));
        Some(Minimum { values, rms })
    }

    fn values_at(&self, coordinates: &DVector<f64>) -> Vec<f64> {
        let mut values = self.values.clone();
        for (index, coordinate) in self.free.iter().zip(coordinates) {
            values[*index] = self.model.constants()[*index].at(*coordinate, self.scale);
        }
        values
    }

    /// Residuals relative to the size of the data.
    fn residuals(&self, coordinates: &DVector<f64>) -> DVector<f64> {
        let count = self.measured.len();
        match self.model.stresses(&self.values_at(coordinates), self.data) {
            Some(predicted) => {
                let pairs = predicted.iter().zip(&self.measured);
                DVector::from_iterator(count, pairs.map(|(a, b)| (a - b) / self.scale))
            }
            None => DVector::repeat(count, NOTHING),
        }
    }
}

/// The problem as the method takes it.
struct Least<'a> {
    search: &'a Search<'a>,
    at: DVector<f64>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Least<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, at: &DVector<f64>) {
        self.at.copy_from(at);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.search.residuals(&self.at))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns: Vec<DVector<f64>> = (0..self.at.len())
            .map(|index| {
                let beside = |change: f64| {
                    let mut at = self.at.clone();
                    at[index] += change;
                    self.search.residuals(&at)
                };
                (beside(DIFFERENCE) - beside(-DIFFERENCE)) / (2.0 * DIFFERENCE)
            })
            .collect();
        Some(DMatrix::from_columns(&columns))
    }
}

/// Of some numbers.
pub(crate) fn root_mean_square(numbers: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = numbers.len() as f64;
    (numbers.map(|x| x * x).sum::<f64>() / count).sqrt()
}

/// The digits of a number behind the point, in reverse: a number of the Halton sequence, in 0..1.
fn radical_inverse(mut number: u32, base: u32) -> f64 {
    let (mut inverse, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= f64::from(base);
        inverse += f64::from(number % base) * digit;
        number /= base;
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sequence as Halton (1960) has it.
    #[test]
    fn starts_are_halton_s() {
        let first: Vec<f64> = (1..=5).map(|n| radical_inverse(n, 2)).collect();
        assert_eq!(first, [0.5, 0.25, 0.75, 0.125, 0.625]);
        assert!((radical_inverse(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }
}
