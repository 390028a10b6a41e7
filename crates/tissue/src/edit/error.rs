//! Why a model cannot follow an edit.

/// Why a model cannot follow an edit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EditError {
    /// The model is the union of several bodies.
    Union,
    /// A set of elements was not made of a material, and is no coupling.
    Foreign {
        /// The set.
        set: usize,
    },
    /// A region has quadratic tetrahedra: their parts belong together.
    Quadratic {
        /// The region.
        region: u32,
    },
    /// The mesh has another number of nodes or elements than the edit leaves.
    Count {
        /// Of what.
        of: &'static str,
        /// As the edit states.
        expected: usize,
        /// In the mesh.
        found: usize,
    },
    /// A number of a node or an element is out of range, out of order or twice there.
    Number {
        /// Of what.
        of: &'static str,
        /// The number.
        number: u32,
    },
    /// The fraction of a new node is not in 0..=1.
    Fraction {
        /// Place among the new nodes.
        node: usize,
        /// The fraction.
        fraction: f64,
    },
    /// An element of the mesh has no positive volume at rest.
    Volume {
        /// Its number in the mesh.
        element: u32,
        /// Its volume \[m³\].
        volume: f64,
    },
    /// An element of the mesh is of a region that the body does not have.
    Region {
        /// Its number in the mesh.
        element: u32,
        /// The region.
        region: u32,
    },
    /// A node that stays belongs to no element, or one that leaves still does.
    Node {
        /// Its number before nodes leave.
        node: u32,
        /// How many elements it belongs to.
        elements: usize,
    },
}

impl std::fmt::Display for EditError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Union => f.write_str("a union of bodies cannot be edited; edit its members"),
            Self::Foreign { set } => write!(
                f,
                "set {set} was not made of a material: what it is after an edit is not known"
            ),
            Self::Quadratic { region } => write!(
                f,
                "region {region} has quadratic tetrahedra, which are not cut: take another discretisation"
            ),
            Self::Count {
                of,
                expected,
                found,
            } => write!(f, "the mesh has {found} {of}, the edit leaves {expected}"),
            Self::Number { of, number } => {
                write!(
                    f,
                    "{of} {number} is out of range, out of order or twice there"
                )
            }
            Self::Fraction { node, fraction } => {
                write!(
                    f,
                    "new node {node} has the fraction {fraction}; allowed: 0 to 1"
                )
            }
            Self::Volume { element, volume } => write!(
                f,
                "element {element} has the rest volume {volume} m³; it must be positive"
            ),
            Self::Region { element, region } => {
                write!(
                    f,
                    "element {element} is of region {region}, which has no material"
                )
            }
            Self::Node { node, elements } => {
                write!(
                    f,
                    "node {node} belongs to {elements} elements after the edit"
                )
            }
        }
    }
}

impl std::error::Error for EditError {}
