//! Broad phase by a hierarchy of boxes.
//!
//! A binary tree over the boxes, split in the middle along the longest axis; it is built once and refitted while the
//! boxes move (van den Bergen 1997), which costs a fraction of building. It has no size of its own: boxes of any sizes may
//! mix, and a query over a wide space costs what it finds.
//!
//! A set of which a few boxes change keeps its tree as well ([`renumber`](Bvh::renumber)): what is gone leaves an empty place, what is new
//! stands in a small tree of its own behind the others. When a third of the places is empty or new, all is rebuilt.
//!
//! Limitations: refitting keeps the tree's shape. When neighbours have gone far apart, answers stay right and become slower:
//! rebuild then.

use crate::aabb::Aabb;
use crate::broad_phase::BroadPhase;

/// Boxes in a leaf, at most.
const LEAF: usize = 4;

/// A set of boxes, found by a tree of boxes around them.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    /// The nodes, each before its children and the first child's before the second's.
    nodes: Vec<Node>,
    /// The boxes of the leaves, in the order of the leaves.
    leaves: Vec<Leaf>,
    /// Where each box stands in `leaves`.
    places: Vec<u32>,
    /// The places of the tree that was built over all; those behind it are of smaller ones.
    first_tree: usize,
}

/// No box, or no place.
const NONE: u32 = u32::MAX;

/// When this fraction of the places is empty or in small trees all is rebuilt.
const LOOSE: f64 = 1.0 / 3.0;

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// The node that follows when this one is passed over.
    skip: u32,
    /// First box and number of boxes of a leaf; 0 of any other node.
    first: u32,
    count: u32,
}

#[derive(Clone, Copy, Debug)]
struct Leaf {
    bounds: Aabb,
    index: u32,
}

impl Bvh {
    /// An empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the set by `boxes` and makes a new tree.
    pub fn rebuild(&mut self, boxes: &[Aabb]) {
        self.nodes.clear();
        self.leaves.clear();
        for (index, bounds) in boxes.iter().enumerate() {
            self.leaves.push(Leaf {
                bounds: usable(bounds),
                index: index as u32,
            });
        }
        if !boxes.is_empty() {
            self.build(0, boxes.len());
        }
        self.first_tree = boxes.len();
        self.places.clear();
        self.places.resize(boxes.len(), NONE);
        self.enter(0);
        self.fit();
    }

    /// Replaces the boxes by others and keeps the tree. Of another number of boxes the last ones are gone or new.
    pub fn refit(&mut self, boxes: &[Aabb]) {
        self.places.resize(boxes.len(), NONE);
        let new = self.places.iter().filter(|&&place| place == NONE).count();
        let held = self.leaves.len().min(self.first_tree);
        let mut empty = 0;
        for leaf in &mut self.leaves {
            // Empty places, too, hold numbers beyond all.
            leaf.bounds = match boxes.get(leaf.index as usize) {
                Some(bounds) => usable(bounds),
                None => {
                    leaf.index = NONE;
                    empty += 1;
                    Aabb::empty()
                }
            };
        }
        let loose = empty + new + self.leaves.len() - held;
        if loose as f64 > LOOSE * self.leaves.len() as f64 {
            return self.rebuild(boxes);
        }
        if new > 0 {
            let first = self.leaves.len();
            let missing = (0u32..)
                .zip(&self.places)
                .filter(|(_, place)| **place == NONE);
            self.leaves.extend(missing.map(|(index, _)| Leaf {
                bounds: usable(&boxes[index as usize]),
                index,
            }));
            self.build(first, self.leaves.len());
            self.enter(first);
        }
        self.fit();
    }

    /// Gives the boxes other numbers: `to` has one for each, [`u32::MAX`] of a box that is gone. Before anything is asked, the boxes of
    /// all numbers, new ones among them, are set by [`refit`](Self::refit).
    pub fn renumber(&mut self, to: &[u32]) {
        for leaf in &mut self.leaves {
            leaf.index = to.get(leaf.index as usize).copied().unwrap_or(NONE);
        }
        let last = to.iter().filter(|&&index| index != NONE).max();
        self.places.clear();
        self.places
            .resize(last.map_or(0, |&last| last as usize + 1), NONE);
        self.enter(0);
    }

    /// Notes where the boxes stand that are at this place and behind it.
    fn enter(&mut self, first: usize) {
        for (place, leaf) in self.leaves.iter().enumerate().skip(first) {
            if let Some(of) = self.places.get_mut(leaf.index as usize) {
                *of = place as u32;
            }
        }
    }

    /// Makes the nodes over the boxes `first..last` of `leaves`.
    fn build(&mut self, first: usize, last: usize) {
        let node = self.nodes.len();
        self.nodes.push(Node {
            bounds: Aabb::empty(),
            skip: 0,
            first: first as u32,
            count: (last - first) as u32,
        });
        if last - first > LEAF {
            self.nodes[node].count = 0;
            let part = &mut self.leaves[first..last];
            let mut centres = Aabb::empty();
            for leaf in part.iter() {
                centres.include(&centre(&leaf.bounds));
            }
            let axis = (centres.max - centres.min).imax();
            let middle = part.len() / 2;
            // Boxes with one centre stand in the order of their indices, so that the tree depends on the boxes alone.
            part.select_nth_unstable_by(middle, |a, b| {
                let key = |leaf: &Leaf| centre(&leaf.bounds)[axis];
                key(a).total_cmp(&key(b)).then(a.index.cmp(&b.index))
            });
            self.build(first, first + middle);
            self.build(first + middle, last);
        }
        self.nodes[node].skip = self.nodes.len() as u32;
    }

    /// The boxes of all nodes, children first.
    fn fit(&mut self) {
        for node in (0..self.nodes.len()).rev() {
            let Node { first, count, .. } = self.nodes[node];
            self.nodes[node].bounds = if count > 0 {
                self.leaves[first as usize..][..count as usize]
                    .iter()
                    .fold(Aabb::empty(), |all, leaf| all.union(&leaf.bounds))
            } else {
                let first_child = &self.nodes[node + 1];
                let second_child = &self.nodes[first_child.skip as usize];
                first_child.bounds.union(&second_child.bounds)
            };
        }
    }
}

impl BroadPhase for Bvh {
    fn len(&self) -> usize {
        self.places.len()
    }

    fn bounds(&self, index: u32) -> &Aabb {
        &self.leaves[self.places[index as usize] as usize].bounds
    }

    fn visit(&self, bounds: &Aabb, mut found: impl FnMut(u32)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !node.bounds.overlaps(bounds) {
                at = node.skip as usize;
                continue;
            }
            for leaf in &self.leaves[node.first as usize..][..node.count as usize] {
                if leaf.bounds.overlaps(bounds) {
                    found(leaf.index);
                }
            }
            at += 1;
        }
    }
}

/// The box, or an empty one in place of one that is not a number, which would spread to its parents.
fn usable(bounds: &Aabb) -> Aabb {
    if bounds.is_valid() {
        *bounds
    } else {
        Aabb::empty()
    }
}

/// Middle of a box; halves are added, so that it is finite where the box is.
fn centre(bounds: &Aabb) -> nalgebra::Vector3<f64> {
    bounds.min * 0.5 + bounds.max * 0.5
}

#[cfg(test)]
mod tests;
