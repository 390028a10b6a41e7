//! Forces on the nodes of a body: elements, weight, loads.

use crate::elements::{Configuration, NodeWindow};
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::state::{Control, State};
use nalgebra::Vector3;
use std::sync::{Mutex, PoisonError};

/// Working memory for forces on one model.
///
/// A large body is computed in parts that the model alone fixes: part `p` adds its elements of every set of elements to a buffer
/// of its own, and each node sums the buffers in the order of the parts. So the bits do not depend on the executor.
#[derive(Clone, Debug)]
pub struct Forces {
    /// One per part, over the run of nodes that the part touches; empty for a body of one part.
    buffers: Vec<Vec<Vector3<f64>>>,
    total: Vec<Vector3<f64>>,
}

impl Forces {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel) -> Self {
        let buffers = match model.parts() {
            [_] => Vec::new(),
            parts => parts
                .iter()
                .map(|part| vec![Vector3::zeros(); part.nodes.len()])
                .collect(),
        };
        Self {
            buffers,
            total: vec![Vector3::zeros(); model.node_count()],
        }
    }

    /// Follows an edit of the model.
    pub fn follow(&mut self, model: &TissueModel) {
        let parts = match model.parts() {
            [_] => &[],
            parts => parts,
        };
        self.buffers.resize(parts.len(), Vec::new());
        for (buffer, part) in self.buffers.iter_mut().zip(parts) {
            buffer.resize(part.nodes.len(), Vector3::zeros());
        }
        self.total.resize(model.node_count(), Vector3::zeros());
    }

    /// The force on each node \[N\] at positions and velocities of `state`: elastic, viscous, weight and loads. Drag is not in
    /// it: integrators treat it exactly. On a clamped node it is what the clamp holds.
    pub fn compute(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        for (force, mass) in self.total.iter_mut().zip(model.masses()) {
            *force = control.gravity * *mass;
        }
        control.add_loads(&state.positions, &mut self.total);
        self.add_elements(model, state, exec);
        &self.total
    }

    /// The forces of the last [`compute`](Self::compute) \[N\].
    pub fn last(&self) -> &[Vector3<f64>] {
        &self.total
    }

    fn add_elements(&mut self, model: &TissueModel, state: &State, exec: &dyn Executor) {
        let at = |set: usize| Configuration {
            positions: &state.positions,
            velocities: &state.velocities,
            internal: &state.internal[model.internal_range(set)],
        };
        if let [part] = model.parts() {
            let mut window = NodeWindow {
                first: 0,
                values: &mut self.total,
            };
            for (set, elements) in model.sets().iter().enumerate() {
                elements.add_forces(part.elements[set].clone(), &at(set), &mut window);
            }
            return;
        }
        // Each buffer is locked once, by the one part that owns it: the lock only proves to the compiler that they are
        // disjoint.
        let buffers: Vec<Mutex<&mut Vec<Vector3<f64>>>> =
            self.buffers.iter_mut().map(Mutex::new).collect();
        exec.for_each(buffers.len(), &|index| {
            let mut buffer = buffers[index]
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            buffer.fill(Vector3::zeros());
            let part = &model.parts()[index];
            let mut window = NodeWindow {
                first: part.nodes.start,
                values: &mut buffer,
            };
            for (set, elements) in model.sets().iter().enumerate() {
                elements.add_forces(part.elements[set].clone(), &at(set), &mut window);
            }
        });
        for (part, buffer) in model.parts().iter().zip(&self.buffers) {
            let run = part.nodes.start as usize..part.nodes.end as usize;
            for (force, share) in self.total[run].iter_mut().zip(buffer) {
                *force += share;
            }
        }
    }
}
