//! Minimum-degree ordering of a few nodes whose other neighbours are eliminated later.

use crate::pattern::Graph;

/// Work arrays of the leaves' ordering.
pub(crate) struct MinimumDegree {
    /// Per node of the graph: its number within the leaf and its surroundings, valid where `stamp` is current.
    local: Vec<u32>,
    stamp: Vec<u32>,
    current: u32,
    /// Adjacency of the local nodes, one bit each, `words` words a row.
    bits: Vec<u64>,
}

impl MinimumDegree {
    pub fn new(nodes: usize) -> Self {
        Self {
            local: vec![0; nodes],
            stamp: vec![0; nodes],
            current: 0,
            bits: Vec::new(),
        }
    }

    /// Appends `leaf` to `sequence` in the order of smallest degree, ties by position in `leaf`. Degrees count the
    /// fill, and the surrounding nodes, which are not eliminated here.
    pub fn order(&mut self, graph: &Graph, leaf: &[u32], sequence: &mut Vec<u32>) {
        self.current += 1;
        let mut count = 0;
        let mut number = |node: u32, local: &mut [u32], stamp: &mut [u32]| {
            if stamp[node as usize] != self.current {
                stamp[node as usize] = self.current;
                local[node as usize] = count;
                count += 1;
            }
        };
        for &node in leaf {
            number(node, &mut self.local, &mut self.stamp);
        }
        for &node in leaf {
            for &other in graph.neighbours(node) {
                number(other, &mut self.local, &mut self.stamp);
            }
        }
        let words = (count as usize).div_ceil(64);
        self.bits.clear();
        self.bits.resize(words * count as usize, 0);
        for (i, &node) in leaf.iter().enumerate() {
            for &other in graph.neighbours(node) {
                let j = self.local[other as usize] as usize;
                self.bits[i * words + j / 64] |= 1 << (j % 64);
                self.bits[j * words + i / 64] |= 1 << (i % 64);
            }
        }
        let mut waiting: Vec<usize> = (0..leaf.len()).collect();
        while !waiting.is_empty() {
            let degree = |i: usize| {
                self.bits[i * words..(i + 1) * words]
                    .iter()
                    .map(|w| w.count_ones())
                    .sum::<u32>()
            };
            let (place, _) = waiting
                .iter()
                .enumerate()
                .min_by_key(|&(place, &i)| (degree(i), place))
                .expect("a node waits");
            let pivot = waiting.remove(place);
            sequence.push(leaf[pivot]);
            // The neighbours of the pivot become a clique, without the pivot.
            let row = self.bits[pivot * words..(pivot + 1) * words].to_vec();
            for j in (0..count as usize).filter(|&j| row[j / 64] >> (j % 64) & 1 == 1) {
                let other = &mut self.bits[j * words..(j + 1) * words];
                other
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(word, clique)| *word |= clique);
                other[j / 64] &= !(1 << (j % 64));
                other[pivot / 64] &= !(1 << (pivot % 64));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pattern;

    fn order(nodes: usize, edges: &[[u32; 2]], leaf: &[u32]) -> Vec<u32> {
        let graph = Pattern::from_cliques(nodes, edges).graph();
        let mut sequence = Vec::new();
        MinimumDegree::new(nodes).order(&graph, leaf, &mut sequence);
        sequence
    }

    #[test]
    fn a_star_goes_from_its_tips() {
        // Centre 0 with tips 1..5: degree 4 against 1; when one tip is left both have degree 1 and 0 stands first.
        let edges = [[0, 1], [0, 2], [0, 3], [0, 4]];
        assert_eq!(order(5, &edges, &[0, 1, 2, 3, 4]), [1, 2, 3, 0, 4]);
    }

    #[test]
    fn degrees_count_fill() {
        // Ring 0-1-2-3-4-5: after 0 goes, 1 and 5 are joined and keep degree 2; after 1, 5 and 2 are.
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0]];
        assert_eq!(order(6, &edges, &[0, 1, 2, 3, 4, 5]), [0, 1, 2, 3, 4, 5]);
        // With tip 6 on 1, eliminating 0 gives 5 the degree 2 still, and 1 the degree 3: 2 would too. The tip is first.
        assert_eq!(
            order(7, &[&edges[..], &[[1, 6]]].concat(), &[0, 1, 2, 3, 4, 5, 6])[0],
            6
        );
    }

    #[test]
    fn surroundings_count_but_stay() {
        // Node 0 touches two nodes outside the leaf, node 1 one.
        assert_eq!(order(5, &[[0, 2], [0, 3], [1, 4]], &[0, 1]), [1, 0]);
    }
}
