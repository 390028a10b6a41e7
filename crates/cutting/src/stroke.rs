//! What a blade has cut so far on its path.
//!
//! A crossed edge gets a node on the blade's path. What the mesh needs to open is a face with all three nodes on it and
//! elements on both sides; while a blade is in progress such faces come one after another. A stroke remembers the nodes on the
//! path and, for the elements there, on which side their other corners lie, until the blade has left the tissue.

use crate::path::PathPoints;
use microsim_mesh::TopologyEdit;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// One pass of a blade through one body. Plain data: it is saved with the mesh between two generations. It begins again by itself when the blade
/// is clear of all elements, or turns by more than 45°; a caller may begin a new one at any time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stroke {
    /// Number of its sheet in the body, from 1; 0 before the first crossing.
    pub sheet: u32,
    /// Nodes on the path.
    pub path: BTreeSet<u32>,
    /// For elements at the path: on which side each corner lies. 1 positive, −1 negative, 0 not known. Of a corner on the path
    /// the side of what it was divided from.
    pub sides: BTreeMap<u32, [i8; 4]>,
    /// The side to which elements with all corners on the path were given.
    pub given: BTreeMap<u32, i8>,
    /// Towards the positive side, where the blade was last \[-\]; zero before the first crossing.
    pub normal: Vector3<f64>,
    /// Where the blade crossed edges since something was last opened.
    pub points: PathPoints,
}

impl Stroke {
    /// A blade that has not yet cut.
    pub fn new() -> Self {
        Self::default()
    }

    /// The sides of the corners of `element`.
    pub(crate) fn sides_of(&self, element: u32) -> [i8; 4] {
        self.sides.get(&element).copied().unwrap_or_default()
    }

    /// Updates the stroke after an edit of another one, of a mesh that had so many nodes and elements: copies of nodes on the path are on it,
    /// children know no sides of their own. Its own edits are part of it already.
    pub fn update_after_edit(&mut self, edit: &TopologyEdit, nodes: usize, elements: usize) {
        for (k, new) in edit.nodes.iter().enumerate() {
            if new.fraction == 0.0 && self.path.contains(&new.between[0]) {
                self.path.insert((nodes + k) as u32);
            }
        }
        for replaced in edit.elements.iter().filter(|r| r.children.len() > 1) {
            self.sides.remove(&replaced.element);
            self.given.remove(&replaced.element);
        }
        self.leave(edit, nodes, elements);
    }

    /// Removes what an edit removes.
    pub(crate) fn leave(&mut self, edit: &TopologyEdit, nodes: usize, elements: usize) {
        for gone in &edit.removed {
            self.sides.remove(gone);
            self.given.remove(gone);
        }
        for (from, to) in edit.element_moves(elements) {
            if let Some(sides) = self.sides.remove(&from) {
                self.sides.insert(to, sides);
            }
            if let Some(side) = self.given.remove(&from) {
                self.given.insert(to, side);
            }
        }
        for gone in &edit.removed_nodes {
            self.path.remove(gone);
        }
        for (from, to) in edit.node_moves(nodes) {
            if self.path.remove(&from) {
                self.path.insert(to);
            }
        }
    }
}
