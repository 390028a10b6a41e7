//! The residual of an equation: all forces minus the left side, at the trial state.

use super::equation::{Equation, Problem};
use super::workspace::NewtonSolver;
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::state::Control;
use nalgebra::Vector3;

impl NewtonSolver {
    /// All forces on the nodes at `positions` without speed \[N\].
    pub fn static_forces(
        &mut self,
        model: &TissueModel,
        positions: &[Vector3<f64>],
        control: &Control,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        self.trial.positions.copy_from_slice(positions);
        self.trial.velocities.fill(Vector3::zeros());
        self.forces.compute(model, &self.trial, control, exec)
    }

    /// Sets `trial` to these positions.
    pub(super) fn place(&mut self, problem: &Problem<'_>, positions: &[Vector3<f64>]) {
        self.trial.positions.copy_from_slice(positions);
        self.set_velocities(problem);
    }

    /// v = (x − x̃)/η.
    pub(super) fn set_velocities(&mut self, problem: &Problem<'_>) {
        let equation = problem.equation;
        if equation.rate == 0.0 {
            self.trial.velocities.fill(Vector3::zeros());
            return;
        }
        for ((v, x), base) in self
            .trial
            .velocities
            .iter_mut()
            .zip(&self.trial.positions)
            .zip(&equation.base)
        {
            *v = (x - base) * equation.rate;
        }
    }

    /// The left side of the equation at a node of `trial` \[N\].
    #[inline]
    fn inertia(&self, problem: &Problem<'_>, node: usize) -> Vector3<f64> {
        let Equation {
            rate,
            base_velocities,
            ..
        } = problem.equation;
        if *rate == 0.0 {
            return Vector3::zeros();
        }
        let v = self.trial.velocities[node];
        ((v - base_velocities[node]) * *rate + v * self.drags[node]) * problem.model.inertia(node)
    }

    /// Computes the residual at `trial`; returns its norm relative to the forces, 0 where it is not above `noise`.
    pub(super) fn evaluate(&mut self, problem: &Problem<'_>, noise: f64) -> f64 {
        self.forces
            .compute(problem.model, &self.trial, problem.control, problem.exec);
        let weight = problem.control.gravity.norm();
        let (mut left, mut scale) = (0.0, 0.0);
        for node in 0..problem.model.node_count() {
            let mut force = self.forces.last()[node];
            if let Some(extra) = problem.equation.extra.get(node) {
                force += extra;
            }
            let mass = problem.model.masses()[node];
            scale += force.norm_squared() + (mass * weight) * (mass * weight);
            self.residual[node] = Vector3::zeros();
            if !problem.fixed[node] {
                let mut inertia = self.inertia(problem, node);
                if let Some(spring) = problem.equation.regularisation.get(node) {
                    let displacement = self.trial.positions[node] - problem.equation.base[node];
                    inertia += displacement * *spring;
                }
                scale += inertia.norm_squared();
                let residual = force - inertia;
                self.residual[node] = residual;
                left += residual.norm_squared();
            }
        }
        // Loads count by themselves too: where they are in equilibrium nothing is left of them in the sums above.
        self.scratch.fill(Vector3::zeros());
        problem
            .control
            .add_loads(&self.trial.positions, &mut self.scratch);
        scale += self.scratch.iter().map(Vector3::norm_squared).sum::<f64>();
        if !self.contacts.is_empty() {
            self.others.copy_from_slice(&self.residual);
            self.add_contacts(problem.fixed);
            left = 0.0;
            for (residual, others) in self.residual.iter().zip(&self.others) {
                left += residual.norm_squared();
                scale += (residual - others).norm_squared();
            }
        }
        let left = left.sqrt();
        self.force_residual = left;
        if left <= noise {
            0.0
        } else {
            left / scale.sqrt()
        }
    }

    /// The size of a residual that is only rounding: what the last digits of positions are worth in the last matrix \[N\].
    pub(super) fn noise(&self, fixed: &[bool]) -> f64 {
        let reach = self
            .trial
            .positions
            .iter()
            .map(|x| x.amax())
            .fold(0.0, f64::max);
        let stiffness: f64 = fixed
            .iter()
            .enumerate()
            .filter(|(_, fixed)| !**fixed)
            .map(|(node, _)| self.system.matrix().diagonal(node).norm_squared())
            .sum();
        // A node sums the forces of some twenty elements, each with a few roundings.
        16.0 * f64::EPSILON * reach * stiffness.sqrt()
    }

    /// Sets n, from `trial`.
    pub(super) fn set_loads(&mut self, problem: &Problem<'_>) {
        let Problem { model, control, .. } = problem;
        for (load, mass) in self.loads.iter_mut().zip(model.masses()) {
            *load = control.gravity * *mass;
        }
        control.add_loads(&self.trial.positions, &mut self.loads);
        for (load, extra) in self.loads.iter_mut().zip(&problem.equation.extra) {
            *load += extra;
        }
        if self.viscous && problem.equation.rate > 0.0 {
            let all = self
                .forces
                .compute(model, &self.trial, control, problem.exec);
            self.scratch.copy_from_slice(all);
            self.trial.velocities.fill(Vector3::zeros());
            let elastic = self
                .forces
                .compute(model, &self.trial, control, problem.exec);
            for ((load, all), elastic) in self.loads.iter_mut().zip(&self.scratch).zip(elastic) {
                *load += all - elastic;
            }
            self.set_velocities(problem);
        }
    }

    /// Sets the residual at `trial` from that without contacts.
    pub(super) fn add_contacts(&mut self, fixed: &[bool]) {
        self.residual.copy_from_slice(&self.others);
        self.contacts
            .add_forces(&self.trial.positions, &mut self.residual);
        for (residual, fixed) in self.residual.iter_mut().zip(fixed) {
            if *fixed {
                *residual = Vector3::zeros();
            }
        }
    }
}
