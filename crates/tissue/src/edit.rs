//! Edits of a body: its model and its state follow a mesh of which a few elements were cut, split or taken away.
//!
//! A [`ModelEdit`] states in plain data what became of nodes and elements; [`TissueModel::edit`] then rebuilds what is made of a
//! changed tetrahedron, by what the edit touches and not by the body, and states in a [`ModelChange`] what a [`State`] has to
//! follow. What is dirty is decided by keys of few nodes: the edge of a spring, the face of a triangle, the corners of a
//! tetrahedron, the edge or the node of a domain. Elements with such a key inside an old tetrahedron that is gone, or inside a new one,
//! go; those of the mesh after the edit come, each from all tetrahedra around its key. So the model is the one that
//! [`build_model`](crate::build_model) makes of that mesh, up to the order of its elements; patches of
//! [`Discretisation::PatchPressure`](crate::Discretisation::PatchPressure) are formed again among the elements of those that were
//! touched. Retained from before are the characteristic length, the inertia added to nodes away from the edit, and factors of a
//! stiffness cap on elements away from it.
//!
//! # Plastic flow
//! A new element inherits the mean plastic stretch of its rest value, and the mean stiffening, of what it was: an element that
//! persists, or part of an element (of an edge, a face, a tetrahedron), that of this one; a new edge or face inside of elements,
//! that of all edges or faces of these; an element of which a corner has merged with another node, that of this element. So does a continuum: the mean of F_p⁻¹ by volume with its determinant brought back to 1, of what it was or is a part
//! of, or around a new edge or node of what is around those of the elements in which it is. A tie that breaks is broken on all copies of its node.
//!
//! # Cost
//! A cut that divides 40 to 60 elements takes 0.15 ms (tetrahedra), 0.35 ms (springs) to 0.6 ms (selective) of one core with state, mass
//! floor and an explicit solver, the 99th of a hundred 0.25 to 1.2 ms, in bodies of 10,000 to 100,000 tetrahedra alike. What goes with the
//! body: 4 ns per node for the parts that a solver is given; memory once a body has half as many elements again as at the
//! start, 5 ms at 100,000 tetrahedra; pieces that come off, whose parts are found again, 10 ns per tetrahedron; a union of bodies,
//! rebuilt, 5 to 40 ns per tetrahedron; and what an implicit solver knows of the pattern, 0.7 ms (tetrahedra) to 2.6 ms (selective) at 3,200
//! tetrahedra, 2.2 and 9.6 ms at 10,500, beside a step of 3.6 and 14 ms (`cargo run --release -p microsim-tissue --example edit_time`).
//!
//! # Limitations
//! A clone and the union of several bodies hold the sets of a model in common with it: the first edit then copies each
//! set that it touches. A union cannot be edited itself: rebuild it of its members. New nodes of an interface are not tied
//! by a coupling; what holds them are the ties around.

mod error;
mod index;
mod pieces;
mod plan;
mod sets;
mod state;

#[cfg(test)]
use crate::element_index::Index;
pub use error::EditError;
pub use state::ModelChange;

use crate::model::TissueModel;
use microsim_mesh::{TetMesh, TopologyEdit};
use plan::Plan;

/// What became of the nodes and elements of a body's mesh.
///
/// In this order: elements are replaced, further ones and new nodes are appended; then elements, and nodes that are no longer used, leave
/// from the largest number down, the last one taking the place of the one that left (`swap_remove`). Numbers of nodes are those
/// after appending and before leaving, but in `mesh`.
#[derive(Clone, Debug)]
pub struct ModelEdit<'a> {
    /// The mesh after the edit.
    pub mesh: &'a TetMesh,
    /// Elements in whose place there is another one now, ascending.
    pub replaced: Vec<u32>,
    /// For each appended element the one before the edit of which it is a part.
    pub parents: Vec<u32>,
    /// Each new node as a point of the line between two others with smaller numbers: a + s (b − a). A copy has s = 0.
    pub new_nodes: Vec<([u32; 2], f64)>,
    /// Whether each new node is fixed in space.
    pub clamped: Vec<bool>,
    /// Elements that leave, ascending.
    pub removed_elements: Vec<u32>,
    /// Nodes that leave, ascending.
    pub removed_nodes: Vec<u32>,
}

impl<'a> ModelEdit<'a> {
    /// That of an edit that has been applied to `mesh`, for a body with these clamped nodes before, ascending: a new node is fixed
    /// where all that it comes from is.
    pub fn new(mesh: &'a TetMesh, edit: &TopologyEdit, clamped_before: &[u32]) -> Self {
        let nodes = mesh.positions.len() + edit.removed_nodes.len() - edit.nodes.len();
        let mut clamped: Vec<bool> = Vec::with_capacity(edit.nodes.len());
        for node in &edit.nodes {
            let fixed = |node: u32| match (node as usize).checked_sub(nodes) {
                None => clamped_before.binary_search(&node).is_ok(),
                Some(new) => clamped.get(new).copied().unwrap_or(false),
            };
            let [a, b] = node.between;
            clamped.push(fixed(a) && (node.fraction == 0.0 || fixed(b)));
        }
        let parents = edit.elements.iter().flat_map(|replacement| {
            let further = replacement.children.len() - 1;
            std::iter::repeat_n(replacement.element, further)
        });
        Self {
            mesh,
            replaced: edit.elements.iter().map(|r| r.element).collect(),
            parents: parents.collect(),
            new_nodes: edit.nodes.iter().map(|n| (n.between, n.fraction)).collect(),
            clamped,
            removed_elements: edit.removed.clone(),
            removed_nodes: edit.removed_nodes.clone(),
        }
    }
}

impl TissueModel {
    /// Follows an edit of the mesh. After an error the model is as it was.
    ///
    /// The first edit of a body builds an index of its elements and copies the sets that clones hold too, in a time that goes with the
    /// body; [`prepare_edits`](Self::prepare_edits) does so before.
    pub fn edit(&mut self, edit: &ModelEdit<'_>) -> Result<ModelChange, EditError> {
        // Both are those of the body before all edits, or follow from them, whenever they are asked for: equal edits give equal bits.
        self.rate_bound();
        match self.has_sliding() {
            // What has ever been in a sum would depend on the path.
            true => drop(self.row_sums.take()),
            false => {
                self.row_sums();
            }
        }
        let plan = Plan::new(self, edit)?;
        Ok(self.follow(edit, &plan))
    }
}

#[cfg(test)]
mod tests;
