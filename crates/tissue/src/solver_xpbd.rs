//! Position-based dynamics with compliance and small steps (XPBD; Macklin, Müller, Chentanez 2016; Macklin et al. 2019).
//!
//! A step is cut in sub-steps. In each, every node flies on under weight, loads and drag,
//!
//! ```text
//! x = x_n + h (E v_n + κ a)        E = e^(−ch)   κ = (1 − E)/c
//! ```
//!
//! then the elements are projected one after another, each set in the order in which the model holds it, as constraints with
//! compliance (Gauss–Seidel), and the velocity is what came of it, (x − x_n)/h. In the limit of many iterations this is
//! backward Euler with the sub-step. Prescribed nodes move evenly and have no inverse mass.
//!
//! Contacts (`projection`) are constraints without compliance in the same loop, after the elements; they are found once per sub-step,
//! where the nodes have flown, and have the last word. The normal force published is the mean over the step, the friction force that of the last
//! sub-step.
//!
//! # Limitations
//! Small sub-steps are worth more than iterations (Macklin et al. 2019): with few of either, stiff bodies are too soft, and by
//! how much depends on the mesh and on the order of the elements. Energy falls as with backward Euler at the sub-step.
//! Linear momentum is conserved to rounding, angular momentum up to the first order of the sub-step. Loads are those of the start of a
//! sub-step.

use crate::components::{follow, projection};
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::prescribed::Prescribed;
use crate::solver::{Solver, StepFailure, StepReport};
use crate::state::{Control, NodeTarget, State};
use crate::work;
use microsim_contact_solver::{Contact, ContactStep, GapConstraint, Projection};
use nalgebra::Vector3;

/// The position-based solver, with its working memory for one model.
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
/// use microsim_tissue::{Control, Serial, Solver, SolverXpbd, State};
///
/// // A block that is clamped at one end, under its weight: ten sub-steps of one iteration.
/// let mut state = State::at_rest(&model);
/// let control = Control { gravity: [0.0, 0.0, -9.81].into(), ..Control::default() };
/// let mut solver = SolverXpbd::new(&model, 10, 1).expect("springs are constraints");
/// solver.step(&model, &mut state, &control, &[], 5e-3, &Serial)?;
/// assert!(state.energies(&model).elastic() > 0.0);
/// # Ok::<(), microsim_tissue::StepFailure>(())
/// ```
#[derive(Clone, Debug)]
pub struct SolverXpbd {
    substeps: u32,
    iterations: u32,
    prescribed: Prescribed,
    inverse_masses: Vec<f64>,
    /// Multipliers of each set.
    multipliers: Vec<Vec<f64>>,
    /// Positions, velocities at the end of a sub-step.
    positions: Vec<Vector3<f64>>,
    velocities: Vec<Vector3<f64>>,
    /// Positions at the start of a sub-step.
    previous: Vec<Vector3<f64>>,
    loads: Vec<Vector3<f64>>,
    projection: Projection,
    /// Those of a sub-step.
    contacts: Vec<Contact>,
}

impl SolverXpbd {
    /// Working memory for `model`, with this many sub-steps per step and iterations per sub-step, both at least 1. None where
    /// elements of the model are no constraints.
    pub fn new(model: &TissueModel, substeps: u32, iterations: u32) -> Option<Self> {
        let multipliers = model
            .sets()
            .iter()
            .map(|set| Some(vec![0.0; set.count() * set.constraints()?.multipliers()]));
        let zeros = vec![Vector3::zeros(); model.node_count()];
        Some(Self {
            substeps,
            iterations,
            prescribed: Prescribed::new(model.node_count()),
            inverse_masses: vec![0.0; model.node_count()],
            multipliers: multipliers.collect::<Option<_>>()?,
            positions: zeros.clone(),
            velocities: zeros.clone(),
            previous: zeros.clone(),
            loads: zeros,
            projection: projection(model),
            contacts: Vec::new(),
        })
    }

    /// Moves nodes as if no element coupled them; prescribed ones to `step_fraction` of their displacement from `start` \[m\].
    fn fly(
        &mut self,
        model: &TissueModel,
        control: &Control,
        start: &[Vector3<f64>],
        step_fraction: f64,
        h: f64,
    ) {
        self.loads.fill(Vector3::zeros());
        control.add_loads(&self.positions, &mut self.loads);
        self.previous.copy_from_slice(&self.positions);
        for (nodes, drag) in model.drags() {
            let factor = libm::exp(-drag * h);
            let kick = if *drag > 0.0 {
                -libm::expm1(-drag * h) / drag
            } else {
                h
            };
            for node in nodes.clone() {
                let w = self.inverse_masses[node];
                self.positions[node] = if w > 0.0 {
                    // Added inertia has no weight.
                    let weightless = model.added_inertia()[node] * w;
                    let acceleration =
                        control.gravity - control.gravity * weightless + self.loads[node] * w;
                    let velocity = self.velocities[node] * factor + acceleration * kick;
                    self.positions[node] + velocity * h
                } else if step_fraction == 1.0 {
                    self.prescribed.ends[node]
                } else {
                    start[node] + (self.prescribed.ends[node] - start[node]) * step_fraction
                };
            }
        }
    }

    /// Finds the contacts where the nodes have flown, as they are for a sub-step of `h` \[s\]: rigid obstacles move evenly. Those of the step
    /// are given the forces of its last sub-step.
    fn find(
        &mut self,
        step: &mut ContactStep<'_>,
        substep: u32,
        h: f64,
    ) -> Result<(), StepFailure> {
        let sum: Vector3<f64> = self.positions.iter().sum();
        if !sum.iter().all(|c| c.is_finite()) {
            return Err(StepFailure::NotFinite);
        }
        if substep == 1 {
            step.contacts.clear();
        }
        let step_fraction = f64::from(substep) / f64::from(self.substeps);
        let source = &mut step.source;
        source.find(step_fraction, &self.positions, &mut step.contacts);
        self.contacts.clear();
        for contact in &step.contacts {
            let drift = contact.drift / f64::from(substep);
            self.contacts.push(Contact {
                start_gap: contact.gap(&self.previous) + contact.normal.dot(&drift),
                drift,
                ..*contact
            });
        }
        let w = &self.inverse_masses;
        self.projection
            .begin(&mut self.contacts, |node| h * h * w[node]);
        Ok(())
    }

    /// Projects all elements once.
    fn project(&mut self, model: &TissueModel, internal: &[f64], h: f64) {
        for (index, (set, multipliers)) in
            model.sets().iter().zip(&mut self.multipliers).enumerate()
        {
            // `new` has seen that all sets are constraints.
            let Some(constraints) = set.constraints() else {
                continue;
            };
            let internal = &internal[model.internal_range(index)];
            let each = multipliers.chunks_exact_mut(constraints.multipliers());
            for (element, multipliers) in each.enumerate() {
                constraints.project(
                    element,
                    &mut self.positions,
                    &self.previous,
                    &self.inverse_masses,
                    internal,
                    multipliers,
                    h,
                );
            }
        }
    }
}

impl Solver for SolverXpbd {
    fn advance(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        mut contact: Option<&mut ContactStep<'_>>,
        h: f64,
        _exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        if !state.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        self.prescribed.set(model, state, control, targets);
        for (node, w) in self.inverse_masses.iter_mut().enumerate() {
            *w = if self.prescribed.fixed[node] {
                0.0
            } else {
                model.inverse_masses()[node]
            };
        }
        self.positions.copy_from_slice(&state.positions);
        self.velocities.copy_from_slice(&state.velocities);
        let small = h / f64::from(self.substeps);
        for substep in 1..=self.substeps {
            let step_fraction = f64::from(substep) / f64::from(self.substeps);
            self.fly(model, control, &state.positions, step_fraction, small);
            self.multipliers.iter_mut().for_each(|all| all.fill(0.0));
            if let Some(step) = contact.as_deref_mut() {
                self.find(step, substep, small)?;
            }
            for _ in 0..self.iterations {
                self.project(model, &state.internal, small);
                if contact.is_some() {
                    let start = &self.previous;
                    let constraint = GapConstraint::Positions { start };
                    let positions = &mut self.positions;
                    self.projection
                        .enforce(constraint, 1, &mut self.contacts, positions);
                }
            }
            if contact.is_some() {
                let start = &self.previous;
                let constraint = GapConstraint::Positions { start };
                let positions = &mut self.positions;
                let sweeps = self.projection.sweeps();
                self.projection
                    .enforce(constraint, sweeps, &mut self.contacts, positions);
            }
            for ((v, x), previous) in self
                .velocities
                .iter_mut()
                .zip(&self.positions)
                .zip(&self.previous)
            {
                *v = (x - previous) / small;
            }
            if let Some(step) = contact.as_deref_mut() {
                let held = |node: usize| self.inverse_masses[node] == 0.0;
                self.projection
                    .undo_overlaps(&self.contacts, held, small, &mut self.positions);
                for (contact, solved) in step.contacts.iter_mut().zip(&self.contacts) {
                    contact.normal_force = solved.normal_force;
                    contact.friction_force = solved.friction_force;
                    contact.is_sliding = solved.is_sliding;
                }
            }
        }
        self.prescribed
            .set_velocities(&state.positions, h, &mut self.velocities);
        let sum: Vector3<f64> = self
            .positions
            .iter()
            .zip(&self.velocities)
            .map(|(x, v)| x + v)
            .sum();
        if !sum.iter().all(|c| c.is_finite()) {
            return Err(StepFailure::NotFinite);
        }
        state.positions.copy_from_slice(&self.positions);
        state.velocities.copy_from_slice(&self.velocities);
        state.accelerations.clear();
        state.step = h;
        Ok(StepReport::without_residual(
            self.substeps * self.iterations,
        ))
    }

    fn least_work(&self, model: &TissueModel, _: usize) -> f64 {
        work::of_explicit_step(model) * f64::from(self.substeps * self.iterations)
    }

    fn follow(&mut self, model: &TissueModel) {
        let nodes = model.node_count();
        self.prescribed.resize(nodes);
        self.inverse_masses.resize(nodes, 0.0);
        for (set, multipliers) in model.sets().iter().zip(&mut self.multipliers) {
            // An edit adds elements of the same kind, which are constraints too.
            let each = set.constraints().map_or(0, |set| set.multipliers());
            multipliers.resize(set.count() * each, 0.0);
        }
        for values in [
            &mut self.positions,
            &mut self.velocities,
            &mut self.previous,
            &mut self.loads,
        ] {
            values.resize(nodes, Vector3::zeros());
        }
        follow(&mut self.projection, model);
    }

    fn boxed_clone(&self) -> Box<dyn Solver> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
