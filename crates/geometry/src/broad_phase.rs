//! What all broad phases answer: which boxes overlap a box.
//!
//! [`crate::SpatialHash`], [`crate::Bvh`] and [`crate::AllPairs`] give the same answers in the same order, so that each can stand where
//! another did; the example `broad_phase` measures which is faster where. Boxes are all that a broad phase knows: of a point,
//! an edge, a triangle, a tetrahedron ([`Aabb::of`]), of any of them in motion ([`Aabb::of`] the points before and after),
//! of a capsule in motion ([`crate::Capsule::swept_bounds`]).

use crate::aabb::Aabb;

/// A set of boxes that finds those that overlap another box. Boxes that touch overlap; a box that is empty or not a number
/// overlaps none.
///
/// All answers are in ascending order, whatever was asked or stored before. None of the methods allocates once the lists that
/// it fills have grown to their size.
pub trait BroadPhase {
    /// Number of boxes in the set.
    fn len(&self) -> usize;

    /// Whether there is no box in the set.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The stored box of that index.
    fn bounds(&self, index: u32) -> &Aabb;

    /// Calls `found` once for each box of the set that overlaps `bounds`, in any order.
    fn visit(&self, bounds: &Aabb, found: impl FnMut(u32));

    /// Replaces `found` by the indices of the boxes that overlap `bounds`, ascending.
    fn query(&self, bounds: &Aabb, found: &mut Vec<u32>) {
        found.clear();
        self.visit(bounds, |index| found.push(index));
        found.sort_unstable();
    }

    /// Replaces `pairs` by all `[query, box of the set]` that overlap, ascending.
    fn pairs(&self, queries: &[Aabb], pairs: &mut Vec<[u32; 2]>) {
        pairs.clear();
        for (query, bounds) in queries.iter().enumerate() {
            let start = pairs.len();
            self.visit(bounds, |index| pairs.push([query as u32, index]));
            pairs[start..].sort_unstable();
        }
    }

    /// Replaces `pairs` by all pairs of boxes of the set that overlap, the smaller index first, ascending.
    fn self_pairs(&self, pairs: &mut Vec<[u32; 2]>) {
        pairs.clear();
        for first in 0..self.len() as u32 {
            let start = pairs.len();
            self.visit(self.bounds(first), |second| {
                if first < second {
                    pairs.push([first, second]);
                }
            });
            pairs[start..].sort_unstable();
        }
    }
}

#[cfg(test)]
mod tests;
