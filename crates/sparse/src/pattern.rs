//! The block pattern of a symmetric matrix: which 3×3 blocks are stored, and where.

/// Block CSR pattern of the lower triangle, diagonal included: rows in order, columns ascending, so that the diagonal
/// block is the last of its row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    starts: Vec<u32>,
    columns: Vec<u32>,
}

impl Pattern {
    /// The pattern in which every node of a clique (an element, a spring) is coupled to every other node of it.
    ///
    /// Diagonal blocks are always there, also for nodes without a clique. A node may appear twice in a clique.
    ///
    /// # Panics
    /// When a clique names a node that is not below `nodes`: meshes are validated before they get here.
    pub fn from_cliques<C: AsRef<[u32]>>(
        nodes: usize,
        cliques: impl IntoIterator<Item = C>,
    ) -> Self {
        Self::with_slots(nodes, cliques).0
    }

    /// As [`from_cliques`](Self::from_cliques), with the slots of the blocks of the cliques: clique after clique, for each of its nodes i those
    /// with the nodes before it and with itself, twice the slot, plus one where the node before has the larger number, so that the block is
    /// stored transposed.
    ///
    /// # Panics
    /// As [`from_cliques`](Self::from_cliques).
    pub fn with_slots<C: AsRef<[u32]>>(
        nodes: usize,
        cliques: impl IntoIterator<Item = C>,
    ) -> (Self, Vec<u32>) {
        // The pairs of nodes, and which of them are in each row.
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        let mut ends = vec![0_u32; nodes + 1];
        for clique in cliques {
            let clique = clique.as_ref();
            for (k, &i) in clique.iter().enumerate() {
                for &j in &clique[..=k] {
                    pairs.push([i, j]);
                    ends[i.max(j) as usize + 1] += 1;
                }
            }
        }
        for row in 0..nodes {
            ends[row + 1] += ends[row];
        }
        let mut by_row = vec![0_u32; pairs.len()];
        for (pair, [i, j]) in (0_u32..).zip(&pairs) {
            // What was the start of a row ends as that of the next one.
            let place = &mut ends[*i.max(j) as usize];
            by_row[*place as usize] = pair;
            *place += 1;
        }
        let mut pattern = Self {
            starts: Vec::with_capacity(nodes + 1),
            columns: Vec::new(),
        };
        pattern.starts.push(0);
        let mut slots = vec![0_u32; pairs.len()];
        // Of the columns of the present row: 0, then that it is among the columns, then its slot.
        let mut slot_of = vec![0_u32; nodes];
        let mut start = 0;
        for row in 0..nodes {
            let of_row = &by_row[start as usize..ends[row] as usize];
            start = ends[row];
            let column = |pair: u32| {
                let [i, j] = pairs[pair as usize];
                i.min(j)
            };
            let first = pattern.columns.len();
            let unseen = u32::MAX;
            pattern.columns.push(row as u32);
            slot_of[row] = unseen;
            for &pair in of_row {
                slot_of[column(pair) as usize] = 0;
            }
            slot_of[row] = unseen;
            for &pair in of_row {
                let seen = &mut slot_of[column(pair) as usize];
                if *seen != unseen {
                    *seen = unseen;
                    pattern.columns.push(column(pair));
                }
            }
            pattern.columns[first..].sort_unstable();
            for (slot, &column) in (first as u32..).zip(&pattern.columns[first..]) {
                slot_of[column as usize] = slot;
            }
            for &pair in of_row {
                let [i, j] = pairs[pair as usize];
                slots[pair as usize] = 2 * slot_of[column(pair) as usize] + u32::from(i < j);
            }
            pattern.starts.push(pattern.columns.len() as u32);
        }
        (pattern, slots)
    }

    /// The pattern with these columns, in any order and number; the diagonal is added.
    pub(crate) fn from_rows(mut rows: Vec<Vec<u32>>) -> Self {
        let mut starts = Vec::with_capacity(rows.len() + 1);
        starts.push(0);
        let mut columns = Vec::new();
        for (node, row) in rows.iter_mut().enumerate() {
            row.push(node as u32);
            row.sort_unstable();
            row.dedup();
            columns.extend_from_slice(row);
            starts.push(columns.len() as u32);
        }
        Self { starts, columns }
    }

    /// Number of nodes, that is of block rows.
    pub fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of stored blocks.
    pub fn blocks(&self) -> usize {
        self.columns.len()
    }

    /// The block columns j ≤ i that row `i` stores, ascending; its slots are `first_slot(i)..` in the same order.
    pub fn row(&self, i: usize) -> &[u32] {
        &self.columns[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Slot of the first block of row `i`.
    pub fn first_slot(&self, i: usize) -> usize {
        self.starts[i] as usize
    }

    /// Slot of the diagonal block of row `i`.
    pub fn diagonal_slot(&self, i: usize) -> usize {
        self.starts[i + 1] as usize - 1
    }

    /// Slot of the block in row `i`, column `j`; none where it is not stored, which includes the upper triangle (i < j).
    pub fn slot(&self, i: usize, j: usize) -> Option<usize> {
        let found = self.row(i).binary_search(&u32::try_from(j).ok()?).ok()?;
        Some(self.first_slot(i) + found)
    }

    /// The adjacency of the nodes in both directions, without the diagonal.
    pub(crate) fn graph(&self) -> Graph {
        let nodes = self.nodes();
        let mut starts = vec![0_u32; nodes + 1];
        for i in 0..nodes {
            let row = self.row(i);
            starts[i + 1] += row.len() as u32 - 1;
            for &j in &row[..row.len() - 1] {
                starts[j as usize + 1] += 1;
            }
        }
        for i in 0..nodes {
            starts[i + 1] += starts[i];
        }
        // Row by row: a node gets its smaller neighbours from its own row before the larger ones, both ascending.
        let mut next = starts.clone();
        let mut targets = vec![0; starts[nodes] as usize];
        for i in 0..nodes {
            let row = self.row(i);
            for &j in &row[..row.len() - 1] {
                for (from, to) in [(i, j), (j as usize, i as u32)] {
                    targets[next[from] as usize] = to;
                    next[from] += 1;
                }
            }
        }
        Graph { starts, targets }
    }
}

/// Adjacency lists, each ascending.
pub(crate) struct Graph {
    starts: Vec<u32>,
    targets: Vec<u32>,
}

impl Graph {
    pub fn neighbours(&self, node: u32) -> &[u32] {
        &self.targets[self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cliques;
    use microsim_random::Congruential;

    #[test]
    fn two_triangles_sharing_an_edge() {
        // Nodes 1 and 2 are shared; 0 and 3 are not coupled; node 4 stands alone.
        let pattern = Pattern::from_cliques(5, [[0, 1, 2], [3, 2, 1]]);
        let rows: Vec<&[u32]> = (0..5).map(|i| pattern.row(i)).collect();
        assert_eq!(rows, [&[0][..], &[0, 1], &[0, 1, 2], &[1, 2, 3], &[4]]);
        assert_eq!(pattern.blocks(), 10);
        assert_eq!(pattern.slot(3, 2), Some(7));
        assert_eq!(pattern.slot(3, 0), None);
        assert_eq!(pattern.slot(1, 3), None, "upper triangle");
        assert_eq!(pattern.diagonal_slot(3), pattern.slot(3, 3).unwrap());
        let graph = pattern.graph();
        let neighbours: Vec<&[u32]> = (0..5).map(|i| graph.neighbours(i)).collect();
        assert_eq!(
            neighbours,
            [&[1, 2][..], &[0, 2, 3], &[0, 1, 3], &[1, 2], &[]]
        );
    }

    /// Random cliques, with nodes that appear twice among them: the slots are those that one looks up block by block.
    #[test]
    fn slots_of_cliques_are_those_of_their_blocks() {
        let mut random = Congruential(61);
        for _ in 0..50 {
            let nodes = 1 + random.below(20) as u32;
            let count = random.below(30);
            let cliques = cliques(&mut random, nodes as usize, count);
            let (pattern, slots) = Pattern::with_slots(nodes as usize, &cliques);
            let mut slots = slots.into_iter();
            let mut coupled = vec![false; (nodes * nodes) as usize];
            for clique in &cliques {
                for (k, &i) in clique.iter().enumerate() {
                    for &j in &clique[..=k] {
                        let slot = pattern.slot(i.max(j) as usize, i.min(j) as usize).unwrap();
                        assert_eq!(slots.next(), Some(2 * slot as u32 + u32::from(i < j)));
                        coupled[(i.max(j) * nodes + i.min(j)) as usize] = true;
                    }
                }
            }
            assert_eq!(slots.next(), None);
            for (i, j) in (0..nodes).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let expected = i == j || coupled[(i * nodes + j) as usize];
                assert_eq!(pattern.slot(i as usize, j as usize).is_some(), expected);
            }
        }
    }

    #[test]
    fn empty_and_repeated_nodes() {
        assert_eq!(Pattern::from_cliques(0, [[0_u32; 0]; 0]).nodes(), 0);
        let pattern = Pattern::from_cliques(2, [vec![1, 1, 0], vec![0, 1]]);
        assert_eq!((pattern.row(0), pattern.row(1)), (&[0][..], &[0, 1][..]));
    }
}
