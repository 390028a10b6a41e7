//! Quasi-static solver: each step ends in static equilibrium.
//!
//! Solves f(x) = 0 for elements, weight and loads by Newton's method (`newton`) with clamps and targets at their ends. Where
//! that does not converge the way there is cut: with the forces f_0 left over at the start, f(x) = (1 − s) f_0 is solved by the
//! start for s = 0, and prescribed nodes go the share s of their way; s is halved on failure and doubled on success.
//!
//! # Limitations
//! No inertia, no drag, no viscosity: the length of the step changes nothing, and velocities are zero after it. A body that is
//! not held has no solution ([`StepFailure::Singular`]); one that buckles ends in one of its equilibria, the nearest downhill.
//! Deformation that is followed, not sought, should come in steps in which elements are not inverted.

use crate::components::components;
use crate::contact::Touching;
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::newton::{Equation, Newton, NewtonSolver};
use crate::prescribed::Prescribed;
use crate::solver::{Solver, StepFailure, StepReport};
use crate::state::{Contacts, Control, State};
use nalgebra::Vector3;

/// The shortest share of a step that is tried.
const SHORTEST: f64 = 1.0 / 64.0;

/// The solver: working memory for one model.
#[derive(Clone, Debug)]
pub struct SolverQuasiStatic {
    newton: Newton,
    solver: NewtonSolver,
    equation: Equation,
    prescribed: Prescribed,
    /// For each node the lowest node of its connected part.
    components: Vec<u32>,
    held: Vec<bool>,
    /// f_0 [N].
    start_forces: Vec<Vector3<f64>>,
    /// Where the prescribed nodes are after the share of the step [m].
    ends: Vec<Vector3<f64>>,
    /// The last solution [m].
    solved: Vec<Vector3<f64>>,
}

impl SolverQuasiStatic {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel, newton: Newton) -> Self {
        let zeros = vec![Vector3::zeros(); model.node_count()];
        let solver = NewtonSolver::new(model);
        Self {
            newton,
            components: components(model),
            solver,
            equation: Equation {
                rate: 0.0,
                base: Vec::new(),
                base_velocities: Vec::new(),
                extra: Vec::new(),
            },
            prescribed: Prescribed::new(model.node_count()),
            held: vec![false; model.node_count()],
            start_forces: zeros.clone(),
            ends: zeros.clone(),
            solved: zeros,
        }
    }

    /// The lowest node of a part of the body that no prescribed node holds.
    fn loose_part(&mut self) -> Option<u32> {
        self.held.fill(false);
        for (&lowest, fixed) in self.components.iter().zip(&self.prescribed.fixed) {
            self.held[lowest as usize] |= fixed;
        }
        let lowest = self.components.iter().copied();
        lowest
            .into_iter()
            .find(|&lowest| !self.held[lowest as usize])
    }

    /// Sets the equation at the share `s` of the step that starts at `start` [m].
    fn set_share(&mut self, start: &[Vector3<f64>], s: f64) {
        self.equation.extra.clear();
        if s == 1.0 {
            self.ends.copy_from_slice(&self.prescribed.ends);
            return;
        }
        for (node, force) in self.start_forces.iter().enumerate() {
            self.equation.extra.push(force * (s - 1.0));
            self.ends[node] = start[node] + (self.prescribed.ends[node] - start[node]) * s;
        }
    }
}

impl Solver for SolverQuasiStatic {
    fn advance(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        contacts: &Contacts,
        touching: Option<&mut Touching<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        if touching.is_some() {
            return Err(StepFailure::NoContact {
                reason: "not yet",
            });
        }
        if !state.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        self.prescribed.set(model, state, control, contacts);
        if let Some(node) = self.loose_part() {
            return Err(StepFailure::Singular { node });
        }
        self.solver.begin(state);
        self.solved.copy_from_slice(&state.positions);
        let mut iterations = 0;
        let (mut done, mut share) = (0.0, 1.0f64);
        let report = loop {
            let s = (done + share).min(1.0);
            self.set_share(&state.positions, s);
            let result = self.solver.solve(
                model,
                control,
                &self.equation,
                &self.prescribed.fixed,
                &self.ends,
                &[&self.solved],
                &self.newton,
                exec,
            );
            match result {
                Ok(report) => {
                    iterations += report.iterations;
                    self.solved.copy_from_slice(&self.solver.trial.positions);
                    if s == 1.0 {
                        break report;
                    }
                    done = s;
                    share *= 2.0;
                }
                Err(failure) => {
                    if let StepFailure::NotConverged { iterations: n, .. } = failure {
                        iterations += n;
                    }
                    if done == 0.0 && share == 1.0 {
                        let forces =
                            self.solver
                                .static_forces(model, &state.positions, control, exec);
                        self.start_forces.copy_from_slice(forces);
                    }
                    share *= 0.5;
                    if share < SHORTEST {
                        return Err(match failure {
                            StepFailure::NotConverged { residual, .. } => {
                                StepFailure::NotConverged {
                                    iterations,
                                    residual,
                                }
                            }
                            other => other,
                        });
                    }
                }
            }
        };
        if !self.solver.trial.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        state.positions.copy_from_slice(&self.solved);
        state.velocities.fill(Vector3::zeros());
        state.accelerations.clear();
        state.step = h;
        Ok(StepReport {
            iterations,
            ..report
        })
    }

    fn boxed_clone(&self) -> Box<dyn Solver> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
