//! Pairs that may come into contact.

/// Two that may come into contact. Bodies and parts of obstacles are named by their indices in the lists given to
/// [`Detector::new`](crate::Detector::new), tools by theirs in [`Frame::tools`](crate::Frame::tools).
#[derive(Clone, Debug, PartialEq)]
pub enum ContactPair {
    /// A tool and a body.
    Tool {
        /// The body.
        body: u32,
        /// The tool.
        tool: u32,
    },
    /// A part of an obstacle and a body.
    Obstacle {
        /// The body.
        body: u32,
        /// The part.
        part: u32,
    },
    /// Two bodies.
    Bodies {
        /// One body.
        body: u32,
        /// The other.
        with: u32,
        /// The ends of two vessels that lie opposite to one another, of `body` and of `with`: there nodes are brought before the
        /// other end's plane (dissertation 4.3).
        ends: Option<[VesselEnd; 2]>,
    },
    /// A body and itself.
    Itself {
        /// The body.
        body: u32,
    },
}

/// How two bodies, or a body and itself, are found to touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Detection {
    /// By what nodes and edges pass through during the step, and by what comes near.
    #[default]
    Continuous,
    /// By nodes that are in tetrahedra at its end (dissertation 4.3): what is thinner than the path of a step is passed through.
    Discrete(Depth),
}

/// How deep a node inside is, and in which direction its exit is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// To the nearest point of the surface. Neighbours may exit on different sides.
    Nearest,
    /// Consistent penetration depth (Heidelberger et al. 2004): by where the edges of its neighbourhood came in.
    Consistent,
}

/// The end of a vessel.
#[derive(Clone, Debug, PartialEq)]
pub struct VesselEnd {
    /// The triangles of its face, outward, in the group's numbering of nodes.
    pub triangles: Vec<[u32; 3]>,
}
