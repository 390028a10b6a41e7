//! The broad phase that there is without one: every box is compared with every other.

use crate::aabb::Aabb;
use crate::broad_phase::BroadPhase;

/// A set of boxes, compared one by one. Its cost grows with the product of the numbers of boxes; it is what other broad phases are measured against.
#[derive(Clone, Debug, Default)]
pub struct AllPairs {
    boxes: Vec<Aabb>,
}

impl AllPairs {
    /// An empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Replaces the set by `boxes`.
    pub fn rebuild(&mut self, boxes: &[Aabb]) {
        self.boxes.clear();
        self.boxes.extend_from_slice(boxes);
    }
}

impl BroadPhase for AllPairs {
    fn len(&self) -> usize {
        self.boxes.len()
    }

    fn bounds(&self, index: u32) -> &Aabb {
        &self.boxes[index as usize]
    }

    fn visit(&self, bounds: &Aabb, mut found: impl FnMut(u32)) {
        for (index, own) in self.boxes.iter().enumerate() {
            if own.overlaps(bounds) {
                found(index as u32);
            }
        }
    }
}
