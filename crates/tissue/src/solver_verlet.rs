//! Leapfrog (Störmer–Verlet) in the joint form (3.17, NUMERICS 2.2–2.4) with an exact drag factor.
//!
//! The scheme is velocity Verlet with the factor e^(−ch/2) on the velocity before and after each step (NUMERICS 3.1), written
//! for the velocity u = (p_n − p_{n−1})/h_old in the middle of a step. With E = e^(−c(h_old+h)/2) and the kick time
//! γ = (E·h_old + h)/2:
//!
//! ```text
//! u' = E u + γ F/m        p' = p + h u'
//! ```
//!
//! For c = 0 and constant h this is p' = 2p − p_{n−1} + h²F/m. The first step has h_old = 0, a later one may have another h:
//! the formula is velocity Verlet in every case. The drag enters as a factor, never as a force from an old velocity, so the
//! limit stays h·ω < 2 for every c ≥ 0 without viscosity.
//!
//! The force that lands a node on its target p* is, with the predicted position p̃ = p + h(E u + γ F/m),
//!
//! ```text
//! F̂ = (m/(h γ)) (p* − p̃)
//! ```
//!
//! which is (m/h²)(p* − 2p + p_{n−1}) − F for c = 0 and constant h (NUMERICS 2). All forces of a step are known before F̂ is
//! formed, so any number of nodes is prescribed at once, and exactly.
//!
//! # Limitations
//! Explicit: the step is bounded (`stability`). Energy oscillates but does not drift; momentum of internal forces is
//! conserved to rounding. A change of h keeps second order but not symplecticity. Velocities are those of the middle of a
//! step. Viscous forces are those of u, half a step old: with them the scheme is of first order (the decay rate of a mode is
//! 1 + δ/2 times the right one, δ = h τ ω²) and the limit falls to h²ω² < 4 − 2δ (NUMERICS 3.1). Loads and clamps are taken as
//! given for the end of the step: a load that changes is followed to first order only.

use crate::components::{follow, projection};
use crate::executor::Executor;
use crate::forces::Forces;
use crate::model::TissueModel;
use crate::solver::{Solver, StepFailure, StepReport};
use crate::state::{Control, NodeTarget, State};
use microsim_contact_solver::{ContactStep, Projection};
use nalgebra::Vector3;

/// The leapfrog solver, with its working memory for one model; it has no state of its own between steps.
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
/// use microsim_tissue::{Control, NodeTarget, Serial, Solver, SolverVerlet, State};
///
/// // The last node of a block is moved by 10 µm, exactly.
/// let mut state = State::at_rest(&model);
/// let node = model.node_count() - 1;
/// let target = state.positions[node] + nalgebra::Vector3::z() * 1e-5;
/// let targets = [NodeTarget { node: node as u32, target, overlap: nalgebra::Vector3::zeros() }];
/// SolverVerlet::new(&model).step(&model, &mut state, &Control::default(), &targets, 1e-5, &Serial)?;
/// assert!((state.positions[node] - target).norm() < 1e-18);
/// # Ok::<(), microsim_tissue::StepFailure>(())
/// ```
#[derive(Clone, Debug)]
pub struct SolverVerlet {
    forces: Forces,
    /// p̃ \[m\].
    predicted: Vec<Vector3<f64>>,
    /// u' without contact \[m/s\].
    predicted_velocities: Vec<Vector3<f64>>,
    /// h of the prediction \[s\].
    step: f64,
    /// γ of the prediction, of each node \[s\].
    kicks: Vec<f64>,
    projection: Projection,
    /// Marks of the nodes with a target.
    prescribed: Vec<bool>,
}

impl SolverVerlet {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel) -> Self {
        let zeros = vec![Vector3::zeros(); model.node_count()];
        Self {
            forces: Forces::new(model),
            predicted: zeros.clone(),
            predicted_velocities: zeros,
            step: 0.0,
            kicks: vec![0.0; model.node_count()],
            projection: projection(model),
            prescribed: vec![false; model.node_count()],
        }
    }

    /// First half of a step of length `h` \[s\]: where each node would be after it without contact \[m\]. Contact is
    /// sought there, so that a node is stopped at a surface before it is inside.
    fn predict(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        h: f64,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        let forces = self.forces.compute(model, state, control, exec);
        self.step = h;
        for (nodes, drag) in model.drags() {
            let factor = libm::exp(-0.5 * drag * (state.step + h));
            let kick = 0.5 * (factor * state.step + h);
            self.kicks[nodes.clone()].fill(kick);
            for node in nodes.clone() {
                // A clamped node stands still; what moves it is added below.
                let w = model.inverse_masses()[node];
                let velocity = if w == 0.0 {
                    Vector3::zeros()
                } else {
                    state.velocities[node] * factor + forces[node] * (kick * w)
                };
                self.predicted_velocities[node] = velocity;
                self.predicted[node] = state.positions[node] + velocity * h;
            }
        }
        for (node, position) in model.clamped().iter().zip(&control.clamped_positions) {
            let node = *node as usize;
            self.predicted[node] = *position;
            self.predicted_velocities[node] = (position - state.positions[node]) / h;
        }
        for (node, target) in &control.carried {
            let node = *node as usize;
            if !model.is_clamped(node) {
                self.predicted_velocities[node] += (target - self.predicted[node]) / h;
                self.predicted[node] = *target;
            }
        }
        &self.predicted
    }

    /// Second half of the step begun by [`predict`](Self::predict) on the same state: adds the forces that move nodes
    /// to their `targets`, and moves all nodes.
    fn finish(&self, model: &TissueModel, state: &mut State, targets: &[NodeTarget]) {
        for node in 0..model.node_count() {
            state.positions[node] = self.predicted[node];
        }
        state.velocities.copy_from_slice(&self.predicted_velocities);
        for target in targets {
            let node = target.node as usize;
            let w = model.inverse_masses()[node];
            if w == 0.0 {
                continue;
            }
            let force =
                self.contact_force(model, target.node, &(target.target - self.predicted[node]));
            let kicked = force * (self.kicks[node] * w);
            state.positions[node] += kicked * self.step;
            // The part of the motion that only undid an old overlap must not go on as velocity.
            state.velocities[node] += kicked - target.overlap / self.step;
        }
        state.step = self.step;
    }

    /// The second half of a step in which non-penetration is enforced.
    fn enforce_contact(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        targets: &[NodeTarget],
        contact: &mut ContactStep<'_>,
    ) -> Result<(), StepFailure> {
        let h = self.step;
        self.prescribed.fill(false);
        for target in targets {
            let node = target.node as usize;
            if !model.is_clamped(node) {
                let displacement = target.target - self.predicted[node];
                self.predicted[node] = target.target;
                self.predicted_velocities[node] += (displacement - target.overlap) / h;
                self.prescribed[node] = true;
            }
        }
        let mobility = |node: usize| match self.prescribed[node] {
            true => 0.0,
            false => h * self.kicks[node] * model.inverse_masses()[node],
        };
        let is_touched =
            self.projection
                .project(contact, &state.positions, mobility, h, &mut self.predicted);
        if is_touched {
            let changes = self.projection.changes();
            for (velocity, change) in self.predicted_velocities.iter_mut().zip(changes) {
                *velocity += change / h;
            }
        }
        let sum: Vector3<f64> = self.predicted.iter().sum();
        if !sum.iter().all(|c| c.is_finite()) {
            return Err(StepFailure::NotFinite);
        }
        self.finish(model, state, &[]);
        Ok(())
    }

    /// The force F̂ \[N\] that moves a node by `correction` \[m\] from where the step begun by [`predict`](Self::predict) would
    /// bring it. Zero for a clamped node.
    fn contact_force(
        &self,
        model: &TissueModel,
        node: u32,
        correction: &Vector3<f64>,
    ) -> Vector3<f64> {
        let w = model.inverse_masses()[node as usize];
        if w == 0.0 {
            Vector3::zeros()
        } else {
            correction / (self.step * self.kicks[node as usize] * w)
        }
    }

    /// The force on each node \[N\] at the state's positions, as in [`Forces::compute`].
    pub fn forces(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        self.forces.compute(model, state, control, exec)
    }
}

impl Solver for SolverVerlet {
    fn advance(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        targets: &[NodeTarget],
        contact: Option<&mut ContactStep<'_>>,
        h: f64,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        let predicted = self.predict(model, state, control, h, exec);
        // A velocity is a difference of positions, a target a position: with these all is finite.
        let ends = targets.iter();
        let sum: Vector3<f64> = predicted.iter().sum::<Vector3<f64>>()
            + ends.map(|t| t.target + t.overlap).sum::<Vector3<f64>>();
        if !sum.iter().all(|c| c.is_finite()) {
            return Err(StepFailure::NotFinite);
        }
        match contact {
            None => self.finish(model, state, targets),
            Some(contact) => self.enforce_contact(model, state, targets, contact)?,
        }
        Ok(StepReport::without_residual(1))
    }

    fn follow(&mut self, model: &TissueModel) {
        let nodes = model.node_count();
        self.forces.follow(model);
        self.predicted.resize(nodes, Vector3::zeros());
        self.predicted_velocities.resize(nodes, Vector3::zeros());
        self.kicks.resize(nodes, 0.0);
        follow(&mut self.projection, model);
        self.prescribed.resize(nodes, false);
    }

    fn boxed_clone(&self) -> Box<dyn Solver> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
