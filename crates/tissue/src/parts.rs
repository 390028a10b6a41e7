//! Parts of a model that no element couples to others, moved as wholes.

use crate::components::Components;
use crate::contact::Contact;
use crate::model::TissueModel;
use nalgebra::Vector3;
use std::sync::Arc;

/// Most sweeps over the contacts.
const SWEEPS: u32 = 50;
/// The largest change in a sweep that is none, as a share of an edge.
const DONE: f64 = 1e-10;

/// A part is pressed on by a force that would take it by this share of an edge in a step.
const PRESSED: f64 = 1e-9;

/// A part.
#[derive(Clone, Copy, Debug)]
struct Part {
    mass: f64,
    held: bool,
    way: Vector3<f64>,
    /// What is left of its forces \[N\], and what that is per length \[N/m\].
    left: Vector3<f64>,
    inertia: f64,
}

impl Part {
    /// 1/m \[1/kg\]; 0 for one that is held.
    fn mobility(&self) -> f64 {
        if self.held { 0.0 } else { 1.0 / self.mass }
    }
}

/// Working memory for one model.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    edge: f64,
    components: Arc<Components>,
    parts: Vec<Part>,
    pushes: Vec<f64>,
}

impl Parts {
    /// Those of `model`.
    pub fn new(model: &TissueModel) -> Self {
        let components = model.components().clone();
        let none = Part {
            mass: 0.0,
            held: false,
            way: Vector3::zeros(),
            left: Vector3::zeros(),
            inertia: 0.0,
        };
        let mut parts = vec![none; components.lowest.len()];
        for (node, &part) in components.of_node.iter().enumerate() {
            parts[part as usize].mass += model.inertia(node);
        }
        Self {
            edge: model.mean_edge_length(),
            components,
            parts,
            pushes: Vec::new(),
        }
    }

    /// Takes over which nodes are prescribed.
    fn begin(&mut self, held: impl Fn(usize) -> bool) {
        for part in &mut self.parts {
            part.held = false;
            part.way = Vector3::zeros();
            part.left = Vector3::zeros();
            part.inertia = 0.0;
        }
        for (node, &part) in self.components.of_node.iter().enumerate() {
            self.parts[part as usize].held |= held(node);
        }
    }

    /// Moves free parts, each by its share of mass, until all gaps are at their floors; nothing where that cannot be. `held` says of a
    /// node whether it is prescribed. Parts that are pressed on stay: they would lose what they are strained. `h` is the length of
    /// the step \[s\].
    pub fn separate(
        &mut self,
        contacts: &[Contact],
        held: impl Fn(usize) -> bool,
        h: f64,
        positions: &mut [Vector3<f64>],
    ) {
        self.begin(held);
        for contact in contacts {
            let sides = [Some(contact.nodes[0]), contact.other_side()];
            for node in sides.into_iter().flatten() {
                let part = &mut self.parts[self.components.of_node[node as usize] as usize];
                part.held |= contact.normal_force * h * h > PRESSED * part.mass * self.edge;
            }
        }
        let Self {
            edge,
            components,
            parts,
            pushes,
        } = self;
        pushes.clear();
        pushes.resize(contacts.len(), 0.0);
        let mut settled = false;
        for _ in 0..SWEEPS {
            let mut largest = 0.0f64;
            for (contact, push) in contacts.iter().zip(&mut *pushes) {
                let part = |node: u32| components.of_node[node as usize] as usize;
                let first = part(contact.nodes[0]);
                let second = contact.other_side().map(part);
                let mut gap = contact.gap(positions) + contact.normal.dot(&parts[first].way);
                let mut compliance = parts[first].mobility();
                if let Some(second) = second {
                    gap -= contact.normal.dot(&parts[second].way);
                    compliance += parts[second].mobility();
                }
                if compliance == 0.0 || second == Some(first) {
                    continue;
                }
                let pushed = (*push + (contact.floor - gap) / compliance).max(0.0);
                let change = contact.normal * (pushed - *push);
                largest = largest.max((pushed - *push).abs() * compliance);
                *push = pushed;
                let first = &mut parts[first];
                first.way += change * first.mobility();
                if let Some(second) = second {
                    let second = &mut parts[second];
                    second.way -= change * second.mobility();
                }
            }
            settled = largest <= DONE * *edge;
            if settled {
                break;
            }
        }
        if settled {
            self.go(positions);
        }
    }

    /// Moves free parts by what is left of their forces \[N\], over the sum of what a way of a node takes \[N/m\].
    pub fn balance(
        &mut self,
        fixed: &[bool],
        left: &[Vector3<f64>],
        inertia: impl Fn(usize) -> f64,
        positions: &mut [Vector3<f64>],
    ) {
        self.begin(|node| fixed[node]);
        for (node, (&part, left)) in self.components.of_node.iter().zip(left).enumerate() {
            let part = &mut self.parts[part as usize];
            part.left += left;
            part.inertia += inertia(node);
        }
        for part in self.parts.iter_mut().filter(|part| !part.held) {
            part.way = part.left / part.inertia;
        }
        self.go(positions);
    }

    fn go(&self, positions: &mut [Vector3<f64>]) {
        for (x, &part) in positions.iter_mut().zip(&self.components.of_node) {
            *x += self.parts[part as usize].way;
        }
    }
}
