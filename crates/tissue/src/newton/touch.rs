//! Contact in an equation: finding it, telling it its forces, undoing old overlaps.

use super::{
    Equation, FINDS, FINDS_QUICK, LINEAR_TOLERANCES, NewtonSolver, OVERLAP, Problem, RETREATS,
    SLACK, Touch,
};
use crate::elements::Tangent;
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::projection::undone;
use crate::solver::StepFailure;
use crate::state::Control;
use nalgebra::Vector3;

impl NewtonSolver {
    /// Finds the contacts at `trial`, or keeps those that were found often enough.
    pub(super) fn find(&mut self, problem: &Problem<'_>, touch: Option<&mut Touch<'_>>) {
        let Some(touch) = touch else {
            self.gaps.clear();
            return;
        };
        self.gaps.tell();
        let positions = &self.trial.positions;
        // Nothing can be found at what is no place; the residual will tell.
        if !positions.iter().map(|x| x.sum()).sum::<f64>().is_finite() {
            self.gaps.clear();
            return;
        }
        let quick = self.gaps.is_quick(&self.system);
        let finds = if quick { FINDS_QUICK } else { FINDS };
        self.gaps.keeps_laws = quick && self.finds >= finds;
        if self.finds < finds {
            let contacts = &mut self.gaps.contacts;
            touch.source.find(touch.way, positions, contacts);
            for contact in contacts.iter_mut() {
                contact.drift *= touch.since.drift;
            }
            self.finds += 1;
        }
        let Equation { rate, hold, .. } = problem.equation;
        let (stiffness, drags) = (&self.stiffness, &self.drags);
        self.gaps
            .set(touch.since.positions, positions, *rate == 0.0, |node| {
                if problem.fixed[node] {
                    return 0.0;
                }
                let inertia = rate * (rate + drags[node]) * problem.model.inertia(node);
                stiffness[node] + inertia + hold.get(node).unwrap_or(&0.0)
            });
    }

    /// Finds the contacts where an iteration has led. In a quick step goes back on its way, of which `share` was taken, while they say that surfaces
    /// have turned: gaps that it was to keep are far below their floors, further than any was before it. Tissue would spring out of jaws.
    /// Returns the share that is left.
    pub(super) fn find_ahead(
        &mut self,
        problem: &Problem<'_>,
        mut touch: Option<&mut Touch<'_>>,
        mut share: f64,
    ) -> f64 {
        let most = self.gaps.overlap().max(OVERLAP);
        let quick = self.is_quick();
        if quick {
            self.gaps.keep();
        }
        self.find(problem, touch.as_deref_mut());
        for _ in 0..RETREATS {
            if !quick || self.gaps.overlap() <= most {
                break;
            }
            share *= 0.5;
            self.advance(problem, share);
            self.gaps.restore();
            self.finds = self.finds.saturating_sub(1);
            self.find(problem, touch.as_deref_mut());
        }
        share
    }

    /// Tells the contacts their forces. With inertia the momentum of each part that is free is kept to rounding with these: the whole part
    /// is moved by what linear systems have left of it.
    pub(super) fn tell(&mut self, problem: &Problem<'_>) {
        self.gaps.tell();
        let rate = problem.equation.rate;
        if !self.balanced || rate == 0.0 {
            return;
        }
        if !self.gaps.is_empty() {
            self.residual.copy_from_slice(&self.others);
        }
        for contact in &self.gaps.contacts {
            let force = contact.force();
            for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
                self.residual[node as usize] += force * weight;
            }
        }
        let (model, drags) = (problem.model, &self.drags);
        self.parts.balance(
            problem.fixed,
            &self.residual,
            |node| model.inertia(node) * rate * (rate + drags[node]),
            &mut self.trial.positions,
        );
        self.set_velocities(problem);
    }

    /// Undoes the old overlaps of the contacts of the last solution: moves the nodes of `trial` without velocity or force. Parts that
    /// are free go as wholes; where that is not enough others go along as the matrix says.
    pub fn undo(
        &mut self,
        model: &TissueModel,
        control: &Control,
        equation: &Equation,
        fixed: &[bool],
        h: f64,
        exec: &dyn Executor,
    ) -> Result<(), StepFailure> {
        let most = undone(self.frequency, h);
        if !self
            .gaps
            .set_undoing(&self.trial.positions, [SLACK[1], f64::INFINITY])
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
        let positions = &mut self.trial.positions;
        self.parts.separate(
            &self.gaps.contacts,
            |n| fixed[n],
            1.0 / equation.rate,
            positions,
        );
        if !self
            .gaps
            .set_undoing(&self.trial.positions, [SLACK[1], most])
        {
            return Ok(());
        }
        self.direction.fill(Vector3::zeros());
        self.gaps.predict(&mut self.direction);
        // The matrix of a short last iteration will do.
        self.others.fill(Vector3::zeros());
        self.factorise(&problem, Tangent::Positive)
            .and_then(|()| {
                self.gaps.set_direction(
                    &self.others,
                    fixed,
                    &mut self.system,
                    [LINEAR_TOLERANCES[1], LINEAR_TOLERANCES[1], SLACK[1]],
                    &mut self.direction,
                )
            })
            .map_err(|failure| self.why_not_positive(failure))?;
        for (x, d) in self.trial.positions.iter_mut().zip(&self.direction) {
            *x += d;
        }
        Ok(())
    }

    /// Sets the residual at `trial` from that without contacts.
    pub(super) fn add_contacts(&mut self, fixed: &[bool]) {
        self.residual.copy_from_slice(&self.others);
        self.gaps
            .add_forces(&self.trial.positions, &mut self.residual);
        for (residual, fixed) in self.residual.iter_mut().zip(fixed) {
            if *fixed {
                *residual = Vector3::zeros();
            }
        }
    }
}
