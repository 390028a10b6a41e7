//! The symbolic analysis: everything about a factor that does not depend on the numbers.

use std::sync::Arc;

use crate::elimination::{Fronts, fronts};
use crate::kernels::triangle_start;
use crate::real::WIDTH;
use crate::{Ordering, Pattern};

/// What the factorisation of every matrix on one pattern shares: the fronts, where each block of the matrix goes, and
/// where each front's update goes.
///
/// A front is a supernode: `s` nodes are eliminated together, `u` nodes further up are updated. Its columns of the
/// factor, the *panel*, and its *update* matrix are stored in the strips of the kernels: first the 3s rows of the
/// triangle, filled up to a multiple of eight with rows of the identity, then the 3u rows below, filled up with zeros.
#[derive(Debug)]
pub struct Symbolic {
    pub(crate) pattern: Arc<Pattern>,
    /// The nodes in the order of elimination.
    pub(crate) sequence: Vec<u32>,
    /// The place of each node among them.
    pub(crate) place: Vec<u32>,
    pub(crate) fronts: Vec<Front>,
    /// Per front in turn: the places of its rows below the triangle.
    pub(crate) rows: Vec<u32>,
    /// Beside `rows`: the number of that node in the parent's front.
    pub(crate) in_parent: Vec<u32>,
    /// The children of the fronts in turn.
    pub(crate) children: Vec<u32>,
    /// Blocks of the matrix in the order of the panels they belong to.
    pub(crate) entries: Vec<Entry>,
    /// Octets of all panels together, and of the two stacks of updates.
    pub(crate) panel_octets: usize,
    pub(crate) stack_octets: [usize; 2],
}

#[derive(Debug, Clone)]
pub(crate) struct Front {
    /// Places in the sequence that it eliminates.
    pub columns: std::ops::Range<usize>,
    /// Range in `rows`.
    pub rows: std::ops::Range<usize>,
    /// Range in `children`.
    pub children: std::ops::Range<usize>,
    /// Range in `entries`.
    pub entries: std::ops::Range<usize>,
    /// First octet of the panel.
    pub panel: usize,
    /// Which stack the update lies on, and where. Children lie on the other stack than their parent.
    pub stack: usize,
    pub update: usize,
}

impl Front {
    /// Strips of the triangle.
    pub fn triangle(&self) -> usize {
        (3 * self.columns.len()).div_ceil(WIDTH)
    }

    /// Strips of the rows below.
    pub fn below(&self) -> usize {
        (3 * self.rows.len()).div_ceil(WIDTH)
    }

    /// Octets of the panel.
    pub fn panel_octets(&self) -> usize {
        triangle_start(self.triangle()) + self.below() * self.triangle() * WIDTH
    }

    /// Octets of the update.
    pub fn update_octets(&self) -> usize {
        triangle_start(self.below())
    }

    /// Where scalar row `row` of a triangle begins: the octet of its column 0, and its lane.
    pub fn own_row(row: usize) -> (usize, usize) {
        (triangle_start(row / WIDTH), row % WIDTH)
    }

    /// The same in the panel for scalar row `row` of those below its triangle.
    pub fn below_row(&self, row: usize) -> (usize, usize) {
        let triangle = self.triangle();
        (
            triangle_start(triangle) + row / WIDTH * triangle * WIDTH,
            row % WIDTH,
        )
    }
}

/// Where a block of the matrix goes.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub slot: u32,
    /// The nodes of the block.
    pub nodes: [u32; 2],
    /// For each row of the block: the octet of its first column within the panel, times eight, plus the lane.
    pub targets: [u32; 3],
    pub kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// On the diagonal; this is the first of its three columns within the panel.
    Diagonal(u32),
    /// As stored.
    Lower,
    /// The ordering exchanges the two nodes: the transpose goes into the panel.
    Upper,
}

impl Symbolic {
    /// Analyses the pattern under an ordering. The result serves every matrix on this pattern.
    ///
    /// # Panics
    /// When the ordering is not one of the pattern's nodes, or the columns of one front hold 2³² numbers or more.
    pub fn analyse(pattern: &Arc<Pattern>, ordering: &Ordering) -> Self {
        assert_eq!(
            ordering.sequence().len(),
            pattern.nodes(),
            "the ordering is one of the pattern's nodes"
        );
        let Fronts {
            sequence,
            first,
            rows,
            parent,
        } = fronts(&pattern.graph(), ordering.sequence());
        let mut place = vec![0; sequence.len()];
        for (k, &node) in sequence.iter().enumerate() {
            place[node as usize] = k as u32;
        }
        let mut symbolic = Self {
            pattern: pattern.clone(),
            sequence,
            place,
            fronts: Vec::with_capacity(rows.len()),
            rows: Vec::new(),
            in_parent: Vec::new(),
            children: Vec::new(),
            entries: Vec::with_capacity(pattern.blocks()),
            panel_octets: 0,
            stack_octets: [0; 2],
        };
        for (k, rows) in rows.iter().enumerate() {
            let start = symbolic.rows.len();
            symbolic.rows.extend_from_slice(rows);
            let front = Front {
                columns: first[k] as usize..first[k + 1] as usize,
                rows: start..symbolic.rows.len(),
                children: 0..0,
                entries: 0..0,
                panel: symbolic.panel_octets,
                stack: 0,
                update: 0,
            };
            symbolic.panel_octets += front.panel_octets();
            symbolic.fronts.push(front);
        }
        symbolic.link(&parent);
        symbolic.map_entries();
        symbolic
    }

    /// Children, the places of their rows in the parent, and the stacks of updates.
    fn link(&mut self, parent: &[Option<u32>]) {
        let count = self.fronts.len();
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); count];
        self.in_parent = vec![0; self.rows.len()];
        for k in (0..count).rev() {
            let Some(p) = parent[k] else { continue };
            lists[p as usize].push(k as u32);
            self.fronts[k].stack = 1 - self.fronts[p as usize].stack;
            let (front, above) = (&self.fronts[k], &self.fronts[p as usize]);
            let mut next = above.rows.start;
            for index in front.rows.clone() {
                let row = self.rows[index] as usize;
                self.in_parent[index] = if row < above.columns.end {
                    (row - above.columns.start) as u32
                } else {
                    while (self.rows[next] as usize) < row {
                        next += 1;
                    }
                    (above.columns.len() + next - above.rows.start) as u32
                };
            }
        }
        // In postorder the updates that wait on a stack when a front begins are its elder siblings' and those of other
        // branches; its children's lie on top of the other stack and go when it is done.
        let mut tops = [0; 2];
        for (k, mut list) in lists.into_iter().enumerate() {
            list.reverse();
            let start = self.children.len();
            self.children.append(&mut list);
            self.fronts[k].children = start..self.children.len();
            let stack = self.fronts[k].stack;
            self.fronts[k].update = tops[stack];
            tops[stack] += self.fronts[k].update_octets();
            self.stack_octets[stack] = self.stack_octets[stack].max(tops[stack]);
            if let Some(&eldest) = self.children.get(start) {
                tops[1 - stack] = self.fronts[eldest as usize].update;
            }
        }
    }

    /// The places of the matrix' blocks in the panels.
    fn map_entries(&mut self) {
        let place = |node: u32| self.place[node as usize] as usize;
        // The blocks (slot and nodes) by the place of their column, which is the earlier of their two nodes: those of column k are `blocks[starts[k]..starts[k + 1]]`.
        let slots = |i: usize| self.pattern.row(i).iter().zip(self.pattern.first_slot(i)..);
        let mut starts = vec![0; self.sequence.len() + 1];
        for i in 0..self.pattern.nodes() {
            for (&j, _) in slots(i) {
                starts[place(i as u32).min(place(j)) + 1] += 1;
            }
        }
        for k in 0..self.sequence.len() {
            starts[k + 1] += starts[k];
        }
        let mut ends = starts.clone();
        let mut blocks = vec![(0, [0; 2]); self.pattern.blocks()];
        for i in 0..self.pattern.nodes() {
            for (&j, slot) in slots(i) {
                let end = &mut ends[place(i as u32).min(place(j))];
                blocks[*end] = (slot as u32, [i as u32, j]);
                *end += 1;
            }
        }
        let mut below = vec![0; self.sequence.len()];
        for front in &mut self.fronts {
            assert!(
                front.panel_octets() < u32::MAX as usize / WIDTH,
                "a front has less than 2³² numbers"
            );
            for (k, &row) in self.rows[front.rows.clone()].iter().enumerate() {
                below[row as usize] = k;
            }
            let start = self.entries.len();
            for (k, column) in front.columns.clone().enumerate() {
                for &(slot, nodes) in &blocks[starts[column]..starts[column + 1]] {
                    let [i, j] = nodes.map(&place);
                    let targets = std::array::from_fn(|a| {
                        let row = i.max(j);
                        let (octet, lane) = if row < front.columns.end {
                            Front::own_row(3 * (row - front.columns.start) + a)
                        } else {
                            front.below_row(3 * below[row] + a)
                        };
                        (WIDTH * (octet + 3 * k) + lane) as u32
                    });
                    let kind = match i.cmp(&j) {
                        std::cmp::Ordering::Less => Kind::Upper,
                        std::cmp::Ordering::Equal => Kind::Diagonal(3 * k as u32),
                        std::cmp::Ordering::Greater => Kind::Lower,
                    };
                    self.entries.push(Entry {
                        slot,
                        nodes,
                        targets,
                        kind,
                    });
                }
            }
            front.entries = start..self.entries.len();
        }
    }

    /// Numbers that a factor holds, filling included.
    pub fn factor_entries(&self) -> usize {
        WIDTH * self.panel_octets
    }

    /// Numbers of the updates that wait at most during a factorisation.
    pub fn workspace_entries(&self) -> usize {
        WIDTH * (self.stack_octets[0] + self.stack_octets[1])
    }

    /// Additions and multiplications of one factorisation, without those on filling.
    pub fn flops(&self) -> f64 {
        let front = |front: &Front| {
            let (s, u) = (
                3.0 * front.columns.len() as f64,
                3.0 * front.rows.len() as f64,
            );
            s * s * s / 3.0 + s * s * u + s * u * (u + 1.0)
        };
        self.fronts.iter().map(front).sum()
    }

    /// Number of fronts.
    pub fn fronts(&self) -> usize {
        self.fronts.len()
    }

    /// The nodes in the order in which they are eliminated: the ordering given, up to equivalent exchanges.
    pub fn sequence(&self) -> &[u32] {
        &self.sequence
    }
}
