//! Tearing: faces that fail, whatever made them.

use crate::editor::Editor;
use crate::fibre::Fibre;
use crate::opening::FaceToOpen;
use crate::report::{Cut, Rejected};
use crate::settings::Settings;
use crate::topology::Topology;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::BTreeMap;

impl Topology {
    /// Opens inner faces, each given by an element and the corner opposite to the face; which ones the strain in them
    /// decides. `None` when nothing comes apart: a face whose nodes all hold together around it stays closed, and counts as
    /// torn as soon as others let them go. Nothing is divided. Nodes are now at `current` \[m\].
    ///
    /// `shreds` are elements that rupture themselves: they are taken away like crumbs. Of what they lay open that counts which they held together: their mean sections across the
    /// direction in which they are stretched, but no more than the faces at which they hung ahead of them, or behind, seen along it. A shred that hung on one side
    /// only lays open nothing.
    ///
    /// The topology is then that of the next generation, as after [`Topology::cut`].
    pub fn tear(
        &mut self,
        mesh: &TetMesh,
        faces: &[(u32, u8)],
        shreds: &BTreeMap<u32, Fibre>,
        current: &[Vector3<f64>],
        settings: &Settings,
    ) -> Result<Option<Cut>, Rejected> {
        if mesh.generation != self.generation {
            return Err(Rejected::Generation {
                mesh: mesh.generation,
                topology: self.generation,
            });
        }
        if current.len() != mesh.positions.len() {
            return Err(Rejected::Positions {
                nodes: mesh.positions.len(),
                positions: current.len(),
            });
        }
        for &(element, corner) in faces {
            let is_inner = (element as usize) < self.tets.len()
                && corner < 4
                && self.neighbour(element, corner as usize).is_some();
            if !is_inner {
                return Err(Rejected::Face { element, corner });
            }
        }
        let mut faces = faces.to_vec();
        for &shred in shreds.keys() {
            if shred as usize >= self.tets.len() {
                return Err(Rejected::Face {
                    element: shred,
                    corner: 0,
                });
            }
            let inner = (0..4).filter(|&corner| self.neighbour(shred, corner).is_some());
            faces.extend(inner.map(|corner| (shred, corner as u8)));
        }
        if faces.is_empty() {
            return Ok(None);
        }
        self.sheets += 1;
        let sheet = self.sheets;
        let faces = self.turned_alike(mesh, &faces);
        let mut editor = Editor::new(self, mesh, current);
        editor.shreds.clone_from(shreds);
        editor.open(&faces, sheet);
        Ok(editor.conclude(settings))
    }

    /// Which side is negative is for a tear to choose, as nothing has come from either: so that the normals at rest of all its faces point to one
    /// side, and by their sum along the axis nearest to it, whichever of its two elements a face is given by.
    pub(crate) fn turned_alike(&self, mesh: &TetMesh, faces: &[(u32, u8)]) -> Vec<FaceToOpen> {
        let mut sum = Vector3::zeros();
        let mut turned = Vec::with_capacity(faces.len());
        for &(element, corner) in faces {
            let corner = corner as usize;
            let places = self.face(element, corner);
            let [a, b, c] = places.map(|node| mesh.positions[node as usize]);
            let outward = (b - a).cross(&(c - a));
            let along = outward.dot(&sum) >= 0.0;
            sum += if along { outward } else { -outward };
            turned.push((element, corner, along));
        }
        if sum[sum.iamax()] < 0.0 {
            turned.iter_mut().for_each(|face| face.2 = !face.2);
        }
        turned
    }
}

#[cfg(test)]
mod tests;
