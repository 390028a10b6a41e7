//! The boundary of a mesh.

/// Outward triangles of a boundary and the nodes on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Three node indices per triangle, outward by the right-hand rule.
    pub triangles: Vec<[u32; 3]>,
    /// The nodes of the triangles, each once, ascending.
    pub nodes: Vec<u32>,
}

impl Surface {
    /// The surface made of `triangles`.
    pub fn new(triangles: Vec<[u32; 3]>) -> Self {
        let mut nodes: Vec<u32> = triangles.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        Self { triangles, nodes }
    }
}
