//! The surface of a body after edits of its mesh: changes are collected, and applied once for all edits of a tick.
//!
//! The update costs what the edits touch, but for copies of lists whose order is that of elements: an updated surface is the same as a
//! rebuilt one, bit for bit.

use super::Body;
use crate::surface_edits::{SurfaceDiff, exchange, index_of, node_area, node_areas, triangles_at};
use microsim_cutting::SurfaceTriangle;
use microsim_mesh::Surface;

impl Body {
    /// Takes the surface from the topology, and what goes with it.
    pub(crate) fn rebuild_surface(&mut self) {
        self.surface_edits = None;
        let Some(topology) = &self.topology else {
            return;
        };
        self.triangles = topology.surface();
        self.surface = Surface::new(self.triangles.iter().map(|t| t.nodes).collect());
        self.opened = self.triangles.iter().map(|t| t.sheet != 0).collect();
        self.node_areas = node_areas(&self.surface, &self.mesh);
        self.update_ends_and_loads();
    }

    /// Applies the collected changes; returns what they were, if there are any.
    pub(crate) fn update_surface(&mut self) -> Option<SurfaceDiff> {
        let (gone, new, touched) = self.surface_edits.take()?.into_sorted();
        let topology = self.topology.as_ref()?;
        let removed: Vec<u32> = gone.iter().map(|t| index_of(&self.triangles, t)).collect();
        let added = new.iter().map(|t| (index_of(&self.triangles, t), *t));
        let added: Vec<(u32, SurfaceTriangle)> = added.collect();
        exchange(&mut self.triangles, &removed, &added);
        let nodes: Vec<_> = added.iter().map(|(at, t)| (*at, t.nodes)).collect();
        exchange(&mut self.surface.triangles, &removed, &nodes);
        let opened: Vec<_> = added.iter().map(|(at, t)| (*at, t.sheet != 0)).collect();
        exchange(&mut self.opened, &removed, &opened);

        let mut nodes: Vec<u32> = gone.iter().chain(&new).flat_map(|t| t.nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let count = self.mesh.positions.len();
        self.node_areas.resize(count, 0.0);
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for &node in &nodes {
            let exists = (node as usize) < count;
            let is_outside = exists && triangles_at(topology, node).next().is_some();
            if exists {
                self.node_areas[node as usize] = node_area(topology, &self.mesh, node);
            }
            match (self.surface.nodes.binary_search(&node), is_outside) {
                (Ok(at), false) => inside.push(at as u32),
                (Err(at), true) => outside.push((at as u32, node)),
                _ => {}
            }
        }
        exchange(&mut self.surface.nodes, &inside, &outside);
        self.update_ends_and_loads();
        let added = new.iter().map(|t| index_of(&self.triangles, t));
        Some(SurfaceDiff {
            added: added.collect(),
            removed,
            touched,
        })
    }

    /// The parts of the surface that have a use: ends and lumens of vessels, and where there are loads.
    fn update_ends_and_loads(&mut self) {
        if self.ends.is_empty() && self.lumen.is_none() && !self.drive.has_loads() {
            return;
        }
        let outside = self.triangles.iter().filter(|t| t.sheet == 0);
        let outside: Vec<[u32; 3]> = outside.map(|t| t.nodes).collect();
        for (end, nodes) in self.ends.iter_mut().zip(&self.end_nodes) {
            let is_of_end = |node: &u32| nodes.binary_search(node).is_ok();
            let whole = outside.iter().filter(|t| t.iter().all(is_of_end));
            *end = whole.copied().collect();
        }
        self.drive.update_loads(&self.mesh, &outside);
        if let Some(lumen) = &mut self.lumen {
            let opened = self.triangles.iter().filter(|t| t.sheet != 0);
            let mut opened: Vec<u32> = opened.flat_map(|t| t.nodes).collect();
            opened.sort_unstable();
            opened.dedup();
            lumen.update(&self.mesh, &outside, &opened);
        }
    }
}
