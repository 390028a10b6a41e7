//! A body after an edit of its mesh.

use super::Body;
use crate::edits::nodes_after_edit;
use microsim_mesh::{TetMesh, TopologyEdit};
use microsim_tissue::{Method, ModelChange, ModelEdit, stability};

/// Fraction of the stability limit at the longest step of a body that the mass floor preserves after a cut (NUMERICS 3.5 c).
const FLOOR: f64 = 0.9;

/// An edit that does not fit a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Misfit;

impl Body {
    /// Builds what edits look up, and reserves memory for what they add: else the first ones take that time.
    pub(crate) fn prepare_edits(&mut self) {
        let Some(topology) = &mut self.topology else {
            return;
        };
        topology.make_room();
        self.model.prepare_edits();
        let TetMesh {
            positions,
            node_ids,
            tets,
            element_ids,
            regions,
            directions,
            prestretches,
            ..
        } = &mut self.mesh;
        let (nodes, elements) = (positions.len() / 2, tets.len() / 2);
        positions.reserve(nodes);
        node_ids.reserve(nodes);
        tets.reserve(elements);
        element_ids.reserve(elements);
        regions.reserve(elements);
        directions.reserve(directions.len() / 2);
        prestretches.reserve(prestretches.len() / 2);
    }

    /// Updates mesh, model and drive after an edit. The surface is then still that of the mesh before. After an error the body is of no
    /// use any more.
    pub(crate) fn update_after_edit(
        &mut self,
        edit: &TopologyEdit,
        method: &Method,
    ) -> Result<ModelChange, Misfit> {
        let old = self.mesh.positions.len();
        self.mesh.apply(edit).map_err(|_| Misfit)?;
        // The model is still that of the mesh before.
        self.pieces.update_after_edit(edit, self.model.tets());
        let edit_of_model = ModelEdit::new(&self.mesh, edit, self.model.clamped());
        let change = self.model.edit(&edit_of_model);
        let change = change.map_err(|_| Misfit)?;
        let (model, touched) = (&mut self.model, &change.touched);
        stability::floor_nodes(model, touched, method, self.stable_step, FLOOR);
        self.start.edit(&change);
        self.drive
            .update_after_edit(edit, old, &self.mesh, self.model.clamped());
        if let Some(lumen) = &mut self.lumen {
            lumen.update_after_edit(edit, old);
        }
        for nodes in &mut self.end_nodes {
            *nodes = nodes_after_edit(nodes.iter().copied(), edit, old);
        }
        Ok(change)
    }
}
