//! Quasi-static solver: each step ends in static equilibrium.
//!
//! Solves f(x) = 0 for elements, weight and loads by Newton's method (`newton`) with clamps and targets at their ends. Where
//! that does not converge the path is divided: with the forces f_0 left over at the start, f(x) = (1 − s) f_0 is solved by the
//! start for s = 0, and prescribed nodes go the fraction s of their displacement; s is halved on failure and doubled on success.
//!
//! Newton's method finds contacts a few times and then retains their features and normals. An equilibrium with those may be none with the contacts of its own
//! positions: a tool stands in the tissue, and step after step goes from one such state to the other and back. So, where the method must converge, the equation is solved again
//! with the contacts found at its solution, until hardly anything moves ([`QuasiStaticOptions::consistent`]). That is a fixed-point iteration with Aitken's
//! relaxation. Without it the iteration diverges where contact stiffens as features turn, which retained ones do not, as at an edge that lies along a tool.
//!
//! # Limitations
//! No inertia, no drag, no viscosity: the length of the step changes nothing, and velocities are zero after it. A body that is
//! not held has no solution ([`StepFailure::Singular`]). One that only contacts hold may still slide or roll: its nodes are tied to where
//! they were before the step by springs of 1e-4 of their own stiffness ([`QuasiStaticOptions::regularisation`]), so where nothing else holds it creeps, and forces of a step in
//! which it moves are wrong by that much of what it would take to strain it as far. Old overlaps are pushed out by force. A body
//! that buckles ends in one of its equilibria, the nearest downhill. Deformation that is followed, not sought, should come in steps in which elements are not inverted.

use crate::executor::Executor;
use crate::model::TissueModel;
use crate::newton::{
    Equation, EquationContact, Newton, NewtonOptions, NewtonSolver, SlipReference,
};
use crate::prescribed::Prescribed;
use crate::solver::{Solver, StepFailure, StepReport};
use crate::state::{Control, NodeTarget, State};
use microsim_contact_solver::{Components, ContactStep};
use nalgebra::Vector3;
use relaxation::Relaxation;
use std::sync::Arc;

/// Options of the quasi-static solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuasiStaticOptions {
    /// The shortest part of a step that is tried; in 1e-3..0.5. A shorter one finds more equilibria, and fails later where there is none.
    pub shortest_part: f64,
    /// Springs from the nodes of a component that contacts alone hold to where they were, over the stiffness of the node by itself; in
    /// 1e-6..1e-2. Larger values creep less and make forces wrong by as much.
    pub regularisation: f64,
    /// The largest displacement of a node when the equation is solved again with the contacts found at its solution \[mean edge length\]: from the first one on it
    /// is solved no more, and above the second one the step counts as unconverged, with this as its contact residual; in 1e-6..1e-1, the first below the
    /// second. Tools may be in tissue by about as much. Smaller values cost solutions.
    pub consistent: [f64; 2],
    /// How often it is solved again at most; at least 1. Where surfaces of two bodies lie on one another, features take turns for ever, and more
    /// hardly brings them nearer (13 of the 100 steps of the scene `peel-back` end as unconverged).
    pub rounds: u32,
}

impl Default for QuasiStaticOptions {
    fn default() -> Self {
        Self {
            shortest_part: 1.0 / 64.0,
            regularisation: 1e-4,
            consistent: [1e-4, 1e-2],
            rounds: 12,
        }
    }
}

/// The quasi-static solver, with its working memory for one model.
///
/// ```
/// # use microsim_mesh::{Block, CellSplit};
/// # use microsim_tissue::{Behaviour, Material, SpringConstants, build_model};
/// # let block = Block { center: [0.0; 3], size: [4e-3, 2e-3, 2e-3], cells: [4, 2, 2], split: CellSplit::Kuhn };
/// # let mesh = block.mesh().unwrap();
/// # let springs = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
/// # let tissue = Material { density: 1060.0, relaxation_time: 0.0, behaviour: springs };
/// # let clamped: Vec<bool> = mesh.positions.iter().map(|x| x.x < -1.9e-3).collect();
/// # let model = build_model(&mesh, &[(0, tissue)], &clamped, 0.0, Vec::new()).unwrap();
/// use microsim_tissue::{Control, Newton, Serial, Solver, SolverQuasiStatic, State};
///
/// // The equilibrium of a block that is clamped at one end, under its weight. The length of the step changes nothing.
/// let mut state = State::at_rest(&model);
/// let control = Control { gravity: [0.0, 0.0, -9.81].into(), ..Control::default() };
/// let mut solver = SolverQuasiStatic::new(&model, Newton::default());
/// solver.step(&model, &mut state, &control, &[], 1.0, &Serial)?;
/// let tip = model.node_count() - 1;
/// assert!(state.positions[tip].z < model.rest_positions()[tip].z);
/// # Ok::<(), microsim_tissue::StepFailure>(())
/// ```
#[derive(Clone, Debug)]
pub struct SolverQuasiStatic {
    newton: Newton,
    newton_options: NewtonOptions,
    options: QuasiStaticOptions,
    solver: NewtonSolver,
    equation: Equation,
    prescribed: Prescribed,
    components: Arc<Components>,
    /// Of each connected component.
    held: Vec<bool>,
    /// f_0 \[N\].
    start_forces: Vec<Vector3<f64>>,
    /// Where the prescribed nodes are after the part of the step \[m\].
    ends: Vec<Vector3<f64>>,
    /// The last solution \[m\].
    solved: Vec<Vector3<f64>>,
    /// Where a solution begins, and where its contacts are found \[m\].
    guess: Vec<Vector3<f64>>,
    /// The guess of the last round, and the one that changed least \[m\].
    tried: Vec<Vector3<f64>>,
    best: Vec<Vector3<f64>>,
    relaxation: Relaxation,
}

/// What a step is made with.
struct Step<'a> {
    model: &'a TissueModel,
    /// At its start.
    state: &'a State,
    control: &'a Control,
    exec: &'a dyn Executor,
}

impl SolverQuasiStatic {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel, newton: Newton) -> Self {
        let options = QuasiStaticOptions::default();
        Self::with_options(model, newton, &NewtonOptions::default(), options)
    }

    /// As [`new`](Self::new), with other constants of Newton's method and of the solver.
    pub fn with_options(
        model: &TissueModel,
        newton: Newton,
        newton_options: &NewtonOptions,
        options: QuasiStaticOptions,
    ) -> Self {
        let zeros = vec![Vector3::zeros(); model.node_count()];
        let solver = NewtonSolver::new(model, newton_options);
        Self {
            newton,
            newton_options: *newton_options,
            options,
            components: model.components().clone(),
            solver,
            equation: Equation {
                rate: 0.0,
                base: Vec::new(),
                base_velocities: Vec::new(),
                extra: Vec::new(),
                regularisation: Vec::new(),
            },
            prescribed: Prescribed::new(model.node_count()),
            held: vec![false; model.components().lowest.len()],
            start_forces: zeros.clone(),
            ends: zeros.clone(),
            solved: zeros.clone(),
            guess: zeros.clone(),
            tried: zeros.clone(),
            best: zeros,
            relaxation: Relaxation::default(),
        }
    }

    /// Gives each component that no prescribed node holds its springs; there must be a contact of it.
    fn regularise_loose_components(
        &mut self,
        state: &State,
        contact: Option<&mut ContactStep<'_>>,
    ) -> Result<(), StepFailure> {
        self.held.fill(false);
        self.equation.regularisation.clear();
        let Components { of_node, lowest } = &*self.components;
        for (&part, fixed) in of_node.iter().zip(&self.prescribed.fixed) {
            self.held[part as usize] |= fixed;
        }
        let held = &mut self.held;
        let Some(first) = held.iter().position(|held| !held) else {
            return Ok(());
        };
        let Some(contact) = contact else {
            return Err(StepFailure::Singular {
                node: lowest[first],
            });
        };
        self.equation.base.clone_from(&state.positions);
        for (&part, stiffness) in of_node.iter().zip(self.solver.stiffness()) {
            let loose = !held[part as usize];
            let spring = if loose {
                self.options.regularisation * stiffness
            } else {
                0.0
            };
            self.equation.regularisation.push(spring);
        }
        contact.contacts.clear();
        let source = &mut contact.source;
        source.find(1.0, &state.positions, &mut contact.contacts);
        for contact in &contact.contacts {
            for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
                if weight != 0.0 {
                    held[of_node[node as usize] as usize] = true;
                }
            }
        }
        contact.contacts.clear();
        match held.iter().position(|held| !held) {
            Some(part) => Err(StepFailure::Singular { node: lowest[part] }),
            None => Ok(()),
        }
    }

    /// Sets the equation at the fraction `s` of the step that starts at `start` \[m\].
    fn set_fraction(&mut self, start: &[Vector3<f64>], s: f64) {
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

    /// Solves the equation at the fraction `s` of the step from `self.guess`, with contacts found so often at most; the solution is in
    /// `self.solver.trial`.
    fn solve(
        &mut self,
        step: &Step<'_>,
        contact: Option<&mut ContactStep<'_>>,
        s: f64,
        most_searches: u32,
    ) -> Result<StepReport, StepFailure> {
        self.solver.solve(
            step.model,
            step.control,
            &self.equation,
            &self.prescribed.fixed,
            &self.ends,
            &[&self.guess],
            contact.map(|contact| EquationContact {
                source: &mut *contact.source,
                slip_since: SlipReference::start(&step.state.positions),
                step_fraction: s,
                most_searches,
            }),
            &self.newton,
            step.exec,
        )
    }

    /// Solves the equation at the fraction `s` of the step, so that its contacts are those of the solution; which is in `self.solved`.
    fn solve_consistently(
        &mut self,
        step: &Step<'_>,
        mut contact: Option<&mut ContactStep<'_>>,
        s: f64,
    ) -> Result<StepReport, StepFailure> {
        self.guess.clone_from(&self.solved);
        let mut total = self.solve(step, contact.as_deref_mut(), s, u32::MAX)?;
        // What need not converge is no equilibrium, of whatever contacts; without any there is none to find again.
        if self.newton.must_converge && !self.solver.contacts().is_empty() {
            self.guess.clone_from(&self.solver.trial.positions);
            self.relaxation.begin();
            let [enough, most] = self.options.consistent;
            let edge = step.model.mean_edge_length();
            let mut least = f64::INFINITY;
            for _ in 0..self.options.rounds {
                match self.solve(step, contact.as_deref_mut(), s, 1) {
                    Ok(report) => total = followed_by(total, report),
                    Err(failure) if least == f64::INFINITY => return Err(failure),
                    // From a guess without solution back to the best one.
                    Err(_) => break,
                }
                self.tried.clone_from(&self.guess);
                let found = &self.solver.trial.positions;
                let change = self.relaxation.relax(&mut self.guess, found) / edge;
                if change < least {
                    least = change;
                    std::mem::swap(&mut self.best, &mut self.tried);
                }
                if least <= enough {
                    break;
                }
            }
            if least > enough {
                self.guess.clone_from(&self.best);
                let report = self.solve(step, contact, s, 1)?;
                total = followed_by(total, report);
            }
            total.contact_residual = total.contact_residual.max(least);
            total.converged &= least <= most;
        }
        self.solved.copy_from_slice(&self.solver.trial.positions);
        Ok(total)
    }
}

/// The report of two solutions, one after the other: only the last one is what the step ends with.
fn followed_by(first: StepReport, last: StepReport) -> StepReport {
    StepReport {
        iterations: first.iterations + last.iterations,
        backtracks: first.backtracks + last.backtracks,
        contact_failures: first.contact_failures + last.contact_failures,
        work: first.work + last.work,
        ..last
    }
}

impl Solver for SolverQuasiStatic {
    fn advance(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        mut contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        if !state.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        self.prescribed.set(model, state, control, targets);
        self.regularise_loose_components(state, contact.as_deref_mut())?;
        self.solver.begin(state, false);
        self.solved.copy_from_slice(&state.positions);
        let step = Step {
            model,
            state,
            control,
            exec,
        };
        let mut total = StepReport::without_residual(0);
        let (mut done, mut part) = (0.0, 1.0f64);
        loop {
            let s = (done + part).min(1.0);
            self.set_fraction(&state.positions, s);
            match self.solve_consistently(&step, contact.as_deref_mut(), s) {
                Ok(report) => {
                    total = followed_by(total, report);
                    if s == 1.0 {
                        break;
                    }
                    done = s;
                    part *= 2.0;
                }
                Err(failure) => {
                    if let StepFailure::NotConverged { iterations: n, .. } = failure {
                        total.iterations += n;
                    }
                    if done == 0.0 && part == 1.0 {
                        let forces =
                            self.solver
                                .static_forces(model, &state.positions, control, exec);
                        self.start_forces.copy_from_slice(forces);
                    }
                    self.solver.begin(state, false);
                    part *= 0.5;
                    if part < self.options.shortest_part {
                        return Err(match failure {
                            StepFailure::NotConverged { residual, .. } => {
                                StepFailure::NotConverged {
                                    iterations: total.iterations,
                                    residual,
                                }
                            }
                            other => other,
                        });
                    }
                }
            }
        }
        if !self.solver.trial.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        if let Some(contact) = contact {
            std::mem::swap(self.solver.contacts(), &mut contact.contacts);
        }
        state.positions.copy_from_slice(&self.solved);
        state.velocities.fill(Vector3::zeros());
        state.accelerations.clear();
        state.step = h;
        Ok(total)
    }

    fn follow(&mut self, model: &TissueModel) {
        let newton_options = self.newton_options;
        let (effort, most_work) = (self.solver.effort, self.solver.most_work);
        *self = Self::with_options(model, self.newton, &newton_options, self.options);
        // In the middle of a tick the bounds of its work remain.
        (self.solver.effort, self.solver.most_work) = (effort, most_work);
    }

    fn limit_work(&mut self, most: f64) {
        self.solver.most_work = most;
    }

    fn least_work(&self, _: &TissueModel, contacts: usize) -> f64 {
        self.solver.iteration_work(contacts)
    }

    fn boxed_clone(&self) -> Box<dyn Solver> {
        Box::new(self.clone())
    }
}

mod relaxation;
#[cfg(test)]
mod tests;
