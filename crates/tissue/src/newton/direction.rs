//! The direction of an iteration: the matrix, its factor, and the linear system, with contact the linearised step.

use super::equation::Problem;
use super::workspace::NewtonSolver;
use crate::elements::Tangent;
use crate::solver::StepFailure;
use crate::system::MatrixCoefficients;
use crate::work;
use microsim_contact_solver::{
    ContactSet, ContactSolver, LinearSystem, SystemResponse, Tolerances,
};
use microsim_sparse::NotPositive;

impl NewtonSolver {
    /// Assembles and factors the matrix at `trial`: with the contacts that are closed along the direction, for the interior-point method
    /// without any. Does nothing where the matrix is retained.
    pub(super) fn factorise(
        &mut self,
        problem: &Problem<'_>,
        tangent: Tangent,
    ) -> Result<(), NotPositive> {
        if self.retains_matrix {
            return Ok(());
        }
        let rate = problem.equation.rate;
        let coefficients = MatrixCoefficients {
            damping: rate,
            rate,
        };
        self.system
            .assemble(problem.model, &self.trial, coefficients, tangent);
        if tangent == Tangent::Exact {
            self.system
                .add_pressures(problem.control, &self.trial.positions);
        }
        for (node, spring) in problem.equation.regularisation.iter().enumerate() {
            self.system.add_diagonal(node, *spring);
        }
        self.contacts.stiffen(&self.direction, &mut self.system);
        self.has_bare_factor = self.takes_interior_point();
        match self.has_bare_factor {
            true => self.system.factorise_f64(problem.fixed),
            false => self.system.factorise(problem.fixed),
        }
    }

    /// No element and no mass makes the positive matrix indefinite: it is singular to rounding, or has numbers that are not finite.
    pub(super) fn why_not_positive(&self, failure: NotPositive) -> StepFailure {
        let mut values = self.system.matrix().values().iter();
        if values.all(|block| block.sum().is_finite()) {
            StepFailure::Singular {
                node: failure.node as u32,
            }
        } else {
            StepFailure::NotFinite
        }
    }

    /// Solves for the direction, which holds the displacements of prescribed nodes; `moves` is whether there are any.
    pub(super) fn set_direction(
        &mut self,
        fixed: &[bool],
        moves: bool,
        tolerances: Tolerances,
    ) -> Result<(), NotPositive> {
        if !self.contacts.is_empty() {
            let most = (self.allowed_work - self.work - self.element_work) / work::OPERATION;
            self.solve_contacts(fixed, tolerances, most)?;
            // Multipliers have changed.
            self.add_contacts(fixed);
            return Ok(());
        }
        if moves {
            self.system.multiply(&self.direction, &mut self.scratch);
        }
        for (node, d) in self.direction.iter_mut().enumerate() {
            if !fixed[node] {
                *d = self.residual[node];
                if moves {
                    *d -= self.scratch[node];
                }
            }
        }
        self.system.solve(&mut self.direction, tolerances.residual)
    }

    /// Adds to the direction what is missing of it for the forces `others` and contact, and updates the contacts, with about as many operations since
    /// [`forget_operations`](Self::forget_operations) or [`count_iteration`](Self::count_iteration).
    pub(super) fn solve_contacts(
        &mut self,
        fixed: &[bool],
        tolerances: Tolerances,
        most_operations: f64,
    ) -> Result<(), NotPositive> {
        let early = self.takes_interior_point();
        let solver: &mut dyn ContactSolver<SystemResponse<'_>, Contacts = ContactSet> = match early
        {
            true => &mut self.interior_point,
            false => &mut self.augmented_lagrangian,
        };
        let response = SystemResponse {
            system: &mut self.system,
            forces: &self.others,
            fixed,
            tolerances,
            most_operations,
        };
        solver.solve(&mut self.contacts, response, &mut self.direction)
    }
}
