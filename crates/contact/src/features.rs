//! The features of a surface that are near something, each once.

use crate::broad_phase::Boxes;
use crate::surface::ContactSurface;
use microsim_geometry::{Aabb, BroadPhase};

/// The features near a box, ascending.
#[derive(Clone, Debug, Default)]
pub(crate) struct Features {
    pub triangles: Vec<u32>,
    pub edges: Vec<u32>,
    pub nodes: Vec<u32>,
    marks: Marks,
}

impl Features {
    /// Finds the triangles whose boxes overlap `bounds`, with their edges and nodes.
    pub fn find(&mut self, surface: &ContactSurface, triangles: &Boxes, bounds: &Aabb) {
        triangles.query(bounds, &mut self.triangles);
        let near = || self.triangles.iter().map(|&triangle| triangle as usize);
        let edges = near().map(|triangle| surface.triangle_edges[triangle]);
        self.marks.take(edges, &mut self.edges);
        let nodes = near().map(|triangle| surface.triangles[triangle]);
        self.marks.take(nodes, &mut self.nodes);
    }
}

/// Numbers that were found, a bit each: read in order they are ascending and each is there once, which sorting would take longer for.
#[derive(Clone, Debug, Default)]
struct Marks(Vec<u64>);

impl Marks {
    /// Sets `taken` to the numbers that are in `found`.
    fn take(&mut self, found: impl Iterator<Item = [u32; 3]>, taken: &mut Vec<u32>) {
        for number in found.flatten() {
            let word = number as usize / 64;
            if word >= self.0.len() {
                self.0.resize(word + 1, 0);
            }
            self.0[word] |= 1 << (number % 64);
        }
        taken.clear();
        for (index, word) in self.0.iter_mut().enumerate() {
            while *word != 0 {
                taken.push(64 * index as u32 + word.trailing_zeros());
                *word &= *word - 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_random::Congruential;
    use std::collections::BTreeSet;

    /// Against a set of the standard library, again and again with the same marks.
    #[test]
    fn what_is_found_is_taken_once_and_ascending() {
        let mut random = Congruential(5);
        let (mut marks, mut taken) = (Marks::default(), vec![7]);
        for count in [0, 1, 5, 200] {
            let mut number = || random.below(500) as u32;
            let found: Vec<[u32; 3]> = (0..count).map(|_| [number(), number(), number()]).collect();
            marks.take(found.iter().copied(), &mut taken);
            let expected: BTreeSet<u32> = found.into_iter().flatten().collect();
            assert_eq!(taken, Vec::from_iter(expected));
        }
    }
}
