//! From pattern and ordering to the tree of fronts: elimination tree, structure of the factor, supernodes.
//!
//! Liu, "The role of elimination trees in sparse factorization" (1990), for the tree and the structures; the merging of
//! small fronts weighs arithmetic against the cost of passing an update matrix on.

use crate::pattern::Graph;

const NONE: u32 = u32::MAX;

/// The fronts in the order of elimination, children before parents, each subtree contiguous.
pub(crate) struct Fronts {
    /// The nodes in the order of elimination.
    pub sequence: Vec<u32>,
    /// Front k eliminates the places `first[k]..first[k + 1]` of the sequence.
    pub first: Vec<u32>,
    /// Per front: the places below its own that its columns couple to, ascending.
    pub rows: Vec<Vec<u32>>,
    /// Per front: the front that takes its update; none for a root.
    pub parent: Vec<Option<u32>>,
}

/// Analyses the graph under an ordering (`sequence[k]` is eliminated k-th).
pub(crate) fn fronts(graph: &Graph, sequence: &[u32]) -> Fronts {
    let (parent, _) = elimination_tree(graph, sequence);
    // With the columns in postorder a supernode is a run of columns.
    let sequence: Vec<u32> = postorder(&parent)
        .into_iter()
        .map(|k| sequence[k as usize])
        .collect();
    let (parent, place) = elimination_tree(graph, &sequence);
    let supernodes = Supernodes::find(graph, &sequence, &place, &parent);
    supernodes.merged().into_fronts(&sequence)
}

/// The parent of each place (its first coupling in the factor) and the place of each node.
fn elimination_tree(graph: &Graph, sequence: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut place = vec![0; sequence.len()];
    for (k, &node) in sequence.iter().enumerate() {
        place[node as usize] = k as u32;
    }
    let mut parent = vec![NONE; sequence.len()];
    let mut ancestor = vec![NONE; sequence.len()];
    for (k, &node) in sequence.iter().enumerate() {
        let k = k as u32;
        for &other in graph.neighbours(node) {
            // Climb to the root of what is eliminated so far, shortening the path for the next climb.
            let mut below = place[other as usize];
            while below < k {
                let next = ancestor[below as usize];
                ancestor[below as usize] = k;
                if next == NONE {
                    parent[below as usize] = k;
                    break;
                }
                below = next;
            }
        }
    }
    (parent, place)
}

/// Depth-first order of a forest, children before parents, siblings in the order of their numbers.
fn postorder(parent: &[u32]) -> Vec<u32> {
    // The children of each as a list, and the roots as those of a parent of all: the last one, and of each the one before.
    let all = parent.len();
    let mut last_child = vec![NONE; all + 1];
    let mut before = vec![NONE; all];
    for (k, &p) in parent.iter().enumerate() {
        let of_parent = &mut last_child[if p == NONE { all } else { p as usize }];
        before[k] = std::mem::replace(of_parent, k as u32);
    }
    // Parents before children and the last sibling first: the reverse of the postorder.
    let mut order = Vec::with_capacity(all);
    let mut stack = vec![last_child[all]];
    while let Some(k) = stack.pop() {
        if k != NONE {
            order.push(k);
            stack.extend([before[k as usize], last_child[k as usize]]);
        }
    }
    order.reverse();
    order
}

/// Groups of columns with one structure.
struct Supernodes {
    /// The places each eliminates, in order; empty once merged into its parent.
    columns: Vec<Vec<u32>>,
    /// The places below, ascending.
    rows: Vec<Vec<u32>>,
    parent: Vec<u32>,
}

impl Supernodes {
    /// The maximal runs of columns k, k + 1 with parent(k) = k + 1 and no new coupling in column k + 1.
    fn find(graph: &Graph, sequence: &[u32], place: &[u32], parent: &[u32]) -> Self {
        let count = sequence.len();
        // The children of a column so far as a list: the last one, and of each the one before.
        let mut last_child = vec![NONE; count];
        let mut before = vec![NONE; count];
        let mut structure: Vec<Vec<u32>> = vec![Vec::new(); count];
        let mut mark = vec![NONE; count];
        let mut owner: Vec<u32> = vec![NONE; count];
        let mut columns: Vec<Vec<u32>> = Vec::new();
        let mut rows = Vec::new();
        for k in 0..count as u32 {
            rows.clear();
            mark[k as usize] = k;
            let mut take = |row: u32| {
                if row > k && mark[row as usize] != k {
                    mark[row as usize] = k;
                    rows.push(row);
                }
            };
            for &other in graph.neighbours(sequence[k as usize]) {
                take(place[other as usize]);
            }
            let last = last_child[k as usize];
            let mut child = last;
            while child != NONE {
                structure[child as usize]
                    .iter()
                    .copied()
                    .for_each(&mut take);
                child = before[child as usize];
            }
            rows.sort_unstable();
            let continues =
                last != NONE && last + 1 == k && structure[last as usize].len() == rows.len() + 1;
            if continues {
                structure[k as usize - 1] = Vec::new();
                owner[k as usize] = owner[k as usize - 1];
            } else {
                owner[k as usize] = columns.len() as u32;
                columns.push(Vec::new());
            }
            columns[owner[k as usize] as usize].push(k);
            structure[k as usize] = rows.clone();
            if parent[k as usize] != NONE {
                let of_parent = &mut last_child[parent[k as usize] as usize];
                before[k as usize] = std::mem::replace(of_parent, k);
            }
        }
        let last = |columns: &Vec<u32>| *columns.last().expect("a supernode has a column") as usize;
        let rows = columns
            .iter()
            .map(|columns| std::mem::take(&mut structure[last(columns)]))
            .collect();
        let parent = columns
            .iter()
            .map(|columns| match parent[last(columns)] {
                NONE => NONE,
                parent => owner[parent as usize],
            })
            .collect();
        Self {
            columns,
            rows,
            parent,
        }
    }

    /// Merges a child into its parent wherever the front of both together is cheaper than the two, although it holds
    /// zeros: from the leaves up, the children of a parent in order.
    fn merged(mut self) -> Self {
        let count = self.columns.len();
        let mut children = vec![Vec::new(); count];
        for p in 0..count {
            let mut left = Vec::new();
            for child in std::mem::take(&mut children[p]) {
                let child: usize = child;
                let (s, u) = (self.columns[p].len(), self.rows[p].len());
                let (s_child, u_child) = (self.columns[child].len(), self.rows[child].len());
                if cost(s + s_child, u) <= cost(s, u) + cost(s_child, u_child) {
                    let mut columns = std::mem::take(&mut self.columns[child]);
                    columns.append(&mut self.columns[p]);
                    self.columns[p] = columns;
                    self.rows[child] = Vec::new();
                    left.append(&mut children[child]);
                } else {
                    left.push(child);
                }
            }
            left.iter().for_each(|&child| self.parent[child] = p as u32);
            children[p] = left;
            if self.parent[p] != NONE {
                children[self.parent[p] as usize].push(p);
            }
        }
        self
    }

    /// Renumbers what is left, in postorder.
    fn into_fronts(mut self, sequence: &[u32]) -> Fronts {
        let order: Vec<u32> = postorder(&self.parent)
            .into_iter()
            .filter(|&k| !self.columns[k as usize].is_empty())
            .collect();
        let mut number = vec![NONE; self.columns.len()];
        let mut renamed = vec![0; sequence.len()];
        let mut fronts = Fronts {
            sequence: Vec::new(),
            first: vec![0],
            rows: Vec::new(),
            parent: Vec::new(),
        };
        for (k, &supernode) in order.iter().enumerate() {
            number[supernode as usize] = k as u32;
            for &column in &self.columns[supernode as usize] {
                renamed[column as usize] = fronts.sequence.len() as u32;
                fronts.sequence.push(sequence[column as usize]);
            }
            fronts.first.push(fronts.sequence.len() as u32);
        }
        for &supernode in &order {
            let mut rows = std::mem::take(&mut self.rows[supernode as usize]);
            rows.iter_mut()
                .for_each(|row| *row = renamed[*row as usize]);
            rows.sort_unstable();
            fronts.rows.push(rows);
            let parent = self.parent[supernode as usize];
            fronts
                .parent
                .push((parent != NONE).then(|| number[parent as usize]));
        }
        fronts
    }
}

/// Cost of a front that eliminates `s` nodes and updates `u`, in multiplications: the arithmetic, ten for each number
/// of the update matrix, which is written and then added to the parent, and a fixed cost for walking through it. The
/// weights were measured on grids of 256 to 10,309 nodes; the optimum is flat.
fn cost(s: usize, u: usize) -> f64 {
    let (s, u) = (3.0 * s as f64, 3.0 * u as f64);
    s * s * s / 6.0 + s * s * u / 2.0 + s * u * u / 2.0 + 10.0 * u * u / 2.0 + 5000.0
}
