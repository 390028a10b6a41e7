//! What may be wrong with a triangle surface.

use crate::Severity;

/// Something wrong with a triangle surface. Vertices and triangles are named by their index, counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceDefect {
    /// No triangle.
    Empty,
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// The vertex.
        vertex: u32,
    },
    /// A triangle names a vertex that is not there.
    VertexOutOfRange {
        /// The triangle.
        triangle: u32,
        /// The vertex it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A triangle names a vertex twice.
    RepeatedVertex {
        /// The triangle.
        triangle: u32,
        /// The vertex.
        vertex: u32,
    },
    /// A triangle has no area.
    Degenerate {
        /// The triangle.
        triangle: u32,
    },
    /// Two triangles have the same three vertices.
    Duplicated {
        /// The later one.
        triangle: u32,
        /// The earlier one.
        first: u32,
    },
    /// An edge with one triangle: a hole.
    Open {
        /// The vertices of the edge.
        edge: [u32; 2],
        /// The triangle.
        triangle: u32,
    },
    /// More than two triangles at an edge.
    EdgeNotManifold {
        /// The vertices of the edge.
        edge: [u32; 2],
        /// The first of the triangles.
        triangle: u32,
        /// Number of triangles.
        count: usize,
    },
    /// Two neighbours of which one faces inward.
    Orientation {
        /// The vertices of their edge.
        edge: [u32; 2],
        /// The triangles.
        triangles: [u32; 2],
    },
    /// The surface touches itself in a vertex only.
    VertexNotManifold {
        /// The vertex.
        vertex: u32,
        /// Number of sheets that meet there.
        sheets: usize,
    },
    /// A vertex that no triangle names.
    UnusedVertex {
        /// The vertex.
        vertex: u32,
    },
    /// Two vertices in one place: see [`COINCIDING`](crate::COINCIDING).
    CoincidingVertices {
        /// The vertices.
        vertices: [u32; 2],
        /// Their distance \[m\].
        distance: f64,
    },
    /// The surface falls into parts without a common vertex.
    Components {
        /// Number of parts.
        count: usize,
    },
}

impl SurfaceDefect {
    /// How bad it is: a warning leaves a surface that can be filled.
    pub fn severity(&self) -> Severity {
        match self {
            Self::UnusedVertex { .. }
            | Self::CoincidingVertices { .. }
            | Self::Components { .. } => Severity::Warning,
            _ => Severity::Error,
        }
    }
}

impl std::fmt::Display for SurfaceDefect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Empty => write!(f, "the surface has no triangle"),
            Self::NotFinite { vertex } => write!(
                f,
                "vertex {vertex} has a coordinate that is not a finite number: correct its position"
            ),
            Self::VertexOutOfRange {
                triangle,
                vertex,
                vertices,
            } => write!(
                f,
                "triangle {triangle} names vertex {vertex}, but there are only vertices 0 to {}: correct it (do they count from 1?)",
                *vertices as i64 - 1
            ),
            Self::RepeatedVertex { triangle, vertex } => write!(
                f,
                "triangle {triangle} names vertex {vertex} more than once: remove the triangle"
            ),
            Self::Degenerate { triangle } => write!(
                f,
                "triangle {triangle} has no area: collapse its shortest edge or flip its longest"
            ),
            Self::Duplicated { triangle, first } => write!(
                f,
                "triangle {triangle} has the same vertices as triangle {first}: remove one of them"
            ),
            Self::Open {
                edge: [a, b],
                triangle,
            } => write!(
                f,
                "the edge of vertices {a} and {b} belongs to triangle {triangle} only, 2 triangles expected: close the hole there, or merge vertices that lie in one place"
            ),
            Self::EdgeNotManifold {
                edge: [a, b],
                triangle,
                count,
            } => write!(
                f,
                "{count} triangles meet at the edge of vertices {a} and {b}, the first is {triangle}; 2 expected: separate the parts that touch there"
            ),
            Self::Orientation {
                edge: [a, b],
                triangles: [s, t],
            } => write!(
                f,
                "triangles {s} and {t} run along their edge of vertices {a} and {b} in the same direction, opposite directions expected: flip the one that faces inward"
            ),
            Self::VertexNotManifold { vertex, sheets } => write!(
                f,
                "{sheets} sheets of the surface meet at vertex {vertex}, 1 expected: give each its own vertex"
            ),
            Self::UnusedVertex { vertex } => {
                write!(f, "vertex {vertex} belongs to no triangle: remove it")
            }
            Self::CoincidingVertices {
                vertices: [a, b],
                distance,
            } => write!(
                f,
                "vertices {a} and {b} lie in one place ({distance:.1e} m apart): merge them unless the parts are meant to be apart"
            ),
            Self::Components { count } => write!(
                f,
                "the surface falls into {count} parts that share no vertex: remove what does not belong to the body (a cavity does)"
            ),
        }
    }
}
