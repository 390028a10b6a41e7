//! The line search along the path of an iteration, and the potential Φ that it descends.

use super::equation::Problem;
use super::workspace::NewtonSolver;
use nalgebra::Vector3;

/// Φ \[J\] and the sum of the absolute values of its terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Potential {
    pub value: f64,
    size: f64,
}

/// What a line search ended with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LineSearchOutcome {
    /// Prescribed nodes are at their ends, the others went along: there was no search.
    Prescribed,
    /// A step was taken.
    Step {
        /// Its length, over that of Newton's method.
        length: f64,
        /// Whether the search did not back off; a step that was shortened because it went beyond the lowest point is one that could have been longer.
        is_full: bool,
    },
    /// No step length descends.
    NoDescent,
}

impl LineSearchOutcome {
    fn taken(length: f64) -> Self {
        Self::Step {
            length,
            is_full: length == 1.0,
        }
    }
}

impl NewtonSolver {
    /// Φ at `trial`; the work of n is that on the path from the start of the iteration.
    pub(super) fn potential(&mut self, problem: &Problem<'_>) -> Potential {
        let model = problem.model;
        let elastic = self.energy.compute(model, &self.trial);
        let (mut inertia, mut work) = (0.0, 0.0);
        for (node, x) in self.trial.positions.iter().enumerate() {
            if problem.fixed[node] {
                continue;
            }
            work += self.loads[node].dot(&(x - self.from[node]));
            if problem.equation.rate > 0.0 {
                let v = self.trial.velocities[node];
                let change = v - problem.equation.base_velocities[node];
                let drag = self.drags[node] / problem.equation.rate;
                inertia +=
                    0.5 * model.inertia(node) * (change.norm_squared() + drag * v.norm_squared());
            }
        }
        for (node, spring) in problem.equation.regularisation.iter().enumerate() {
            let displacement = self.trial.positions[node] - problem.equation.base[node];
            inertia += 0.5 * spring * displacement.norm_squared();
        }
        let contact = self.contacts.energy(&self.trial.positions);
        Potential {
            value: elastic + inertia + contact - work,
            size: elastic.abs() + inertia + contact + work.abs(),
        }
    }

    /// Sets `trial` to the point at the step length `length` from the start of the iteration.
    pub(super) fn advance(&mut self, problem: &Problem<'_>, length: f64) {
        for (((x, from), d), c) in self
            .trial
            .positions
            .iter_mut()
            .zip(&self.from)
            .zip(&self.direction)
            .zip(&self.second_order)
        {
            *x = from + d * length + c * (length * length);
        }
        self.set_velocities(problem);
    }

    /// Searches along the path from the step length `first`, and leaves `trial` at the point that it ended with.
    pub(super) fn search(&mut self, problem: &Problem<'_>, first: f64) -> LineSearchOutcome {
        let options = self.options.line_search;
        let start = self.potential(problem);
        let slope = -dot(&self.residual, &self.direction);
        if slope >= 0.0 || slope.is_nan() {
            return LineSearchOutcome::NoDescent;
        }
        let before = dot(&self.residual, &self.residual);
        let enough = options.sufficient_decrease;
        let mut length = first;
        while length > options.shortest {
            self.advance(problem, length);
            let potential = self.potential(problem);
            let rise = potential.value - start.value;
            if rise <= enough * length * slope {
                return self.without_overshoot(problem, length, slope, potential);
            }
            // Where Φ has no more digits its slope still has. Near rest that is so long before the terms of Φ show it: they are
            // differences themselves. There the forces fall by much.
            let rounding = rise <= options.rounding * (start.size + potential.size);
            if rounding || length == first {
                self.evaluate(problem, 0.0);
                let falls = dot(&self.residual, &self.residual) <= options.force_decrease * before;
                let end = self.slope_at(length);
                if (rounding || falls) && end <= (2.0 * enough - 1.0) * slope {
                    return LineSearchOutcome::taken(length);
                }
            }
            // The lowest point of the parabola through both values and the slope.
            let lowest = -0.5 * slope * length * length / (rise - slope * length);
            let [least, largest, otherwise] = options.shortening;
            length = if lowest.is_finite() {
                lowest.clamp(least * length, largest * length)
            } else {
                otherwise * length
            };
        }
        self.advance(problem, 0.0);
        LineSearchOutcome::NoDescent
    }

    /// The slope of Φ along the path at this step length, from the residual there; with viscous forces and pressures as they are there, which Φ has as they
    /// were at the start.
    fn slope_at(&self, length: f64) -> f64 {
        let path = self.direction.iter().zip(&self.second_order);
        path.zip(&self.residual)
            .map(|((d, c), r)| -r.dot(&(d + c * (2.0 * length))))
            .sum()
    }

    /// Ends a search with a step of this length, or with the shorter one at which a straight slope from `slope` at the start would vanish: where
    /// ties slide, a step may go far beyond the lowest point. The shorter one is taken if it does not lie higher.
    fn without_overshoot(
        &mut self,
        problem: &Problem<'_>,
        length: f64,
        slope: f64,
        at_length: Potential,
    ) -> LineSearchOutcome {
        if problem.model.sets().iter().any(|set| set.slides()) {
            self.evaluate(problem, 0.0);
            let end = self.slope_at(length);
            if end > -self.options.line_search.overshoot * slope {
                let shorter = length * slope / (slope - end);
                self.advance(problem, shorter);
                if self.potential(problem).value <= at_length.value {
                    return LineSearchOutcome::Step {
                        length: shorter,
                        is_full: length == 1.0,
                    };
                }
                self.advance(problem, length);
            }
        }
        LineSearchOutcome::taken(length)
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}
