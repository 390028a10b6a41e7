//! The update of a contact surface after an edit of its mesh.
//!
//! The search for edges and neighbours is proportional to what a cut touches. One pass over all triangles and edges of the surface renumbers the others
//! and makes the triangles at each node; where it must be known what lies inside, all elements are copied.

use crate::lists::Lists;
use crate::surface::{ContactSurface, NONE, SurfaceEdge};
use microsim_mesh::{Surface, TetMesh};

/// What became of a body and of its surface.
#[derive(Clone, Copy)]
pub struct SurfaceUpdate<'a> {
    /// The mesh now.
    pub mesh: &'a TetMesh,
    /// Its surface now.
    pub surface: &'a Surface,
    /// The number of its first node in the group now.
    pub offset: u32,
    /// Old indices of triangles that are gone, ascending.
    pub removed: &'a [u32],
    /// New indices of new triangles, ascending. All others have their nodes, and their order.
    pub added: &'a [u32],
    /// Nodes at which there are other elements now, or the same with other nodes. May have more, and numbers beyond all.
    pub touched: &'a [u32],
    /// The elements at a node now; called for `touched` only.
    pub elements_at: &'a dyn Fn(u32) -> &'a [u32],
}

impl ContactSurface {
    /// Updates the surface: the result equals a rebuilt one. Returns the new index of each triangle, [`u32::MAX`] for those that are gone.
    pub(crate) fn update_after_edit(&mut self, change: &SurfaceUpdate<'_>) -> Vec<u32> {
        let SurfaceUpdate {
            mesh,
            surface,
            offset,
            ..
        } = *change;
        let shift = |node: u32| node + offset;
        let to = places(self.triangles.len(), change);
        let from = self.offset;
        let key = |nodes: [u32; 2]| nodes.map(|node| node - from + offset);
        // The edges of triangles that have come or gone.
        let mut changed: Vec<[u32; 2]> =
            Vec::with_capacity(3 * (change.removed.len() + change.added.len()));
        for &triangle in change.removed {
            let edges = self.triangle_edges[triangle as usize];
            changed.extend(edges.map(|edge| key(self.edges[edge as usize].nodes)));
        }
        self.offset = offset;
        self.node_count = mesh.positions.len() as u32;
        self.nodes.clear();
        self.nodes.extend(surface.nodes.iter().copied().map(shift));
        self.triangles.clear();
        self.triangles
            .extend(surface.triangles.iter().map(|triangle| triangle.map(shift)));
        self.node_triangles = Lists::at_corners(mesh.positions.len(), &surface.triangles);
        for &triangle in change.added {
            let nodes = self.triangles[triangle as usize];
            changed.extend((0..3).map(|side| side_nodes(&nodes, side)));
        }
        changed.sort_unstable();
        changed.dedup();
        self.update_edges(&to, key, &changed);
        self.update_inside(change);
        to
    }

    /// Edges, once triangles are those of now: those of `changed` are searched for, in the others the numbers alone change.
    fn update_edges(
        &mut self,
        to: &[u32],
        key: impl Fn([u32; 2]) -> [u32; 2],
        changed: &[[u32; 2]],
    ) {
        let old = std::mem::take(&mut self.edges);
        let mut edges: Vec<SurfaceEdge> = Vec::with_capacity(old.len() + changed.len());
        let mut renumbered = vec![NONE; old.len()];
        let mut anew = changed.iter().peekable();
        for (edge, renumbered) in old.iter().zip(&mut renumbered) {
            let nodes = key(edge.nodes);
            while let Some(&nodes) = anew.next_if(|changed| **changed < nodes) {
                edges.extend(self.edge(nodes));
            }
            if anew.peek() == Some(&&nodes) {
                continue;
            }
            *renumbered = edges.len() as u32;
            edges.push(SurfaceEdge {
                nodes,
                triangles: edge.triangles.map(|triangle| match triangle {
                    NONE => NONE,
                    triangle => to[triangle as usize],
                }),
            });
        }
        edges.extend(anew.filter_map(|&nodes| self.edge(nodes)));
        self.edges = edges;

        let old = std::mem::take(&mut self.triangle_edges);
        self.triangle_edges.resize(self.triangles.len(), [NONE; 3]);
        for (edges, &place) in old.iter().zip(to) {
            if place != NONE {
                self.triangle_edges[place as usize] = edges.map(|edge| renumbered[edge as usize]);
            }
        }
        for (edges, nodes) in self.triangle_edges.iter_mut().zip(&self.triangles) {
            for (side, edge) in edges.iter_mut().enumerate() {
                if *edge == NONE {
                    let nodes = side_nodes(nodes, side);
                    let found = self.edges.binary_search_by_key(&nodes, |edge| edge.nodes);
                    *edge = found.expect("each side of a triangle is an edge") as u32;
                }
            }
        }
    }

    /// The edge between two nodes, if a triangle has it.
    fn edge(&self, nodes: [u32; 2]) -> Option<SurfaceEdge> {
        if nodes
            .iter()
            .any(|node| !self.range().contains(&(*node as usize)))
        {
            return None;
        }
        let at = self.triangles_at(nodes[0]).iter().copied();
        let mut at = at.filter(|&t| self.triangles[t as usize].contains(&nodes[1]));
        let triangles = [at.next()?, at.next().unwrap_or(NONE)];
        Some(SurfaceEdge { nodes, triangles })
    }

    /// What lies inside, where it is known.
    fn update_inside(&mut self, change: &SurfaceUpdate<'_>) {
        if self.neighbours.is_empty() {
            return;
        }
        let offset = self.offset;
        let tets = &change.mesh.tets;
        self.tets.clear();
        self.tets
            .extend(tets.iter().map(|tet| tet.map(|node| node + offset)));
        let count = change.mesh.positions.len();
        self.neighbours.resize(count, Vec::new());
        for &node in change
            .touched
            .iter()
            .filter(|node| (**node as usize) < count)
        {
            let list = &mut self.neighbours[node as usize];
            list.clear();
            for &element in (change.elements_at)(node) {
                let corners = tets[element as usize].into_iter();
                list.extend(corners.filter(|&other| other != node));
            }
            list.sort_unstable();
            list.dedup();
        }
    }
}

/// The nodes of a triangle's side, ascending.
fn side_nodes(triangle: &[u32; 3], side: usize) -> [u32; 2] {
    let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
    [a.min(b), a.max(b)]
}

/// The new index of each of `count` triangles.
fn places(count: usize, change: &SurfaceUpdate<'_>) -> Vec<u32> {
    let mut removed = change.removed.iter().peekable();
    let mut added = change.added.iter().peekable();
    let mut now = 0;
    let stands = |old: u32| {
        if removed.next_if_eq(&&old).is_some() {
            return NONE;
        }
        while added.next_if_eq(&&now).is_some() {
            now += 1;
        }
        now += 1;
        now - 1
    };
    (0..count as u32).map(stands).collect()
}
