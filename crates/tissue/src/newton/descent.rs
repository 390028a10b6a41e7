//! The way of one Newton step: the potential Φ, the line search, the jump of prescribed nodes.

use super::{NewtonSolver, Problem};
use nalgebra::Vector3;

/// Share of the predicted decrease of Φ that is enough.
const ENOUGH: f64 = 1e-4;
/// Differences of Φ below this share of its terms are rounding.
const ROUNDING: f64 = 1e-12;
/// The share of its square to which the residual falls on a full step that is taken for its forces alone.
const FALL: f64 = 0.01;
/// The shortest share of a Newton step that is tried.
const SHORTEST: f64 = 1e-8;
/// Shares of the common move that are tried when prescribed nodes jump.
const LIFTS: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0];

/// Φ \[J\] and the sum of the sizes of its terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Potential {
    pub value: f64,
    size: f64,
}

impl NewtonSolver {
    /// Φ at `trial`; the work of n is that on the way from the start of the iteration.
    pub(super) fn potential(&self, problem: &Problem<'_>) -> Potential {
        let model = problem.model;
        let mut elastic = 0.0;
        for (set, elements) in model.sets().iter().enumerate() {
            elastic += elements.energy(&self.trial.configuration(model, set));
        }
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
        for (node, hold) in problem.equation.hold.iter().enumerate() {
            let way = self.trial.positions[node] - problem.equation.base[node];
            inertia += 0.5 * hold * way.norm_squared();
        }
        let touch = self.gaps.energy(&self.trial.positions);
        Potential {
            value: elastic + inertia + touch - work,
            size: elastic.abs() + inertia + touch + work.abs(),
        }
    }

    /// Sets `trial` to `share` of the direction from the start of the iteration.
    pub(super) fn advance(&mut self, problem: &Problem<'_>, share: f64) {
        for (((x, from), d), c) in self
            .trial
            .positions
            .iter_mut()
            .zip(&self.from)
            .zip(&self.direction)
            .zip(&self.bend)
        {
            *x = from + d * share + c * (share * share);
        }
        self.set_velocities(problem);
    }

    /// Prescribed nodes jump to their ends, all others take the share of the direction with which Φ is below that of the jump
    /// alone.
    pub(super) fn lift(&mut self, problem: &Problem<'_>, ends: &[Vector3<f64>]) {
        self.bend.fill(Vector3::zeros());
        let jump = |this: &mut Self, share: f64| {
            this.advance(problem, share);
            for (node, fixed) in problem.fixed.iter().enumerate() {
                if *fixed {
                    this.trial.positions[node] = ends[node];
                }
            }
            this.set_velocities(problem);
            this.potential(problem).value
        };
        let alone = jump(self, 0.0);
        for share in LIFTS {
            let potential = jump(self, share);
            // A jump alone that is not finite is no reason to stay with it.
            if potential < alone || (!alone.is_finite() && potential.is_finite()) {
                return;
            }
        }
    }

    /// Line search; returns the share of the direction that was taken, 0 for none.
    pub(super) fn search(&mut self, problem: &Problem<'_>) -> f64 {
        let start = self.potential(problem);
        let slope = -dot(&self.residual, &self.direction);
        if slope >= 0.0 || slope.is_nan() {
            return 0.0;
        }
        let before = dot(&self.residual, &self.residual);
        let mut share = 1.0;
        while share > SHORTEST {
            self.advance(problem, share);
            let potential = self.potential(problem);
            let rise = potential.value - start.value;
            if rise <= ENOUGH * share * slope {
                return share;
            }
            // Where Φ has no more digits its slope still has. Near rest that is so long before the terms of Φ tell: they are
            // differences themselves. There the forces fall by much.
            let rounding = rise <= ROUNDING * (start.size + potential.size);
            if rounding || share == 1.0 {
                self.evaluate(problem, 0.0);
                let falls = dot(&self.residual, &self.residual) <= FALL * before;
                let way = self.direction.iter().zip(&self.bend);
                let end: f64 = way
                    .zip(&self.residual)
                    .map(|((d, c), r)| -r.dot(&(d + c * (2.0 * share))))
                    .sum();
                if (rounding || falls) && end <= (2.0 * ENOUGH - 1.0) * slope {
                    return share;
                }
            }
            // The lowest point of the parabola through both values and the slope.
            let lowest = -0.5 * slope * share * share / (rise - slope * share);
            share = if lowest.is_finite() {
                lowest.clamp(0.1 * share, 0.5 * share)
            } else {
                0.25 * share
            };
        }
        self.advance(problem, 0.0);
        0.0
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}
