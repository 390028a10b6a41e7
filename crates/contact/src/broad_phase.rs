//! How the features whose boxes overlap are found: the broad phase of a body.

use microsim_geometry::{Aabb, AllPairs, BroadPhase, Bvh, SpatialHash};

/// How features whose boxes overlap are found. Each finds the same ones, so that contacts are the same to the bit; they differ in cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum BroadPhaseMethod {
    /// A hierarchy of boxes, refitted as nodes move.
    #[default]
    Hierarchy,
    /// Spatial hashing (Teschner, Heidelberger, Müller, Pomeranets, Gross 2003).
    SpatialHash {
        /// Edge of a cell \[m\], above 0; if `None` the mean edge of the mesh for tetrahedra, as in the paper, and twice that for triangles.
        cell_size: Option<f64>,
    },
    /// Every box is compared with every other.
    AllPairs,
}

/// Cells of triangles over mean edges, where no size is given: the fastest in the example `broad_phase` of `microsim-geometry`.
pub(crate) const CELL_OF_TRIANGLES: f64 = 2.0;

/// The same for tetrahedra.
pub(crate) const CELL_OF_TETS: f64 = 1.0;

/// The boxes of features of a body.
#[derive(Clone, Debug)]
pub(crate) enum Boxes {
    Hierarchy(Bvh),
    Hash(SpatialHash, f64),
    List(AllPairs),
}

impl Boxes {
    /// An empty set; `usual_cell` \[m\] is the edge of a cell where none is given.
    pub fn new(broad_phase: BroadPhaseMethod, usual_cell: f64) -> Self {
        match broad_phase {
            BroadPhaseMethod::Hierarchy => Self::Hierarchy(Bvh::new()),
            BroadPhaseMethod::SpatialHash { cell_size } => {
                Self::Hash(SpatialHash::new(), cell_size.unwrap_or(usual_cell))
            }
            BroadPhaseMethod::AllPairs => Self::List(AllPairs::new()),
        }
    }

    /// Replaces the boxes.
    pub fn set(&mut self, boxes: &[Aabb]) {
        match self {
            Self::Hierarchy(tree) => tree.refit(boxes),
            Self::Hash(hash, cell) => hash.rebuild(*cell, boxes),
            Self::List(list) => list.rebuild(boxes),
        }
    }

    /// Boxes have these indices now, [`u32::MAX`] where they are gone; all are set before anything is asked.
    pub fn renumber(&mut self, to: &[u32]) {
        // The others are built anew whenever boxes are set.
        if let Self::Hierarchy(tree) = self {
            tree.renumber(to);
        }
    }
}

impl BroadPhase for Boxes {
    fn len(&self) -> usize {
        match self {
            Self::Hierarchy(tree) => tree.len(),
            Self::Hash(hash, _) => hash.len(),
            Self::List(list) => list.len(),
        }
    }

    fn bounds(&self, index: u32) -> &Aabb {
        match self {
            Self::Hierarchy(tree) => tree.bounds(index),
            Self::Hash(hash, _) => hash.bounds(index),
            Self::List(list) => list.bounds(index),
        }
    }

    fn visit(&self, bounds: &Aabb, found: impl FnMut(u32)) {
        match self {
            Self::Hierarchy(tree) => tree.visit(bounds, found),
            Self::Hash(hash, _) => hash.visit(bounds, found),
            Self::List(list) => list.visit(bounds, found),
        }
    }
}
