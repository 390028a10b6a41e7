//! A surface of triangles with positions of its own.

use nalgebra::Vector3;

/// Triangles in space: what surface files hold and what is filled with tetrahedra.
///
/// Unlike [`Surface`](crate::Surface) it belongs to no mesh. Whether it is closed, free of self-intersections and turned
/// outward is not promised here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSurface {
    /// Vertices [m].
    pub positions: Vec<Vector3<f64>>,
    /// Three vertex indices per triangle, outward by the right-hand rule if the surface is closed and well turned.
    pub triangles: Vec<[u32; 3]>,
}
