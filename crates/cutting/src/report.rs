//! What a cut was.

use crate::path::PathPoints;
use crate::topology::SurfaceTriangle;
use microsim_mesh::TopologyEdit;
use nalgebra::Vector3;

/// What was laid open, in one space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Opened {
    /// Area of one side \[m²\].
    pub area: f64,
    /// Centroid \[m\]; zero where nothing was opened.
    pub centroid: Vector3<f64>,
    /// Mean unit normal, from the negative to the positive side; zero where nothing was opened.
    pub normal: Vector3<f64>,
}

/// How a surface changed: for the skin of contact and for what is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceChange {
    /// Triangles that are no more, in the old generation's numbers.
    pub removed: Vec<SurfaceTriangle>,
    /// New triangles, in the new generation's numbers; those whose element has another index come back here.
    pub added: Vec<SurfaceTriangle>,
}

/// A step of a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// The edit, which the mesh still has to apply.
    pub edit: TopologyEdit,
    /// Number of elements divided.
    pub divided: usize,
    /// What was laid open: at rest, and now.
    pub opened: [Opened; 2],
    /// Where the blade crossed edges since something was last opened; of a tear, which has no blade, none.
    pub points: PathPoints,
    /// How the surface changed.
    pub surface: SurfaceChange,
    /// Parts that came off the rest: elements of the new generation, ascending. The largest part is not listed. Crumbs that the edit
    /// takes away are not listed.
    pub pieces: Vec<Vec<u32>>,
    /// Rest volume of the crumbs that were taken away \[m³\].
    pub lost_volume: f64,
    /// Crossed edges.
    pub crossed: usize,
    /// Divided edges whose fraction was clamped.
    pub clamped: usize,
    /// Crossed edges that were left as they are, nearer to a node that the path had parted.
    pub followed: usize,
    /// Crossed edges that were left whole as one end was on the path already, or the blade went through it.
    pub joined: usize,
    /// Crossed edges that were left whole with their nearer end on the path, as one of their parts or an element would have become too
    /// small.
    pub snapped: usize,
    /// Crossed edges that were left whole with their nearer end on the path, as all three edges of a face were crossed.
    pub dropped: usize,
    /// Faces that were opened as they alone held together what blades had swept between.
    pub mended: usize,
    /// Nodes that were merged with a neighbour.
    pub merged: usize,
}

/// Why nothing was cut. Mesh, topology and stroke are as they were.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rejected {
    /// The topology is that of another generation.
    Generation {
        /// That of the mesh.
        mesh: u64,
        /// That of the topology.
        topology: u64,
    },
    /// There are not as many positions as nodes.
    Positions {
        /// Number of nodes.
        nodes: usize,
        /// Number of positions.
        positions: usize,
    },
    /// The blade has no length, or its sheet no area.
    NoBlade,
    /// An end of the blade, or a node near it, is not finite.
    NotFinite,
    /// No element would remain.
    NothingLeft,
    /// A face to be opened is not an inner one.
    Face {
        /// The element.
        element: u32,
        /// Its corner opposite to the face.
        corner: u8,
    },
}

impl std::fmt::Display for Rejected {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Generation { mesh, topology } => write!(
                f,
                "not cut: the topology is of generation {topology}, the mesh of {mesh}"
            ),
            Self::Positions { nodes, positions } => {
                write!(f, "not cut: {positions} positions for {nodes} nodes")
            }
            Self::NoBlade => write!(f, "not cut: the blade has no length or the sheet no area"),
            Self::NothingLeft => write!(f, "not cut: no element would remain"),
            Self::NotFinite => write!(f, "not cut: the blade or a node near it is not finite"),
            Self::Face { element, corner } => write!(
                f,
                "not opened: the face of element {element} opposite to its corner {corner} is not inside"
            ),
        }
    }
}

impl std::error::Error for Rejected {}
