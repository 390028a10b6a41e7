//! Candidates of contact between two surfaces, cached as long as their boxes hold.

use crate::body::Body;
use microsim_geometry::{Aabb, BroadPhase};

/// Pairs of features of one body with those of another, or of the same one, whose boxes over the step overlap; all ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct Near {
    versions: [u64; 2],
    reach: f64,
    /// Surface nodes of the first body and triangles of the second.
    pub node_triangles: Vec<[u32; 2]>,
    /// Edges of the first body and triangles of the second.
    pub edge_triangles: Vec<[u32; 2]>,
    /// Edges of both, each triangle of the second body standing for its own; within one body the smaller first.
    pub edges: Vec<[u32; 2]>,
    /// Nodes of the first body and tetrahedra of the second.
    pub node_tets: Vec<[u32; 2]>,
    /// The boxes of the edges of the second body.
    boxes: Vec<Aabb>,
    /// The last edge of the first body, counted from 1, in whose list an edge of the second one is.
    listed: Vec<u32>,
}

/// Whether anything of two bodies can be closer than `reach` \[m\] during the step.
pub(crate) fn may_meet(first: &Body, second: &Body, reach: f64) -> bool {
    let bounds = second.tree.bounds.inflated(reach);
    first.tree.bounds.overlaps(&bounds)
}

impl Near {
    /// Makes sure that the lists hold all pairs closer than `reach` \[m\] during the step, of edges closer than `edge_reach` \[m\],
    /// which grows with `reach` alone.
    pub fn update(&mut self, first: &Body, second: &Body, reach: f64, edge_reach: f64) {
        let versions = [first.tree.version, second.tree.version];
        if self.versions == versions && self.reach >= reach {
            return;
        }
        self.versions = versions;
        self.reach = reach;
        self.node_triangles.clear();
        self.edge_triangles.clear();
        self.edges.clear();
        self.node_tets.clear();
        if !may_meet(first, second, reach) {
            return;
        }
        let itself = first.index == second.index;
        let surface = &first.surface;
        for &node in &surface.nodes {
            let around = first.tree.swept(surface, &[node]).inflated(reach);
            let start = self.node_triangles.len();
            second.tree.triangles.visit(&around, |triangle| {
                let nodes = &second.surface.triangles[triangle as usize];
                if !(itself && surface.is_close(&[node], nodes)) {
                    self.node_triangles.push([node, triangle]);
                }
            });
            self.node_triangles[start..].sort_unstable();
        }
        self.boxes.clear();
        let others = second.surface.edges.iter();
        self.boxes
            .extend(others.map(|edge| second.tree.swept(&second.surface, &edge.nodes)));
        self.listed.clear();
        self.listed.resize(second.surface.edges.len(), 0);
        for (index, edge) in surface.edges.iter().enumerate() {
            let swept = first.tree.swept(surface, &edge.nodes);
            let around = swept.inflated(reach);
            let start = self.edge_triangles.len();
            second.tree.triangles.visit(&around, |triangle| {
                let nodes = &second.surface.triangles[triangle as usize];
                if !(itself && surface.is_close(&edge.nodes, nodes)) {
                    self.edge_triangles.push([index as u32, triangle]);
                }
            });
            if start == self.edge_triangles.len() {
                continue;
            }
            self.edge_triangles[start..].sort_unstable();
            let around = swept.inflated(edge_reach);
            let start_edges = self.edges.len();
            for &[edge, triangle] in &self.edge_triangles[start..] {
                for other in second.surface.triangle_edges[triangle as usize] {
                    let listed = &mut self.listed[other as usize];
                    if *listed == edge + 1 {
                        continue;
                    }
                    *listed = edge + 1;
                    let nodes = &second.surface.edges[other as usize].nodes;
                    let wanted = self.boxes[other as usize].overlaps(&around)
                        && (!itself
                            || edge < other
                                && !surface.is_close(&surface.edges[edge as usize].nodes, nodes));
                    if wanted {
                        self.edges.push([edge, other]);
                    }
                }
            }
            self.edges[start_edges..].sort_unstable();
        }
        if let Some(tets) = &second.tree.tets {
            for node in surface.offset..surface.offset + surface.node_count {
                let around = first.tree.place(surface, node);
                if !around.overlaps(&second.tree.bounds) {
                    continue;
                }
                let start = self.node_tets.len();
                tets.visit(&around, |tet| {
                    let nodes = &second.surface.tets[tet as usize];
                    if !(itself && surface.is_close(&[node], nodes)) {
                        self.node_tets.push([node, tet]);
                    }
                });
                self.node_tets[start..].sort_unstable();
            }
        }
    }
}
