//! The start of an equation: the best guess without contact and with it, and the displacement of prescribed nodes to their ends.

use super::equation::{EquationContact, Problem};
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

    /// Goes on from `guess` instead of from `trial`, at which contacts were found, if less of all forces is left there: Φ, by which
    /// [`start`](Self::start) decides, knows nothing of contact, and what tools move goes on where these do.
    pub(super) fn start_in_contact(
        &mut self,
        problem: &Problem<'_>,
        guess: &[Vector3<f64>],
        mut contact: Option<&mut EquationContact<'_>>,
    ) {
        if self.trial.positions == guess {
            return;
        }
        self.evaluate(problem, 0.0);
        let left = self.force_residual;
        self.from.copy_from_slice(&self.trial.positions);
        self.restart(problem, guess, contact.as_deref_mut());
        self.evaluate(problem, 0.0);
        let is_less = self.force_residual < left;
        if !is_less {
            let first = std::mem::take(&mut self.from);
            self.restart(problem, &first, contact);
            self.from = first;
        }
    }

    /// Sets `trial` to a guess and finds its contacts as the first ones of the equation.
    fn restart(
        &mut self,
        problem: &Problem<'_>,
        guess: &[Vector3<f64>],
        contact: Option<&mut EquationContact<'_>>,
    ) {
        self.place(problem, guess);
        self.searches = 0;
        self.find(problem, contact);
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
