//! Störmer–Verlet in the joint form (3.17, NUMERICS 2.2–2.4) with an exact drag factor.
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
//! limit stays h·ω < 2 for every c ≥ 0.
//!
//! The force that lands a node on its target p* is, with the predicted position p̃ = p + h(E u + γ F/m),
//!
//! ```text
//! F̂ = (m/(h γ)) (p* − p̃)
//! ```
//!
//! which is (m/h²)(p* − 2p + p_{n−1}) − F for c = 0 and constant h (NUMERICS 2). All forces of a step are known before F̂ is
//! formed, so any number of nodes is led at once, and exactly.
//!
//! # Limitations
//! Explicit: the step is bounded (`stability`). Energy oscillates but does not drift; momentum of internal forces is
//! conserved to rounding. A change of h keeps second order but not symplecticity. Velocities are those of the middle of a
//! step.

use crate::energies::{length_gradient, volume_gradient};
use crate::executor::{Executor, fill};
use crate::model::TissueModel;
use crate::state::{Contacts, Control, State};
use nalgebra::Vector3;

/// The solver: working memory for one model, no state of its own between steps.
#[derive(Clone, Debug)]
pub struct SolverVerlet {
    /// Force on the first end of each spring [N]; empty in a body whose forces are added in place.
    spring_forces: Vec<Vector3<f64>>,
    /// Forces on the corners of each volume element [N]; likewise.
    volume_forces: Vec<[Vector3<f64>; 4]>,
    /// Force on each node [N].
    forces: Vec<Vector3<f64>>,
    /// p̃ [m].
    predicted: Vec<Vector3<f64>>,
    /// u' without contact [m/s].
    predicted_velocities: Vec<Vector3<f64>>,
    /// h of the prediction [s].
    step: f64,
    /// γ of the prediction [s].
    kick: f64,
}

impl SolverVerlet {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel) -> Self {
        let zeros = vec![Vector3::zeros(); model.node_count()];
        Self {
            spring_forces: Vec::new(),
            volume_forces: Vec::new(),
            forces: zeros.clone(),
            predicted: zeros.clone(),
            predicted_velocities: zeros,
            step: 0.0,
            kick: 0.0,
        }
    }

    /// One step of length `h` [s] with contacts that are known beforehand.
    pub fn step(
        &mut self,
        model: &TissueModel,
        state: &mut State,
        control: &Control,
        contacts: &Contacts,
        h: f64,
        exec: &dyn Executor,
    ) {
        self.predict(model, state, control, h, exec);
        self.finish(model, state, contacts);
    }

    /// First half of a step of length `h` [s]: where each node would be after it without contact [m]. Contact is
    /// sought there, so that a node is stopped at a surface before it is inside.
    pub fn predict(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        h: f64,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        self.forces(model, state, control, exec);
        let factor = libm::exp(-0.5 * model.drag() * (state.step + h));
        self.step = h;
        self.kick = 0.5 * (factor * state.step + h);
        for (node, &w) in model.inverse_masses().iter().enumerate() {
            // A clamped node keeps position and velocity 0.
            let velocity = if w == 0.0 {
                Vector3::zeros()
            } else {
                state.velocities[node] * factor + self.forces[node] * (self.kick * w)
            };
            self.predicted_velocities[node] = velocity;
            self.predicted[node] = state.positions[node] + velocity * h;
        }
        &self.predicted
    }

    /// Second half of the step begun by [`predict`](Self::predict) on the same state: adds the forces that lead the nodes
    /// of `contacts` to their targets, and moves all nodes.
    pub fn finish(&self, model: &TissueModel, state: &mut State, contacts: &Contacts) {
        for node in 0..model.node_count() {
            state.positions[node] = self.predicted[node];
        }
        state.velocities.copy_from_slice(&self.predicted_velocities);
        for target in &contacts.targets {
            let node = target.node as usize;
            let w = model.inverse_masses()[node];
            if w == 0.0 {
                continue;
            }
            let force =
                self.contact_force(model, target.node, &(target.target - self.predicted[node]));
            let kicked = force * (self.kick * w);
            state.positions[node] += kicked * self.step;
            // The part of the motion that only undid an old overlap must not go on as velocity.
            state.velocities[node] += kicked - target.overlap / self.step;
        }
        state.step = self.step;
    }

    /// The force F̂ [N] that moves a node by `correction` [m] from where the step begun by [`predict`](Self::predict) would
    /// bring it. Zero for a clamped node.
    pub fn contact_force(
        &self,
        model: &TissueModel,
        node: u32,
        correction: &Vector3<f64>,
    ) -> Vector3<f64> {
        let w = model.inverse_masses()[node as usize];
        if w == 0.0 {
            Vector3::zeros()
        } else {
            correction / (self.step * self.kick * w)
        }
    }

    /// Elastic force and weight of each node [N], at the state's positions. On a clamped node it is what the clamp holds.
    pub fn forces(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        match model.parts() {
            1 => self.forces_in_place(model, state, control),
            parts => self.forces_in_parts(model, state, control, parts, exec),
        }
        &self.forces
    }

    /// Adds each element to its nodes: the fastest way on one thread. Every node gets its weight, then its springs, then its
    /// volume elements, in ascending order, as in [`forces_in_parts`](Self::forces_in_parts): the bits are the same.
    fn forces_in_place(&mut self, model: &TissueModel, state: &State, control: &Control) {
        let p = &state.positions;
        for (force, mass) in self.forces.iter_mut().zip(model.masses()) {
            *force = control.gravity * *mass;
        }
        for spring in model.springs() {
            let [i, j] = spring.nodes.map(|node| node as usize);
            let at_first = length_gradient([&p[i], &p[j]], spring.rest_length, spring.stiffness);
            self.forces[i] += at_first;
            self.forces[j] -= at_first;
        }
        for volume in model.volumes() {
            let corners = volume.nodes.map(|node| &p[node as usize]);
            let forces = volume_gradient(corners, volume.rest_volume, -volume.stiffness);
            for (node, force) in volume.nodes.iter().zip(forces) {
                self.forces[*node as usize] += force;
            }
        }
    }

    /// Computes every element once, into its own place; then every node gathers its elements in ascending order. No two
    /// parts write to one place, and no sum depends on the parts.
    fn forces_in_parts(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        parts: usize,
        exec: &dyn Executor,
    ) {
        let p = &state.positions;
        self.spring_forces
            .resize(model.springs().len(), Vector3::zeros());
        self.volume_forces
            .resize(model.volumes().len(), [Vector3::zeros(); 4]);
        fill(exec, parts, &mut self.spring_forces, |index| {
            let spring = &model.springs()[index];
            let ends = spring.nodes.map(|node| &p[node as usize]);
            length_gradient(ends, spring.rest_length, spring.stiffness)
        });
        fill(exec, parts, &mut self.volume_forces, |index| {
            let volume = &model.volumes()[index];
            let corners = volume.nodes.map(|node| &p[node as usize]);
            volume_gradient(corners, volume.rest_volume, -volume.stiffness)
        });
        let (springs, volumes) = (&self.spring_forces, &self.volume_forces);
        fill(exec, parts, &mut self.forces, |node| {
            let mut force = control.gravity * model.masses()[node];
            for &end in model.spring_ends(node) {
                // +1 at the first end, −1 at the second, without a branch that could not be foretold.
                let sign = 1.0 - 2.0 * f64::from(end % 2);
                force += springs[end as usize / 2] * sign;
            }
            for &corner in model.volume_corners(node) {
                force += volumes[corner as usize / 4][corner as usize % 4];
            }
            force
        });
    }
}

#[cfg(test)]
mod tests;
