//! Prescribed nodes: clamps, and nodes with a target, whose motion in a step is given.

use crate::model::TissueModel;
use crate::state::{Control, NodeTarget, State};
use nalgebra::Vector3;

/// The prescribed nodes of a step.
#[derive(Clone, Debug)]
pub(crate) struct Prescribed {
    /// Which nodes.
    pub fixed: Vec<bool>,
    /// Where they are at the end of the step \[m\]; start positions for all others.
    pub ends: Vec<Vector3<f64>>,
    /// The part of their displacement that leaves no velocity \[m\].
    overlaps: Vec<(u32, Vector3<f64>)>,
}

impl Prescribed {
    /// For `nodes` nodes.
    pub fn new(nodes: usize) -> Self {
        Self {
            fixed: vec![false; nodes],
            ends: vec![Vector3::zeros(); nodes],
            overlaps: Vec::new(),
        }
    }

    /// For so many nodes from now on.
    pub fn resize(&mut self, nodes: usize) {
        self.fixed.resize(nodes, false);
        self.ends.resize(nodes, Vector3::zeros());
    }

    /// Clamps and targets of a step from `state`.
    pub fn set(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        targets: &[NodeTarget],
    ) {
        self.ends.copy_from_slice(&state.positions);
        self.overlaps.clear();
        for (fixed, w) in self.fixed.iter_mut().zip(model.inverse_masses()) {
            *fixed = *w == 0.0;
        }
        for target in targets {
            let node = target.node as usize;
            if !model.is_clamped(node) {
                self.fixed[node] = true;
                self.ends[node] = target.target;
                self.overlaps.push((target.node, target.overlap));
            }
        }
        for (node, position) in model.clamped().iter().zip(&control.clamped_positions) {
            self.ends[*node as usize] = *position;
        }
    }

    /// Gives prescribed nodes the velocity of their displacement from `start` in a step of `h` \[s\].
    pub fn set_velocities(&self, start: &[Vector3<f64>], h: f64, velocities: &mut [Vector3<f64>]) {
        for (node, fixed) in self.fixed.iter().enumerate() {
            if *fixed {
                velocities[node] = (self.ends[node] - start[node]) / h;
            }
        }
        for (node, overlap) in &self.overlaps {
            velocities[*node as usize] -= overlap / h;
        }
    }
}
