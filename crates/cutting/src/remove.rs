//! Cutting by taking elements away (dissertation 3.7, figure 3.8).

use crate::crossing::Crossing;
use crate::editor::Editor;
use crate::report::{Cut, Rejected};
use crate::settings::Settings;
use crate::stroke::Stroke;
use crate::topology::Topology;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

impl Topology {
    /// Takes away all elements at crossed edges. Laid open are their mean sections.
    pub(crate) fn take_away(
        &mut self,
        mesh: &TetMesh,
        stroke: &mut Stroke,
        current: &[Vector3<f64>],
        crossings: &BTreeMap<[u32; 2], Crossing>,
        settings: &Settings,
    ) -> Result<Option<Cut>, Rejected> {
        let edges = crossings.keys();
        let gone: BTreeSet<u32> = edges
            .flat_map(|edge| self.elements_at_edge(*edge))
            .collect();
        if gone.len() == self.tets.len() {
            return Err(Rejected::NothingLeft);
        }
        let across = stroke.across;
        let mut faces = Vec::new();
        for &element in &gone {
            for corner in 0..4 {
                let Some(other) = self.neighbour(element, corner) else {
                    continue;
                };
                if other < element && gone.contains(&other) {
                    continue;
                }
                let [a, b, c] = self
                    .face(element, corner)
                    .map(|node| current[node as usize]);
                // What is taken away lies on the other side than what remains.
                faces.push((element, corner, (b - a).cross(&(c - a)).dot(&across) >= 0.0));
            }
        }
        let sheet = stroke.sheet;
        let mut editor = Editor::new(self, mesh, current);
        for &element in &gone {
            editor.touch(element);
        }
        editor.taken = gone;
        editor.across = across;
        editor.open(&faces, sheet);
        let Some(mut cut) = editor.conclude(settings) else {
            return Ok(None);
        };
        stroke.leave(&cut.edit, mesh.positions.len());
        cut.points = std::mem::take(&mut stroke.points);
        cut.crossed = crossings.len();
        Ok(Some(cut))
    }
}
