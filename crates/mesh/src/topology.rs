//! Connectivity of triangles and elements, as the validity reports need it.

/// The triangles at one edge.
pub(crate) struct EdgeUse {
    /// The edge, smaller node first.
    pub edge: [u32; 2],
    /// Each triangle with whether it runs along the edge from the smaller node to the larger.
    pub triangles: Vec<(u32, bool)>,
}

/// Every edge of `triangles` with the triangles at it, in ascending order.
pub(crate) fn edge_uses(triangles: &[[u32; 3]]) -> Vec<EdgeUse> {
    let mut uses: Vec<([u32; 2], u32, bool)> = Vec::with_capacity(3 * triangles.len());
    for (index, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            uses.push(([i.min(j), i.max(j)], index as u32, i < j));
        }
    }
    uses.sort_unstable();
    uses.chunk_by(|a, b| a.0 == b.0)
        .map(|chunk| EdgeUse {
            edge: chunk[0].0,
            triangles: chunk.iter().map(|&(_, t, forward)| (t, forward)).collect(),
        })
        .collect()
}

/// The nodes at which the triangles fall into several fans without a common edge, each with their number: places where
/// sheets touch in one point only.
pub(crate) fn pinched_nodes(triangles: &[[u32; 3]]) -> Vec<(u32, usize)> {
    // For each triangle at a node, the node's two neighbours in it.
    let mut corners: Vec<(u32, [u32; 2])> = Vec::with_capacity(3 * triangles.len());
    for t in triangles {
        for k in 0..3 {
            corners.push((t[k], [t[(k + 1) % 3], t[(k + 2) % 3]]));
        }
    }
    corners.sort_unstable();
    corners
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|fan| {
            let mut neighbours: Vec<u32> = fan.iter().flat_map(|(_, pair)| *pair).collect();
            neighbours.sort_unstable();
            neighbours.dedup();
            let place = |node: u32| neighbours.partition_point(|&n| n < node);
            let mut groups = Groups::new(neighbours.len());
            for (_, [i, j]) in fan {
                groups.join(place(*i), place(*j));
            }
            let fans = groups.count();
            (fans > 1).then_some((fan[0].0, fans))
        })
        .collect()
}

/// Disjoint groups of the numbers below a bound (union–find).
pub(crate) struct Groups {
    parent: Vec<usize>,
}

impl Groups {
    /// Every number below `n` a group of its own.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            parent: (0..n).collect(),
        }
    }

    /// The smallest number of the group of `i`.
    pub(crate) fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    /// Makes the groups of `i` and `j` one.
    pub(crate) fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.root(i), self.root(j));
        self.parent[i.max(j)] = i.min(j);
    }

    /// Number of groups.
    pub(crate) fn count(&self) -> usize {
        (0..self.parent.len())
            .filter(|&i| self.parent[i] == i)
            .count()
    }
}
