//! A body of a detector: its surface, and what is derived from it.

use crate::frame::Frame;
use crate::normals::Normals;
use crate::surface::ContactSurface;
use crate::surface_update::SurfaceUpdate;
use crate::tree::Tree;
use microsim_geometry::{TriangleFeature, TrianglePoint};
use nalgebra::Vector3;

/// A body.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Its place in the group.
    pub index: u32,
    pub surface: ContactSurface,
    pub tree: Tree,
    pub normals: Normals,
}

impl Body {
    pub fn new(index: u32, surface: ContactSurface) -> Self {
        Self {
            index,
            tree: Tree::new(&surface),
            normals: Normals::default(),
            surface,
        }
    }

    /// Updates what is derived from a mesh after an edit of it.
    pub fn update_after_edit(&mut self, change: &SurfaceUpdate<'_>) {
        let to = self.surface.update_after_edit(change);
        self.tree.update_after_edit(&to);
        self.normals = Normals::default();
    }

    /// Positions are new.
    pub fn update(&mut self, frame: &Frame<'_>) {
        self.tree.update(&self.surface, frame);
        self.normals.clear(&self.surface);
    }

    /// How far a node goes in the step \[m\], at most.
    pub fn travel(&self, frame: &Frame<'_>) -> f64 {
        let nodes = self.surface.range();
        let moves = frame.start[nodes.clone()].iter().zip(&frame.now[nodes]);
        let squared = moves.map(|(start, now)| (now - start).norm_squared());
        squared.fold(0.0, f64::max).sqrt()
    }

    /// The unit normal at a point of a triangle: that of the face, edge or node on which it lies.
    pub fn normal_at(
        &self,
        now: &[Vector3<f64>],
        triangle: u32,
        at: &TrianglePoint,
    ) -> Vector3<f64> {
        let surface = &self.surface;
        match at.feature() {
            TriangleFeature::Face => self.normals.face(surface, now, triangle).normal,
            TriangleFeature::Edge(side) => {
                let edges = surface.triangle_edges[triangle as usize];
                self.normals.of_edge(surface, now, edges[usize::from(side)])
            }
            TriangleFeature::Corner(corner) => {
                let node = surface.triangles[triangle as usize][usize::from(corner)];
                self.normals.of_node(surface, now, node)
            }
        }
    }
}
