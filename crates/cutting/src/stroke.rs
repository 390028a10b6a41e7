//! What a blade has passed so far on its path.
//!
//! A crossed edge gets a node on the blade's path. What the mesh needs to open is a face with all three nodes on it and
//! elements on both sides; while a blade is in progress such faces come one after another. A stroke remembers the nodes on the
//! path and the side of the nodes beside it, until the blade has left the tissue or has gone on far enough.
//!
//! A hand trembles. Within a reversal the sheet that the blade sweeps turns round, so which side is positive follows from the
//! steady direction: the sum of the last displacements across the blade.

use crate::crossing::Crossing;
use crate::path::PathPoints;
use microsim_mesh::TopologyEdit;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Displacement across the blade that its steady direction is the sum of, over the mean edge: the amplitude of a tremor (49 to 133 µm rms:
/// Riviere, Rader and Khosla 1997), reversals of 1 mm included, stays below it on meshes of levels.
const STEADY: f64 = 2.0;

/// How far a blade advances, over the mean edge, until it meets nodes as if it had never passed them: farther than any element beside
/// its path reaches, nearer than where a path that turns round comes again.
const MEMORY: f64 = 4.0;

/// A crossed edge that waits, smaller node first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waiting {
    /// Where it is crossed, its positive side that of the stroke.
    pub crossing: Crossing,
    /// Whether the step itself had the second node on its positive side: a step back has not.
    pub forward: bool,
}

/// A node that a stroke has passed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassedNode {
    /// Side of the path: 1 positive, −1 negative, 0 on the path.
    pub side: i8,
    /// How far the stroke had advanced when it came here \[m\].
    pub advance: f64,
}

/// One pass of a blade through one body. Plain data: it is saved with the mesh between two generations. It ends by itself when the
/// blade is clear of all elements; a caller may begin a new one at any time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stroke {
    /// Number of its sheet in the body, from 1; 0 before the first crossing.
    pub sheet: u32,
    /// Nodes on the path and beside it.
    pub nodes: BTreeMap<u32, PassedNode>,
    /// Normal of the path towards the positive side: blade direction × displacement, summed over the last steps \[m\].
    pub across: Vector3<f64>,
    /// Displacement along the steady direction so far \[m\].
    pub advance: f64,
    /// Length of the path since bridges were looked for \[m\].
    pub unseen: f64,
    /// Where the blade crossed edges since something was last opened.
    pub points: PathPoints,
    /// Crossed edges, smaller node first, at elements in which the blade still is; only of a semi-progressive cut.
    pub waiting: BTreeMap<[u32; 2], Waiting>,
}

impl Stroke {
    /// A blade that has not yet cut.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether a node is on the path.
    pub(crate) fn is_on_path(&self, node: u32) -> bool {
        matches!(self.nodes.get(&node), Some(passed) if passed.side == 0)
    }

    /// The side of a node; 0 on the path, or where it is not known.
    pub(crate) fn side(&self, node: u32) -> i8 {
        self.nodes.get(&node).map_or(0, |passed| passed.side)
    }

    /// Puts a node on the path; whether it was not there.
    pub(crate) fn put_on_path(&mut self, node: u32) -> bool {
        let advance = self.advance;
        let old = self.nodes.insert(node, PassedNode { side: 0, advance });
        !matches!(old, Some(passed) if passed.side == 0)
    }

    /// Learns the side of a node. What was found first counts: later the blade may come from elsewhere. Whether it was not known.
    pub(crate) fn learn(&mut self, node: u32, side: i8) -> bool {
        let advance = self.advance;
        let mut is_new = false;
        self.nodes.entry(node).or_insert_with(|| {
            is_new = true;
            PassedNode { side, advance }
        });
        is_new
    }

    /// A node has been doubled.
    pub(crate) fn copied(&mut self, node: u32, copy: u32) {
        if let Some(passed) = self.nodes.get(&node).copied() {
            self.nodes.insert(copy, passed);
        }
        self.hold_copies(node, copy);
    }

    /// The blade has moved: `normal` is blade direction × displacement \[m\].
    pub(crate) fn advance_by(&mut self, normal: &Vector3<f64>, mean_edge: f64) {
        let direction = self.across.try_normalize(0.0);
        self.unseen += normal.norm();
        self.advance += direction.map_or(normal.norm(), |direction| direction.dot(normal));
        self.across += normal;
        if direction.is_some_and(|direction| direction.dot(&self.across) < 0.0) {
            self.turn_round();
        }
        let (length, most) = (self.across.norm(), STEADY * mean_edge);
        if length > most {
            self.across *= most / length;
        }
        let advance = self.advance;
        self.nodes
            .retain(|_, passed| (advance - passed.advance).abs() <= MEMORY * mean_edge);
    }

    /// The steady direction turns out to be the opposite of what it was: the blade began with a step back.
    fn turn_round(&mut self) {
        self.advance = -self.advance;
        for passed in self.nodes.values_mut() {
            passed.side = -passed.side;
            passed.advance = -passed.advance;
        }
        for Waiting { crossing, .. } in self.waiting.values_mut() {
            crossing.positive = !crossing.positive;
            crossing.normal = -crossing.normal;
        }
    }

    /// The blade has left the tissue. Its steady direction remains, as it may come back at once.
    pub(crate) fn end(&mut self) {
        *self = Self {
            across: self.across,
            ..Self::default()
        };
    }

    /// Updates the stroke after an edit of another one, of a mesh that had so many nodes: copies of nodes are where these are. Its own
    /// edits are part of it already.
    pub fn update_after_edit(&mut self, edit: &TopologyEdit, nodes: usize) {
        for (k, new) in edit.nodes.iter().enumerate() {
            if new.fraction == 0.0 {
                self.copied(new.between[0], (nodes + k) as u32);
            }
        }
        self.leave(edit, nodes);
    }

    /// Removes what an edit removes.
    pub(crate) fn leave(&mut self, edit: &TopologyEdit, nodes: usize) {
        for gone in &edit.removed_nodes {
            self.nodes.remove(gone);
        }
        for (from, to) in edit.node_moves(nodes) {
            if let Some(passed) = self.nodes.remove(&from) {
                self.nodes.insert(to, passed);
            }
        }
        self.leave_waiting(edit, nodes);
    }
}
