//! The start of an equation: the best guess, and the displacement of prescribed nodes to their ends.

use super::equation::Problem;
use super::workspace::NewtonSolver;
use nalgebra::Vector3;

impl NewtonSolver {
    /// Sets `trial` to the guess with the lowest potential.
    pub(super) fn start(&mut self, problem: &Problem<'_>, guesses: &[&[Vector3<f64>]]) {
        let mut lowest = f64::INFINITY;
        let mut best = 0;
        if guesses.len() > 1 {
            self.from.copy_from_slice(guesses[0]);
            self.place(problem, guesses[0]);
            self.set_loads(problem);
            for (index, guess) in guesses.iter().enumerate() {
                self.place(problem, guess);
                let potential = self.potential(problem).value;
                if potential < lowest {
                    lowest = potential;
                    best = index;
                }
            }
        }
        self.place(problem, guesses[best]);
    }

    /// Sets the direction to the displacements of prescribed nodes to their ends, with a guess of how surfaces move others; returns whether
    /// there are any.
    pub(super) fn prescribe(&mut self, fixed: &[bool], ends: &[Vector3<f64>]) -> bool {
        let mut moves = false;
        for (node, d) in self.direction.iter_mut().enumerate() {
            *d = Vector3::zeros();
            if fixed[node] {
                *d = ends[node] - self.from[node];
                moves |= *d != Vector3::zeros();
            }
        }
        if !self.takes_interior_point() {
            self.contacts.predict(&mut self.direction);
        }
        moves
    }

    /// Puts prescribed nodes at their ends; all others take the part of the direction with which Φ is below that without them.
    pub(super) fn follow_prescribed(&mut self, problem: &Problem<'_>, ends: &[Vector3<f64>]) {
        self.second_order.fill(Vector3::zeros());
        let alone = self.go_along(problem, ends, 0.0);
        for length in self.options.predictor_lengths {
            let potential = self.go_along(problem, ends, length);
            // A potential that is not finite is no reason to stay with it.
            if potential < alone || (!alone.is_finite() && potential.is_finite()) {
                return;
            }
        }
    }

    fn go_along(&mut self, problem: &Problem<'_>, ends: &[Vector3<f64>], length: f64) -> f64 {
        self.advance(problem, length);
        for (node, fixed) in problem.fixed.iter().enumerate() {
            if *fixed {
                self.trial.positions[node] = ends[node];
            }
        }
        self.set_velocities(problem);
        self.potential(problem).value
    }
}
