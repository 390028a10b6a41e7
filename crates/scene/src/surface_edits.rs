//! Changes of the surface of a body that is cut, collected over the edits of a tick, and lists in the order of a surface.

use microsim_cutting::{SurfaceChange, SurfaceTriangle, Topology};
use microsim_mesh::{Surface, TetMesh};
use std::collections::BTreeSet;

/// Changes of a surface that have not been applied yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfaceEdits {
    removed: BTreeSet<SurfaceTriangle>,
    added: BTreeSet<SurfaceTriangle>,
    /// Nodes at which elements have changed.
    touched: Vec<u32>,
}

/// An update of a surface.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceDiff {
    /// Old indices of triangles that are gone, ascending.
    pub removed: Vec<u32>,
    /// New indices of new ones, ascending.
    pub added: Vec<u32>,
    /// Nodes at which elements have changed, and others beyond all.
    pub touched: Vec<u32>,
}

impl SurfaceEdits {
    /// Adds those of a later edit.
    pub fn add(&mut self, change: &SurfaceChange, touched: &[u32]) {
        for triangle in &change.removed {
            if !self.added.remove(triangle) {
                self.removed.insert(*triangle);
            }
        }
        for triangle in &change.added {
            if !self.removed.remove(triangle) {
                self.added.insert(*triangle);
            }
        }
        self.touched.extend_from_slice(touched);
    }

    /// The triangles that are gone and those that are new, each in the order of surfaces, and the nodes at which elements have changed.
    pub fn into_sorted(self) -> (Vec<SurfaceTriangle>, Vec<SurfaceTriangle>, Vec<u32>) {
        let sorted = |triangles: BTreeSet<SurfaceTriangle>| {
            let mut all: Vec<SurfaceTriangle> = triangles.into_iter().collect();
            all.sort_unstable_by_key(place);
            all
        };
        (sorted(self.removed), sorted(self.added), self.touched)
    }
}

/// Sort key of the triangles of a surface.
fn place(triangle: &SurfaceTriangle) -> (u32, u8) {
    (triangle.element, triangle.corner)
}

/// Index of a triangle among those of a surface, or where it would be inserted.
pub(crate) fn index_of(triangles: &[SurfaceTriangle], triangle: &SurfaceTriangle) -> u32 {
    triangles.partition_point(|other| place(other) < place(triangle)) as u32
}

/// Removes the items at `removed` (ascending), and inserts each of `added` before the old item at its index (not descending).
pub(crate) fn exchange<T: Copy>(list: &mut Vec<T>, removed: &[u32], added: &[(u32, T)]) {
    let mut all = Vec::with_capacity(list.len() + added.len());
    let mut added = added.iter().peekable();
    let mut from = 0;
    let ends = removed.iter().map(|&gone| (gone as usize, 1));
    for (end, gone) in ends.chain([(list.len(), 0)]) {
        while let Some((before, item)) = added.next_if(|(before, _)| *before as usize <= end) {
            all.extend_from_slice(&list[from..*before as usize]);
            from = *before as usize;
            all.push(*item);
        }
        all.extend_from_slice(&list[from..end]);
        from = end + gone;
    }
    *list = all;
}

/// The triangles of the surface at a node, in their order.
pub(crate) fn triangles_at(
    topology: &Topology,
    node: u32,
) -> impl Iterator<Item = SurfaceTriangle> + '_ {
    let elements = topology.elements_at(node).iter();
    let all = elements.flat_map(|&element| topology.triangles_of(element));
    all.filter(move |triangle| triangle.nodes.contains(&node))
}

/// A third of the area at rest of the triangles at a node \[m²\], summed as [`Surface::node_areas`] does.
pub(crate) fn node_area(topology: &Topology, mesh: &TetMesh, node: u32) -> f64 {
    let mut sum = 0.0;
    for triangle in triangles_at(topology, node) {
        let [a, b, c] = triangle.nodes.map(|node| mesh.positions[node as usize]);
        sum += ((b - a).cross(&(c - a)) / 2.0).norm() / 3.0;
    }
    sum
}

/// Area at rest of the surface at each node \[m²\]; 0 inside.
pub(crate) fn node_areas(surface: &Surface, mesh: &TetMesh) -> Vec<f64> {
    let mut all = vec![0.0; mesh.positions.len()];
    let areas = surface.node_areas(&mesh.positions);
    for (&node, area) in surface.nodes.iter().zip(areas) {
        all[node as usize] = area;
    }
    all
}
