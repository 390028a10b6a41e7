//! Rigid components: parts of a body that no element couples to the rest, moved as wholes.

use crate::components::Components;
use crate::contact::Contact;
use crate::options::RigidComponentOptions;
use nalgebra::Vector3;
use std::sync::Arc;

/// A component.
#[derive(Clone, Copy, Debug, Default)]
struct Component {
    mass: f64,
    held: bool,
    displacement: Vector3<f64>,
    /// What is left of its forces \[N\], and what that is per length \[N/m\].
    left: Vector3<f64>,
    inertia: f64,
}

impl Component {
    /// 1/m \[1/kg\]; 0 for one that is held.
    fn mobility(&self) -> f64 {
        if self.held { 0.0 } else { 1.0 / self.mass }
    }
}

/// Working memory for one body.
#[derive(Clone, Debug)]
pub struct RigidComponents {
    edge: f64,
    options: RigidComponentOptions,
    components: Arc<Components>,
    parts: Vec<Component>,
    pushes: Vec<f64>,
}

impl RigidComponents {
    /// Those of a body with the mean edge length `edge` \[m\]; `inertia` is the mass of a node \[kg\].
    pub fn new(
        components: Arc<Components>,
        edge: f64,
        inertia: impl Fn(usize) -> f64,
        options: RigidComponentOptions,
    ) -> Self {
        let mut parts = vec![Component::default(); components.lowest.len()];
        for (node, &part) in components.of_node.iter().enumerate() {
            parts[part as usize].mass += inertia(node);
        }
        Self {
            edge,
            options,
            components,
            parts,
            pushes: Vec::new(),
        }
    }

    /// Takes over which nodes are prescribed.
    fn begin(&mut self, held: impl Fn(usize) -> bool) {
        for part in &mut self.parts {
            part.held = false;
            part.displacement = Vector3::zeros();
            part.left = Vector3::zeros();
            part.inertia = 0.0;
        }
        for (node, &part) in self.components.of_node.iter().enumerate() {
            self.parts[part as usize].held |= held(node);
        }
    }

    /// Moves free components, each by its part of the mass, until all gaps are at their floors; nothing where that cannot be. `held` is
    /// whether a node is prescribed. Components on which contacts press stay: they would lose their strain. `h` is the length of the
    /// step \[s\].
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
                part.held |=
                    contact.normal_force * h * h > self.options.pressed * part.mass * self.edge;
            }
        }
        let Self {
            edge,
            options,
            components,
            parts,
            pushes,
        } = self;
        pushes.clear();
        pushes.resize(contacts.len(), 0.0);
        let mut converged = false;
        for _ in 0..options.sweeps {
            let mut largest = 0.0f64;
            for (contact, push) in contacts.iter().zip(&mut *pushes) {
                let part = |node: u32| components.of_node[node as usize] as usize;
                let first = part(contact.nodes[0]);
                let second = contact.other_side().map(part);
                let mut gap =
                    contact.gap(positions) + contact.normal.dot(&parts[first].displacement);
                let mut compliance = parts[first].mobility();
                if let Some(second) = second {
                    gap -= contact.normal.dot(&parts[second].displacement);
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
                first.displacement += change * first.mobility();
                if let Some(second) = second {
                    let second = &mut parts[second];
                    second.displacement -= change * second.mobility();
                }
            }
            converged = largest <= options.tolerance * *edge;
            if converged {
                break;
            }
        }
        if converged {
            self.displace(positions);
        }
    }

    /// Moves free components by the sum of the forces `left` over \[N\], over that of the forces per displacement of the nodes \[N/m\]: then
    /// their momentum is that of all forces to rounding. Those that would go further than [`RigidComponentOptions::balancing`] stay.
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
        let most = self.options.balancing * self.edge;
        for part in self.parts.iter_mut().filter(|part| !part.held) {
            let displacement = part.left / part.inertia;
            if displacement.norm() <= most {
                part.displacement = displacement;
            }
        }
        self.displace(positions);
    }

    fn displace(&self, positions: &mut [Vector3<f64>]) {
        for (x, &part) in positions.iter_mut().zip(&self.components.of_node) {
            *x += self.parts[part as usize].displacement;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two nodes of 1 kg are one component, a third is another; the last is held.
    #[test]
    fn rounding_is_balanced_and_what_is_not_solved_is_not() {
        let components = Components {
            of_node: vec![0, 0, 1, 2],
            lowest: vec![0, 2, 3],
        };
        let (edge, options) = (0.5, RigidComponentOptions::default());
        let mut rigid = RigidComponents::new(Arc::new(components), edge, |_| 1.0, options);
        let most = options.balancing * edge;
        let mut positions = [Vector3::zeros(); 4];
        // Per node 4 N/m: the displacement is the sum of forces over 8 N/m and over 4 N/m.
        let left = [7.0 * most, 0.0, 4.1 * most, most].map(|force| Vector3::new(0.0, force, 0.0));
        let fixed = [false, false, false, true];
        rigid.balance(&fixed, &left, |_| 4.0, &mut positions);
        let moved = positions.map(|x| x.y / most);
        assert!((moved[0] - 7.0 / 8.0).abs() < 1e-12 && moved[1] == moved[0]);
        assert_eq!(moved[2..], [0.0, 0.0]);
    }
}
