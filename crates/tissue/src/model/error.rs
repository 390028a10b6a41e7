//! What is wrong with a body.

/// Why a model cannot be built from a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelError {
    /// The mesh has no node or no element.
    Empty,
    /// Drag is not finite or below zero.
    Drag {
        /// The drag \[1/s\].
        drag: f64,
    },
    /// One clamp flag per node is needed.
    ClampCount {
        /// Number of flags.
        flags: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// One density per element is needed.
    DensityCount {
        /// Number of densities.
        densities: usize,
        /// Number of elements.
        elements: usize,
    },
    /// An element has no positive volume at rest.
    Volume {
        /// Its index.
        element: usize,
        /// Its volume \[m³\].
        volume: f64,
    },
    /// A node belongs to no element and so has no mass.
    LooseNode {
        /// Its index.
        node: usize,
    },
}

impl std::fmt::Display for ModelError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Empty => f.write_str("the mesh has no element"),
            Self::Drag { drag } => write!(f, "drag is {drag} 1/s; allowed: >= 0 1/s, finite"),
            Self::ClampCount { flags, nodes } => write!(f, "{flags} clamp flags for {nodes} nodes"),
            Self::DensityCount {
                densities,
                elements,
            } => write!(f, "{densities} densities for {elements} elements"),
            Self::Volume { element, volume } => {
                write!(
                    f,
                    "element {element} has the rest volume {volume} m³; it must be positive"
                )
            }
            Self::LooseNode { node } => write!(f, "node {node} belongs to no element"),
        }
    }
}

impl std::error::Error for ModelError {}
