//! Connected parts of a model.

use crate::model::TissueModel;
use std::sync::Arc;

/// The parts that elements hold together, in the order of their lowest nodes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Components {
    /// The part of each node.
    pub of_node: Vec<u32>,
    /// The lowest node of each part.
    pub lowest: Vec<u32>,
}

impl Components {
    fn new(model: &TissueModel) -> Self {
        let mut groups = Groups::new(model.node_count());
        // What is made of materials couples the nodes of each tetrahedron, and no others.
        let made = model.parts_made().len();
        if made > 0 {
            model.tets().iter().for_each(|tet| groups.join(tet));
        }
        for set in &model.sets()[made..] {
            (0..set.count()).for_each(|element| groups.join(set.nodes(element)));
        }
        let mut components = Self {
            of_node: Vec::with_capacity(model.node_count()),
            lowest: Vec::new(),
        };
        for node in 0..model.node_count() as u32 {
            let root = groups.root(node);
            if root == node {
                components.of_node.push(components.lowest.len() as u32);
                components.lowest.push(node);
            } else {
                // The root is the lowest node.
                components.of_node.push(components.of_node[root as usize]);
            }
        }
        components
    }

    /// Those of the union of bodies, one after another.
    pub fn joined(bodies: &[&TissueModel]) -> Self {
        let mut joined = Self {
            of_node: Vec::new(),
            lowest: Vec::new(),
        };
        for body in bodies {
            let (first, part) = (joined.of_node.len() as u32, joined.lowest.len() as u32);
            let own = body.components();
            joined
                .of_node
                .extend(own.of_node.iter().map(|own| own + part));
            joined
                .lowest
                .extend(own.lowest.iter().map(|node| node + first));
        }
        joined
    }
}

impl TissueModel {
    /// Its connected parts.
    pub(crate) fn components(&self) -> &Arc<Components> {
        self.components
            .get_or_init(|| Arc::new(Components::new(self)))
    }
}

/// Disjoint groups of numbers, each with its lowest one.
pub(crate) struct Groups(Vec<u32>);

impl Groups {
    /// Each number alone.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Makes the groups of these numbers one.
    pub fn join(&mut self, members: &[u32]) {
        for pair in members.windows(2) {
            let (a, b) = (self.root(pair[0]), self.root(pair[1]));
            self.0[a.max(b) as usize] = a.min(b);
        }
    }

    /// The lowest number of a group.
    pub fn root(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            let next = self.0[self.0[member as usize] as usize];
            self.0[member as usize] = next;
            member = next;
        }
        member
    }
}
