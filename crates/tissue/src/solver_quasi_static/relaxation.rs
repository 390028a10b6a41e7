//! Aitken's relaxation of a fixed-point iteration.

use nalgebra::Vector3;

/// The first factor. An iteration that overshoots by up to three times its error comes nearer with it.
const FIRST: f64 = 0.5;

/// Bounds of the factor. Where an iteration moves off faster and faster it would be negative: there is no limit nearby, and the lower bound goes on with it.
const FACTORS: [f64; 2] = [0.05, 2.0];

/// Aitken's Δ² relaxation of a sequence of vectors (Küttler & Wall 2008): the factor with which the last change would have
/// vanished, were both along one line.
#[derive(Clone, Debug, Default)]
pub(super) struct Relaxation {
    factor: Option<f64>,
    /// The last change, and the one before it \[m\].
    change: Vec<Vector3<f64>>,
    before: Vec<Vector3<f64>>,
}

impl Relaxation {
    /// Begins a sequence.
    pub fn begin(&mut self) {
        self.factor = None;
    }

    /// Moves `guess` by a multiple of the change to what the iteration has made of it \[m\]. Returns the largest displacement of a node in the
    /// change itself \[m\].
    pub fn relax(&mut self, guess: &mut [Vector3<f64>], mapped: &[Vector3<f64>]) -> f64 {
        std::mem::swap(&mut self.change, &mut self.before);
        self.change.clear();
        let changes = mapped.iter().zip(&*guess).map(|(y, x)| y - x);
        self.change.extend(changes);
        let factor = match self.factor {
            None => FIRST,
            Some(factor) => {
                let (mut along, mut square) = (0.0, 0.0);
                for (now, before) in self.change.iter().zip(&self.before) {
                    let difference = now - before;
                    along += before.dot(&difference);
                    square += difference.norm_squared();
                }
                let next = -factor * along / square;
                match next.is_finite() {
                    true => next.clamp(FACTORS[0], FACTORS[1]),
                    false => factor,
                }
            }
        };
        self.factor = Some(factor);
        let mut largest = 0.0f64;
        for (x, change) in guess.iter_mut().zip(&self.change) {
            *x += change * factor;
            largest = largest.max(change.norm_squared());
        }
        largest.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::Relaxation;
    use crate::solver_quasi_static::QuasiStaticOptions;
    use nalgebra::Vector3;

    /// How often a linear iteration, whose error is multiplied by `rates` along the axes, is relaxed until the change is at most `enough`.
    fn rounds(rates: [f64; 3], enough: f64) -> usize {
        let limit = [Vector3::new(1.0, -2.0, 3.0)];
        let mut guess = [limit[0] + Vector3::new(0.5, 0.3, -0.4)];
        let mut relaxation = Relaxation::default();
        for round in 1..=60 {
            let error = guess[0] - limit[0];
            let mapped = [limit[0] + error.component_mul(&Vector3::from(rates))];
            if relaxation.relax(&mut guess, &mapped) <= enough {
                // The error after the iteration is r / (r - 1) of the change: of these rates at most all of it, to rounding.
                assert!((mapped[0] - limit[0]).norm() <= 1.01 * enough);
                return round;
            }
        }
        panic!("not within 60 rounds");
    }

    /// The second factor is exact where all of the change lies along one line and it is within its bounds, as with rates from -19 to 0.5: the third round
    /// finds nothing to do.
    #[test]
    fn one_mode_takes_three_rounds() {
        for rate in [-9.0, -3.0, 0.0, 0.4] {
            assert_eq!(rounds([rate; 3], 1e-12), 3, "{rate}");
        }
    }

    /// Without relaxation this iteration would diverge by a factor of 3 in each round. With it the rounds of the solver are enough for its tolerance.
    #[test]
    fn an_iteration_that_overshoots_converges() {
        let options = QuasiStaticOptions::default();
        let taken = rounds([-3.0, 0.5, -0.2], options.consistent[0]);
        assert!(taken <= options.rounds as usize, "{taken}");
    }
}
