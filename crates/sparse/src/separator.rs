//! Vertex separators: the smallest set of nodes that covers the edges between two halves of a graph.

use std::collections::VecDeque;

use crate::pattern::Graph;

const NONE: u32 = u32::MAX;

/// Finds minimum vertex separators; keeps its work arrays between calls.
///
/// The edges that cross from one half to the other form a bipartite graph; its smallest vertex cover separates what
/// remains of the halves, and by König's theorem follows from a maximum matching (here by augmenting paths, one
/// breadth-first search each).
pub(crate) struct Separator {
    /// Per node: its partner in the matching.
    partner: Vec<u32>,
    /// Per node of the right half: the left node from which the search reached it.
    origin: Vec<u32>,
    /// Per node: the search that saw it last.
    seen: Vec<u32>,
    search: u32,
}

impl Separator {
    pub fn new(nodes: usize) -> Self {
        Self {
            partner: vec![NONE; nodes],
            origin: vec![NONE; nodes],
            seen: vec![0; nodes],
            search: 0,
        }
    }

    /// The smallest set of nodes, part of `left` or of `right`, that touches every edge between the two. `part` gives
    /// the side of a node (`sides` = left, right); nodes of neither are ignored. Sorted by node.
    pub fn cover(
        &mut self,
        graph: &Graph,
        left: &[u32],
        part: &[u32],
        sides: [u32; 2],
    ) -> Vec<u32> {
        let across = |node: u32| {
            let side = sides[1];
            graph
                .neighbours(node)
                .iter()
                .copied()
                .filter(move |&other| part[other as usize] == side)
        };
        let border: Vec<u32> = left
            .iter()
            .copied()
            .filter(|&node| across(node).next().is_some())
            .collect();
        for &node in &border {
            self.partner[node as usize] = NONE;
            across(node).for_each(|other| self.partner[other as usize] = NONE);
        }
        // A greedy matching first, then one search for an augmenting path per node still free.
        for &node in &border {
            if let Some(other) = across(node).find(|&other| self.partner[other as usize] == NONE) {
                self.pair(node, other);
            }
        }
        let mut queue = VecDeque::new();
        for &node in &border {
            if self.partner[node as usize] != NONE {
                continue;
            }
            self.search += 1;
            queue.clear();
            queue.push_back(node);
            'search: while let Some(from) = queue.pop_front() {
                for to in across(from) {
                    if self.seen[to as usize] == self.search {
                        continue;
                    }
                    self.seen[to as usize] = self.search;
                    self.origin[to as usize] = from;
                    if self.partner[to as usize] == NONE {
                        self.augment(to);
                        break 'search;
                    }
                    queue.push_back(self.partner[to as usize]);
                }
            }
        }
        // König: from the unmatched left nodes along alternating paths; the cover is what is reached on the right and
        // what is not reached on the left.
        self.search += 1;
        queue.clear();
        for &node in &border {
            if self.partner[node as usize] == NONE {
                self.seen[node as usize] = self.search;
                queue.push_back(node);
            }
        }
        let mut cover = Vec::new();
        while let Some(from) = queue.pop_front() {
            for to in across(from) {
                if self.seen[to as usize] != self.search {
                    self.seen[to as usize] = self.search;
                    cover.push(to);
                    let next = self.partner[to as usize];
                    if self.seen[next as usize] != self.search {
                        self.seen[next as usize] = self.search;
                        queue.push_back(next);
                    }
                }
            }
        }
        cover.extend(
            border
                .iter()
                .copied()
                .filter(|&node| self.seen[node as usize] != self.search),
        );
        cover.sort_unstable();
        cover
    }

    fn pair(&mut self, left: u32, right: u32) {
        self.partner[left as usize] = right;
        self.partner[right as usize] = left;
    }

    /// Flips the path that ends in the free right node `end`.
    fn augment(&mut self, mut end: u32) {
        loop {
            let left = self.origin[end as usize];
            let next = self.partner[left as usize];
            self.pair(left, end);
            if next == NONE {
                return;
            }
            end = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pattern;
    use crate::testing::grid;
    use microsim_random::Congruential;

    /// Cover of the edges between the first `left` nodes and the others.
    fn cover(pattern: &Pattern, left: usize) -> Vec<u32> {
        let nodes = pattern.nodes();
        let part: Vec<u32> = (0..nodes).map(|k| if k < left { 7 } else { 8 }).collect();
        let half: Vec<u32> = (0..left as u32).collect();
        Separator::new(nodes).cover(&pattern.graph(), &half, &part, [7, 8])
    }

    #[test]
    fn as_small_as_brute_force() {
        let mut random = Congruential(3);
        for _ in 0..200 {
            let nodes = 2 + random.below(9);
            let left = 1 + random.below(nodes - 1);
            let edges: Vec<[u32; 2]> = (0..random.below(16))
                .map(|_| [0; 2].map(|_| random.below(nodes) as u32))
                .collect();
            let crossing: Vec<[u32; 2]> = edges
                .iter()
                .copied()
                .filter(|[a, b]| (*a as usize) < left && *b as usize >= left)
                .collect();
            let covers = |set: u32| crossing.iter().all(|[a, b]| (set >> a | set >> b) & 1 == 1);
            let smallest = (0..1_u32 << nodes)
                .filter(|&set| covers(set))
                .map(u32::count_ones)
                .min()
                .unwrap();
            let found = cover(&Pattern::from_cliques(nodes, &crossing), left);
            assert!(
                covers(found.iter().map(|node| 1 << node).sum()),
                "{crossing:?} {found:?}"
            );
            assert_eq!(found.len() as u32, smallest, "{crossing:?} {found:?}");
        }
    }

    #[test]
    fn a_cut_through_a_layer_gives_one_layer() {
        // 7 layers of 25 nodes, cut in the middle of the fourth: no cover is smaller than a layer, since 25 straight
        // lines cross the cut.
        let (positions, edges) = grid([7, 5, 5]);
        assert_eq!(
            cover(&Pattern::from_cliques(positions.len(), &edges), 3 * 25 + 12).len(),
            25
        );
    }
}
