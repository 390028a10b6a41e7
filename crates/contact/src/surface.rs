//! What contact needs to know of a body.

use crate::lists::Lists;
use microsim_mesh::{Surface, TetMesh};
use nalgebra::Vector3;

/// No triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// An edge of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SurfaceEdge {
    /// Its nodes, ascending.
    pub nodes: [u32; 2],
    /// The triangles at it, the first two where there are more; [`NONE`] where there are fewer.
    pub triangles: [u32; 2],
}

/// The surface and the elements of a body, with what is next to what. Nodes have the numbers of the group that the body is in.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSurface {
    pub(crate) offset: u32,
    pub(crate) node_count: u32,
    /// The nodes of the surface, ascending.
    pub(crate) nodes: Vec<u32>,
    /// Normals triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The edges of each triangle, the first from its first corner to the second.
    pub(crate) triangle_edges: Vec<[u32; 3]>,
    /// The edges of the surface, ascending.
    pub(crate) edges: Vec<SurfaceEdge>,
    pub(crate) tets: Vec<[u32; 4]>,
    pub(crate) node_triangles: Lists,
    /// The nodes at the other ends of the mesh edges of each node, ascending, by their numbers in the body; none where nothing is known of the
    /// body's inside.
    pub(crate) neighbours: Vec<Vec<u32>>,
    /// Mean length of the edges at rest \[m\].
    pub(crate) mean_edge: f64,
}

impl ContactSurface {
    /// Of a body whose first node is node `offset` of its group.
    pub fn new(mesh: &TetMesh, offset: u32) -> Self {
        Self::of_surface(mesh, &mesh.surface(), mesh.mean_edge_length(), offset, true)
    }

    /// [`new`](Self::new) of a mesh whose surface and characteristic length \[m\] are known. Without `inside` nothing is looked up that lies
    /// inside the body: for one that touches tools and obstacles alone, in a time proportional to its surface.
    pub fn of_surface(
        mesh: &TetMesh,
        surface: &Surface,
        mean_edge: f64,
        offset: u32,
        inside: bool,
    ) -> Self {
        let shift = |node: u32| node + offset;
        let triangles: Vec<[u32; 3]> = surface
            .triangles
            .iter()
            .map(|triangle| triangle.map(shift))
            .collect();

        let mut sides: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * triangles.len());
        for (index, triangle) in triangles.iter().enumerate() {
            for side in 0..3 {
                let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], index as u32, side));
            }
        }
        sides.sort_unstable();
        let mut edges: Vec<SurfaceEdge> = Vec::new();
        let mut triangle_edges = vec![[NONE; 3]; triangles.len()];
        for (nodes, triangle, side) in sides {
            match edges.last_mut().filter(|edge| edge.nodes == nodes) {
                Some(edge) if edge.triangles[1] == NONE => edge.triangles[1] = triangle,
                Some(_) => {}
                None => edges.push(SurfaceEdge {
                    nodes,
                    triangles: [triangle, NONE],
                }),
            }
            triangle_edges[triangle as usize][side] = edges.len() as u32 - 1;
        }

        let count = mesh.positions.len();
        let mut neighbours = Vec::new();
        let mut tets = Vec::new();
        if inside {
            neighbours.resize(count, Vec::new());
            // In their order each list becomes ascending.
            for [a, b] in mesh.edges() {
                neighbours[a as usize].push(b);
                neighbours[b as usize].push(a);
            }
            tets.extend(mesh.tets.iter().map(|tet| tet.map(shift)));
        }
        Self {
            offset,
            node_count: count as u32,
            nodes: surface.nodes.iter().copied().map(shift).collect(),
            edges,
            triangle_edges,
            tets,
            node_triangles: Lists::at_corners(count, &surface.triangles),
            neighbours,
            mean_edge,
            triangles,
        }
    }

    /// The triangles at a node, ascending.
    #[inline]
    pub(crate) fn triangles_at(&self, node: u32) -> &[u32] {
        self.node_triangles.of(node - self.offset)
    }

    /// The corners of a triangle.
    #[inline]
    pub(crate) fn corners(&self, at: &[Vector3<f64>], triangle: u32) -> [Vector3<f64>; 3] {
        self.triangles[triangle as usize].map(|node| at[node as usize])
    }

    /// The nodes at the other ends of the mesh edges of a node, ascending.
    #[inline]
    pub(crate) fn neighbours(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        let list = self.neighbours[(node - self.offset) as usize].iter();
        list.map(|other| other + self.offset)
    }

    /// Whether an edge of the mesh joins two nodes.
    #[inline]
    pub(crate) fn are_neighbours(&self, a: u32, b: u32) -> bool {
        let list = &self.neighbours[(a - self.offset) as usize];
        list.binary_search(&(b - self.offset)).is_ok()
    }

    /// Whether two features of one body have a common node, or an edge of the mesh joins them.
    pub(crate) fn is_close(&self, first: &[u32], second: &[u32]) -> bool {
        let close = |a: u32, b: u32| a == b || self.are_neighbours(a, b);
        first.iter().any(|&a| second.iter().any(|&b| close(a, b)))
    }

    /// The node of a triangle at an edge that is not of the edge; one of the edge's where the triangle has no other.
    pub(crate) fn opposite(&self, edge: &SurfaceEdge, side: usize) -> u32 {
        let nodes = self.triangles[edge.triangles[side] as usize];
        let other = nodes.into_iter().find(|node| !edge.nodes.contains(node));
        other.unwrap_or(edge.nodes[0])
    }

    /// The numbers of its nodes.
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.offset as usize..(self.offset + self.node_count) as usize
    }
}
