//! Elimination orderings: natural, and nested dissection by positions or by the graph alone.

use nalgebra::Vector3;

use crate::Pattern;
use crate::minimum_degree::MinimumDegree;
use crate::pattern::Graph;
use crate::separator::Separator;

/// Parts of at most this many nodes are not dissected further.
const LEAF_NODES: usize = 32;

/// An elimination ordering: a permutation of the nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ordering {
    sequence: Vec<u32>,
}

/// A sequence that is not a permutation: this node is out of range or repeated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPermutation {
    /// The node.
    pub node: u32,
}

impl std::fmt::Display for NotPermutation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the ordering names node {} twice or beyond the last node",
            self.node
        )
    }
}

impl std::error::Error for NotPermutation {}

impl Ordering {
    /// Nodes in the order of their numbers.
    pub fn natural(nodes: usize) -> Self {
        Self {
            sequence: (0..nodes as u32).collect(),
        }
    }

    /// The given order: `sequence[k]` is the node eliminated k-th.
    ///
    /// # Errors
    /// When a node is repeated or out of range.
    pub fn from_sequence(sequence: Vec<u32>) -> Result<Self, NotPermutation> {
        let mut seen = vec![false; sequence.len()];
        for &node in &sequence {
            match seen.get_mut(node as usize) {
                Some(seen) if !*seen => *seen = true,
                _ => return Err(NotPermutation { node }),
            }
        }
        Ok(Self { sequence })
    }

    /// Nested dissection (George 1973). A part of the nodes is cut in two at the median along the longest axis of its
    /// box; the smallest set of nodes that covers the edges across the cut is the separator, eliminated after both
    /// halves. Small parts are ordered by minimum degree. Without positions the distance from an end of the part
    /// (breadth-first levels from a node found by two sweeps) takes the place of the coordinate.
    ///
    /// # Panics
    /// When there are positions and not one per node.
    pub fn nested_dissection(pattern: &Pattern, positions: Option<&[Vector3<f64>]>) -> Self {
        let nodes = pattern.nodes();
        if let Some(positions) = positions {
            assert_eq!(positions.len(), nodes, "one position per node");
        }
        let mut dissection = Dissection {
            graph: pattern.graph(),
            positions,
            part: vec![0; nodes],
            parts: 0,
            key: vec![0.0; nodes],
            separator: Separator::new(nodes),
            leaves: MinimumDegree::new(nodes),
            sequence: Vec::with_capacity(nodes),
        };
        dissection.order((0..nodes as u32).collect());
        Self {
            sequence: dissection.sequence,
        }
    }

    /// The nodes in the order of their elimination.
    pub fn sequence(&self) -> &[u32] {
        &self.sequence
    }
}

struct Dissection<'a> {
    graph: Graph,
    positions: Option<&'a [Vector3<f64>]>,
    /// Per node: the part it belongs to at present; parts are renumbered at every cut.
    part: Vec<u32>,
    parts: u32,
    /// Per node: the coordinate by which its part is cut.
    key: Vec<f64>,
    separator: Separator,
    leaves: MinimumDegree,
    sequence: Vec<u32>,
}

impl Dissection<'_> {
    /// Appends `nodes` to the sequence. The depth of the recursion is logarithmic, since no half is larger than half.
    fn order(&mut self, mut nodes: Vec<u32>) {
        if nodes.len() <= LEAF_NODES {
            self.leaves.order(&self.graph, &nodes, &mut self.sequence);
            return;
        }
        match self.positions {
            Some(positions) => self.key_by_axis(&nodes, positions),
            None => self.key_by_level(&nodes),
        }
        let key = &self.key;
        nodes
            .sort_unstable_by(|&a, &b| key[a as usize].total_cmp(&key[b as usize]).then(a.cmp(&b)));
        let (left, right) = nodes.split_at(nodes.len() / 2);
        let sides = [self.parts + 1, self.parts + 2];
        self.parts += 2;
        left.iter()
            .for_each(|&node| self.part[node as usize] = sides[0]);
        right
            .iter()
            .for_each(|&node| self.part[node as usize] = sides[1]);
        let cover = self.separator.cover(&self.graph, left, &self.part, sides);
        for &node in &cover {
            self.part[node as usize] = 0;
        }
        let keep = |half: &[u32], side: u32| -> Vec<u32> {
            half.iter()
                .copied()
                .filter(|&node| self.part[node as usize] == side)
                .collect()
        };
        let (left, right) = (keep(left, sides[0]), keep(right, sides[1]));
        self.order(left);
        self.order(right);
        self.sequence.extend(cover);
    }

    /// The coordinate along the longest axis of the box around `nodes`; the first of equally long ones.
    fn key_by_axis(&mut self, nodes: &[u32], positions: &[Vector3<f64>]) {
        let first = positions[nodes[0] as usize];
        let (low, high) = nodes.iter().fold((first, first), |(low, high), &node| {
            (
                low.inf(&positions[node as usize]),
                high.sup(&positions[node as usize]),
            )
        });
        let size = high - low;
        let axis = (1..3).fold(
            0,
            |best, axis| if size[axis] > size[best] { axis } else { best },
        );
        for &node in nodes {
            self.key[node as usize] = positions[node as usize][axis];
        }
    }

    /// The breadth-first level within `nodes`, each connected piece starting from a node at one of its ends.
    fn key_by_level(&mut self, nodes: &[u32]) {
        // Parts: `inside` not yet reached, `inside + k` reached by the k-th of the two sweeps.
        self.parts += 3;
        let inside = self.parts - 2;
        nodes
            .iter()
            .for_each(|&node| self.part[node as usize] = inside);
        let mut level = 0.0;
        let mut reached = Vec::new();
        for &node in nodes {
            if self.part[node as usize] != inside {
                continue;
            }
            self.sweep(node, [inside, inside + 1], level, &mut reached);
            let end = *reached.last().expect("the start is reached");
            self.sweep(end, [inside + 1, inside + 2], level, &mut reached);
            let last = *reached.last().expect("the start is reached");
            level = self.key[last as usize] + 1.0;
        }
    }

    /// Breadth-first from `start` over the nodes of part `from`, which become part `to`; sets their levels.
    fn sweep(&mut self, start: u32, [from, to]: [u32; 2], level: f64, reached: &mut Vec<u32>) {
        reached.clear();
        reached.push(start);
        self.part[start as usize] = to;
        self.key[start as usize] = level;
        let mut next = 0;
        while let Some(&node) = reached.get(next) {
            next += 1;
            for &other in self.graph.neighbours(node) {
                if self.part[other as usize] == from {
                    self.part[other as usize] = to;
                    self.key[other as usize] = self.key[node as usize] + 1.0;
                    reached.push(other);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::Symbolic;
    use crate::testing::{grid, vectors};
    use microsim_random::Congruential;

    fn is_permutation(ordering: &Ordering) -> bool {
        Ordering::from_sequence(ordering.sequence().to_vec()).is_ok()
    }

    #[test]
    fn orderings_are_permutations() {
        let mut random = Congruential(4);
        for (nodes, cliques) in [
            (0, 0),
            (1, 0),
            (500, 0),
            (300, 200),
            (400, 1500),
            (200, 4000),
        ] {
            let cliques = if nodes == 0 {
                Vec::new()
            } else {
                crate::testing::cliques(&mut random, nodes, cliques)
            };
            let pattern = Pattern::from_cliques(nodes, &cliques);
            let positions = vectors(&mut random, nodes);
            for positions in [
                None,
                Some(&positions[..]),
                Some(&vec![Vector3::zeros(); nodes]),
            ] {
                let ordering = Ordering::nested_dissection(&pattern, positions);
                assert_eq!(ordering.sequence().len(), nodes);
                assert!(is_permutation(&ordering));
                assert_eq!(
                    ordering,
                    Ordering::nested_dissection(&pattern, positions),
                    "the same every time"
                );
            }
        }
        // One clique of all: nothing separates it.
        let all: Vec<u32> = (0..200).collect();
        assert!(is_permutation(&Ordering::nested_dissection(
            &Pattern::from_cliques(200, [all]),
            None
        )));
    }

    #[test]
    fn not_a_permutation() {
        assert_eq!(
            Ordering::from_sequence(vec![0, 2, 2]),
            Err(NotPermutation { node: 2 })
        );
        assert_eq!(
            Ordering::from_sequence(vec![0, 3, 1]),
            Err(NotPermutation { node: 3 })
        );
        assert_eq!(
            Ordering::from_sequence(vec![1, 0]).unwrap().sequence(),
            [1, 0]
        );
    }

    #[test]
    fn dissection_fills_less_than_the_natural_order() {
        // A cube of n³ nodes: the natural order is banded with n² beside the diagonal; dissection asymptotically wins
        // by n⁴ log n against n⁵ in entries. At n = 12 it must at least win, with and without positions.
        let (positions, edges) = grid([12, 12, 12]);
        let pattern = Arc::new(Pattern::from_cliques(positions.len(), &edges));
        let analyse = |ordering: &Ordering| Symbolic::analyse(&pattern, ordering);
        let natural = analyse(&Ordering::natural(positions.len()));
        for positions in [None, Some(&positions[..])] {
            let dissected = analyse(&Ordering::nested_dissection(&pattern, positions));
            assert!(dissected.factor_entries() < natural.factor_entries());
            assert!(dissected.flops() < natural.flops());
        }
    }

    #[test]
    fn first_separator_of_a_bar_is_a_layer() {
        // 21 layers of 16: the last 16 nodes of the sequence are the middle layer, whatever the numbering.
        let (positions, edges) = grid([4, 4, 21]);
        let pattern = Pattern::from_cliques(positions.len(), &edges);
        let ordering = Ordering::nested_dissection(&pattern, Some(&positions));
        let last = &ordering.sequence()[positions.len() - 16..];
        let layer = positions[last[0] as usize].z;
        assert!((layer - 10.0).abs() <= 1.0);
        assert!(last.iter().all(|&node| positions[node as usize].z == layer));
    }
}
