//! The features of a surface that are near something, each once.

use crate::broad_phase::Boxes;
use crate::surface::ContactSurface;
use microsim_geometry::{Aabb, BroadPhase};

/// The features near a box, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct Features {
    pub triangles: Vec<u32>,
    pub edges: Vec<u32>,
    pub nodes: Vec<u32>,
}

impl Features {
    /// Finds the triangles whose boxes overlap `bounds`, with their edges and nodes.
    pub fn find(&mut self, surface: &ContactSurface, triangles: &Boxes, bounds: &Aabb) {
        triangles.query(bounds, &mut self.triangles);
        self.edges.clear();
        self.nodes.clear();
        for &triangle in &self.triangles {
            self.edges.extend(surface.triangle_edges[triangle as usize]);
            self.nodes.extend(surface.triangles[triangle as usize]);
        }
        self.edges.sort_unstable();
        self.edges.dedup();
        self.nodes.sort_unstable();
        self.nodes.dedup();
    }
}
