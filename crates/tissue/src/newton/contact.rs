//! Contact in an equation: finding it, publishing its forces, undoing old overlaps.

use super::equation::{Equation, EquationContact, Problem};
use super::workspace::NewtonSolver;
use crate::elements::Tangent;
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::solver::StepFailure;
use crate::state::Control;
use crate::work;
use microsim_contact_solver::Tolerances;
use nalgebra::Vector3;

/// In steps whose work is bounded, the work after which the augmented Lagrangian method begins no further solution for the undoing of overlaps \[s\]: what is
/// left of them is for later steps. It is not in the work of a step. Without a bound trembling hands that had squeezed cut tissue took up to a second for it in
/// every tick. A judgement: no script that ships comes to it.
const UNDONE: f64 = 4e-3;

impl NewtonSolver {
    /// Finds the contacts at `trial`, or retains those that were found often enough.
    pub(super) fn find(
        &mut self,
        problem: &Problem<'_>,
        contact: Option<&mut EquationContact<'_>>,
    ) {
        let Some(contact) = contact else {
            self.contacts.clear();
            return;
        };
        self.contacts.publish();
        let positions = &self.trial.positions;
        // Nothing can be found at positions that are not finite; the residual will show it.
        if !positions.iter().map(|x| x.sum()).sum::<f64>().is_finite() {
            self.contacts.clear();
            return;
        }
        let early = self.contacts.takes_interior_point(&self.system);
        let searches = match early {
            true => self.options.contact.early_searches,
            false => self.options.contact.searches,
        }
        .min(contact.most_searches);
        self.contacts.retains_multipliers = early && self.searches >= searches;
        if self.searches < searches {
            let found = &mut self.contacts.contacts;
            contact.source.find(contact.step_fraction, positions, found);
            for found in found.iter_mut() {
                found.drift *= contact.slip_since.drift;
            }
            self.searches += 1;
        }
        let Equation {
            rate,
            regularisation,
            ..
        } = problem.equation;
        let (stiffness, drags) = (&self.stiffness, &self.drags);
        let start = contact.slip_since.positions;
        self.contacts
            .linearise(start, positions, *rate == 0.0, |node| {
                if problem.fixed[node] {
                    return 0.0;
                }
                let inertia = rate * (rate + drags[node]) * problem.model.inertia(node);
                stiffness[node] + inertia + regularisation.get(node).unwrap_or(&0.0)
            });
    }

    /// Finds the contacts after a step of this length. In an early-terminated step goes back on its path while they show that surfaces have
    /// turned: gaps are far below their floors, further than any was before it. Tissue would spring out of jaws. Returns the step length
    /// that is left.
    pub(super) fn find_ahead(
        &mut self,
        problem: &Problem<'_>,
        mut contact: Option<&mut EquationContact<'_>>,
        mut length: f64,
    ) -> f64 {
        let most = self.contacts.overlap().max(self.options.contact.overlap);
        let early = self.takes_interior_point();
        if early {
            self.contacts.store();
        }
        self.find(problem, contact.as_deref_mut());
        for _ in 0..self.options.contact.retreats {
            if !early || self.contacts.overlap() <= most {
                break;
            }
            length *= 0.5;
            self.backtracks += 1;
            self.advance(problem, length);
            self.contacts.restore();
            self.searches = self.searches.saturating_sub(1);
            self.find(problem, contact.as_deref_mut());
        }
        length
    }

    /// Publishes the forces of the contacts. With inertia the momentum of each free component is conserved to rounding with these, where
    /// the equation is solved: the whole component is moved by what linear systems have left of it.
    pub(super) fn publish(&mut self, problem: &Problem<'_>) {
        self.contacts.publish();
        let rate = problem.equation.rate;
        if !self.balanced || rate == 0.0 {
            return;
        }
        if !self.contacts.is_empty() {
            self.residual.copy_from_slice(&self.others);
        }
        for contact in &self.contacts.contacts {
            let force = contact.force();
            for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
                self.residual[node as usize] += force * weight;
            }
        }
        let (model, drags) = (problem.model, &self.drags);
        self.components.balance(
            problem.fixed,
            &self.residual,
            |node| model.inertia(node) * rate * (rate + drags[node]),
            &mut self.trial.positions,
        );
        self.set_velocities(problem);
    }

    /// Undoes the old overlaps of the contacts of the last solution: moves the nodes of `trial` without velocity or force. Free components
    /// go as wholes; where that is not enough others go along by the matrix.
    pub fn undo_overlaps(
        &mut self,
        model: &TissueModel,
        control: &Control,
        equation: &Equation,
        fixed: &[bool],
        h: f64,
        exec: &dyn Executor,
    ) -> Result<(), StepFailure> {
        let overlap = &self.options.contact_solvers.overlap;
        let (most, longest) = (overlap.undone(self.frequency, h), overlap.longest);
        let gap_tolerance = self.options.contact.multiplier_tolerances[1];
        let positions = &mut self.trial.positions;
        if !self
            .contacts
            .undo_overlaps(positions, gap_tolerance, f64::INFINITY)
        {
            return Ok(());
        }
        let problem = Problem {
            model,
            control,
            equation,
            fixed,
            exec,
        };
        self.components.separate(
            &self.contacts.contacts,
            |n| fixed[n],
            1.0 / equation.rate,
            positions,
        );
        if !self.contacts.undo_overlaps(positions, gap_tolerance, most) {
            return Ok(());
        }
        self.direction.fill(Vector3::zeros());
        self.contacts.predict(&mut self.direction);
        self.others.fill(Vector3::zeros());
        let tolerance = self.options.linear_tolerances[1];
        let tolerances = Tolerances {
            residual: tolerance,
            changes: tolerance,
            multipliers: gap_tolerance,
        };
        // Any positive matrix of the equation will do, as what is undone has neither velocity nor force: that of the last iteration, if it
        // holds no contact, as those are others now.
        self.retains_matrix |= self.has_bare_factor && self.takes_interior_point();
        let most_operations = match self.allowed_work.is_finite() {
            true => UNDONE / work::OPERATION,
            false => f64::INFINITY,
        };
        self.factorise(&problem, Tangent::Positive)
            .and_then(|()| self.solve_contacts(fixed, tolerances, most_operations))
            .map_err(|failure| self.why_not_positive(failure))?;
        let longest = longest * self.edge;
        for (x, d) in self.trial.positions.iter_mut().zip(&self.direction) {
            *x += d.cap_magnitude(longest);
        }
        Ok(())
    }
}
