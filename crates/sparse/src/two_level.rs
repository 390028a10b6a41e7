//! A preconditioner of two levels for large bodies: symmetric Gauss–Seidel on the nodes, and the exact solution in the coarse
//! space of a [`Lattice`].
//!
//! ```text
//! (D + L) x = r                      forward sweep
//! x ← x + P (Pᵀ A P)⁻¹ Pᵀ (r − A x)  coarse correction
//! (D + Lᵀ) x = r − L x               backward sweep
//! ```
//!
//! Symmetric and positive definite with A, so it serves [`ConjugateGradients`](crate::ConjugateGradients): some ten iterations to 1e-3 and twenty to 1e-7 for
//! elastic solids, whatever their number of nodes, where the cost of a factor grows with its square. Each sweep reads the matrix
//! once: the forward one leaves −Lᵀ x, which is the residual after it, at no cost.
//!
//! The sweeps are in f32, the coarse matrix in f64, as it may have directions without stiffness (a point
//! in which few nodes have a part), which a small addition to its diagonal regularises.
//!
//! Not here: more than two levels. The coarse factor is exact; from some hundred thousand nodes on it would take the most time.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::{BlockMatrix, Factor, Lattice, NotPositive, Ordering, Pattern, Symbolic};

/// Regularisation: what is added to the diagonal of the coarse matrix, relative to it: far below the stiffness of any mode that a body of a
/// thousand cells in length has, far above rounding.
const SHIFT: f64 = 1e-10;

/// How a part of a fine block goes into the coarse matrix: as it is, transposed, or both in a diagonal block. The two low bits of a
/// target; above them the slot.
const STRAIGHT: u32 = 0;
const TRANSPOSED: u32 = 1;
const BOTH: u32 = 2;

type Triple = [f32; 3];

/// The preconditioner for matrices of one pattern.
#[derive(Debug)]
pub struct TwoLevel {
    pattern: Arc<Pattern>,
    lattice: Arc<Lattice>,
    /// Of each fine block in turn, for each pair of points of its two nodes: where in the coarse matrix, and how.
    targets: Arc<[u32]>,
    coarse: BlockMatrix,
    factor: Factor<f64>,
    /// The blocks of A by rows, at the slots of its pattern; on the diagonal their inverses.
    blocks: Vec<[Triple; 3]>,
    fixed: Vec<bool>,
    x: Vec<Triple>,
    left: Vec<Triple>,
    right_side: Vec<Vector3<f64>>,
}

impl TwoLevel {
    /// Finds where everything goes; there are no numbers yet.
    ///
    /// # Panics
    /// When `lattice` does not have the nodes of `pattern`.
    pub fn new(pattern: &Arc<Pattern>, lattice: Lattice) -> Self {
        let coarse_pattern = Arc::new(coarse_pattern(pattern, &lattice));
        let targets = targets(pattern, &lattice, &coarse_pattern);
        let ordering = Ordering::nested_dissection(&coarse_pattern, Some(lattice.positions()));
        let symbolic = Arc::new(Symbolic::analyse(&coarse_pattern, &ordering));
        Self::with_places(
            pattern.clone(),
            Arc::new(lattice),
            targets.into(),
            BlockMatrix::zeros(coarse_pattern),
            Factor::new(symbolic),
        )
    }

    fn with_places(
        pattern: Arc<Pattern>,
        lattice: Arc<Lattice>,
        targets: Arc<[u32]>,
        coarse: BlockMatrix,
        factor: Factor<f64>,
    ) -> Self {
        let nodes = pattern.nodes();
        Self {
            targets,
            coarse,
            factor,
            blocks: vec![[[0.0; 3]; 3]; pattern.blocks()],
            fixed: vec![false; nodes],
            x: vec![[0.0; 3]; nodes],
            left: vec![[0.0; 3]; nodes],
            right_side: vec![Vector3::zeros(); lattice.count()],
            pattern,
            lattice,
        }
    }

    /// Takes over the numbers of `matrix`; rows and columns of the nodes marked in `fixed` are those of the identity.
    ///
    /// # Errors
    /// When a diagonal block or the coarse matrix is not positive definite, with a node there.
    ///
    /// # Panics
    /// When `matrix` or `fixed` does not have the nodes of the pattern.
    pub fn refresh(&mut self, matrix: &BlockMatrix, fixed: &[bool]) -> Result<(), NotPositive> {
        let pattern = &*self.pattern;
        assert!(
            (Arc::ptr_eq(&self.pattern, matrix.pattern()) || *pattern == **matrix.pattern())
                && fixed.len() == pattern.nodes(),
            "the pattern that was analysed"
        );
        self.fixed.copy_from_slice(fixed);
        self.coarse.clear();
        let coarse = self.coarse.values_mut();
        let mut targets = self.targets.iter();
        for i in 0..pattern.nodes() {
            let first = pattern.first_slot(i);
            for (k, &j) in pattern.row(i).iter().enumerate() {
                let j = j as usize;
                let value = &matrix.values()[first + k];
                let free = !fixed[i] && !fixed[j];
                for_pairs(&self.lattice, i, j, |_, _, weight| {
                    let target = targets.next().expect("a target for each pair");
                    if !free {
                        return;
                    }
                    let block = &mut coarse[(target >> 2) as usize];
                    match target & 3 {
                        STRAIGHT => *block += value * weight,
                        TRANSPOSED => *block += value.transpose() * weight,
                        _ => *block += (value + value.transpose()) * weight,
                    }
                });
                let block = if i == j && !fixed[i] {
                    inverse(value).ok_or(NotPositive { node: i })?
                } else if i == j {
                    Matrix3::identity()
                } else if free {
                    *value
                } else {
                    Matrix3::zeros()
                };
                self.blocks[first + k] =
                    std::array::from_fn(|r| std::array::from_fn(|c| block[(r, c)] as f32));
            }
        }
        self.factorise_coarse()
    }

    fn factorise_coarse(&mut self) -> Result<(), NotPositive> {
        for point in 0..self.lattice.count() {
            let diagonal = *self.coarse.diagonal(point);
            // A point all of whose nodes are fixed has nothing.
            let added = if diagonal.trace() == 0.0 {
                1.0
            } else {
                SHIFT * diagonal.trace()
            };
            let block = Matrix3::from_diagonal_element(added);
            self.coarse.add_diagonal(point, &block);
        }
        self.factor.factorise(&self.coarse, None).map_err(|at| {
            let has_a_part = |&node: &usize| {
                let mut points = self.lattice.weights(node);
                points.any(|(point, _)| point as usize == at.node)
            };
            let node = (0..self.pattern.nodes()).find(has_a_part).unwrap_or(0);
            NotPositive { node }
        })
    }

    /// z = C⁻¹ r.
    ///
    /// # Panics
    /// When `r` or `z` does not have one entry per node.
    pub fn apply(&mut self, r: &[Vector3<f64>], z: &mut [Vector3<f64>]) {
        let nodes = self.pattern.nodes();
        assert_eq!((r.len(), z.len()), (nodes, nodes), "one vector per node");
        self.sweep_forward(r);
        self.correct();
        self.sweep_backward(r);
        for (z, x) in z.iter_mut().zip(&self.x) {
            *z = Vector3::from(x.map(f64::from));
        }
    }

    /// Solves (D + L) x = r, and sets `left` to r − A x.
    fn sweep_forward(&mut self, r: &[Vector3<f64>]) {
        let Self {
            pattern,
            blocks,
            x,
            left,
            ..
        } = self;
        for i in 0..x.len() {
            let row = pattern.row(i);
            let first = pattern.first_slot(i);
            let (inverse, others) = blocks[first..][..row.len()]
                .split_last()
                .expect("a diagonal");
            let mut sum: Triple = r[i].map(|value| value as f32).into();
            for (block, &j) in others.iter().zip(row) {
                subtract_product(&mut sum, block, &x[j as usize]);
            }
            let mut solved = [0.0; 3];
            subtract_product(&mut solved, inverse, &sum.map(|value| -value));
            x[i] = solved;
            left[i] = [0.0; 3];
            for (block, &j) in others.iter().zip(row) {
                subtract_transposed_product(&mut left[j as usize], block, &solved);
            }
        }
    }

    /// Adds the coarse solution for `left` to x.
    fn correct(&mut self) {
        self.right_side.fill(Vector3::zeros());
        for (node, left) in self.left.iter().enumerate() {
            if !self.fixed[node] {
                let left = Vector3::from(left.map(f64::from));
                for (point, weight) in self.lattice.weights(node) {
                    self.right_side[point as usize] += left * weight;
                }
            }
        }
        self.factor.solve(&mut self.right_side);
        for (node, x) in self.x.iter_mut().enumerate() {
            if !self.fixed[node] {
                let parts = self.lattice.weights(node);
                let sum: Vector3<f64> = parts
                    .map(|(point, weight)| self.right_side[point as usize] * weight)
                    .sum();
                for (x, sum) in x.iter_mut().zip(&sum) {
                    *x += *sum as f32;
                }
            }
        }
    }

    /// Solves (D + Lᵀ) x' = r − L x; `left` takes −Lᵀ x'.
    fn sweep_backward(&mut self, r: &[Vector3<f64>]) {
        let Self {
            pattern,
            blocks,
            x,
            left,
            ..
        } = self;
        left.fill([0.0; 3]);
        for i in (0..x.len()).rev() {
            let row = pattern.row(i);
            let first = pattern.first_slot(i);
            let (inverse, others) = blocks[first..][..row.len()]
                .split_last()
                .expect("a diagonal");
            let mut sum: Triple = std::array::from_fn(|k| r[i][k] as f32 + left[i][k]);
            for (block, &j) in others.iter().zip(row) {
                subtract_product(&mut sum, block, &x[j as usize]);
            }
            let mut solved = [0.0; 3];
            subtract_product(&mut solved, inverse, &sum.map(|value| -value));
            x[i] = solved;
            for (block, &j) in others.iter().zip(row) {
                subtract_transposed_product(&mut left[j as usize], block, &solved);
            }
        }
    }

    /// Bytes of its numbers and places.
    pub fn bytes(&self) -> usize {
        let symbolic = self.factor.symbolic();
        8 * (symbolic.factor_entries() + symbolic.workspace_entries())
            + size_of_val(&*self.targets)
            + size_of_val(&*self.blocks)
            + size_of_val(self.coarse.values())
            + 2 * size_of_val(&*self.x)
            + self.lattice.bytes()
    }
}

impl Clone for TwoLevel {
    /// Places are shared. Numbers belong to one matrix, so they are not copied.
    fn clone(&self) -> Self {
        Self::with_places(
            self.pattern.clone(),
            self.lattice.clone(),
            self.targets.clone(),
            BlockMatrix::zeros(self.coarse.pattern().clone()),
            Factor::new(self.factor.symbolic().clone()),
        )
    }
}

#[inline(always)]
fn subtract_product(sum: &mut Triple, block: &[Triple; 3], x: &Triple) {
    for (sum, row) in sum.iter_mut().zip(block) {
        *sum -= row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
    }
}

#[inline(always)]
fn subtract_transposed_product(sum: &mut Triple, block: &[Triple; 3], x: &Triple) {
    for (k, sum) in sum.iter_mut().enumerate() {
        *sum -= block[0][k] * x[0] + block[1][k] * x[1] + block[2][k] * x[2];
    }
}

fn inverse(block: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let inverse = block.cholesky()?.inverse();
    inverse
        .iter()
        .all(|value| value.is_finite())
        .then_some(inverse)
}

/// All pairs of a point of node `i` and a point of node `j` ≤ `i`, with the product of their weights; for a node and itself each
/// pair once.
#[inline(always)]
fn for_pairs(lattice: &Lattice, i: usize, j: usize, mut each: impl FnMut(u32, u32, f64)) {
    for (index, (a, first)) in lattice.weights(i).enumerate() {
        let count = if i == j { index + 1 } else { usize::MAX };
        for (b, second) in lattice.weights(j).take(count) {
            each(a, b, first * second);
        }
    }
}

/// The points that fine blocks couple.
fn coarse_pattern(pattern: &Pattern, lattice: &Lattice) -> Pattern {
    let graph = pattern.graph();
    let mut nodes_of: Vec<Vec<u32>> = vec![Vec::new(); lattice.count()];
    for node in 0..pattern.nodes() {
        for (point, _) in lattice.weights(node) {
            nodes_of[point as usize].push(node as u32);
        }
    }
    // The last point, counted from 1, that each one was found to be coupled with.
    let mut found = vec![0_u32; lattice.count()];
    let row = |(point, nodes): (u32, &Vec<u32>)| {
        let mut row = Vec::new();
        for &node in nodes {
            let others = graph.neighbours(node).iter().copied();
            for other in others.chain([node]) {
                for (column, _) in lattice.weights(other as usize) {
                    if column <= point && found[column as usize] != point + 1 {
                        found[column as usize] = point + 1;
                        row.push(column);
                    }
                }
            }
        }
        row
    };
    Pattern::from_rows((0..).zip(&nodes_of).map(row).collect())
}

/// Where in the coarse matrix the parts of the fine blocks go, in the order of [`for_pairs`], and how.
fn targets(pattern: &Pattern, lattice: &Lattice, coarse: &Pattern) -> Vec<u32> {
    let count = lattice.count();
    let mut columns: Vec<Vec<(u32, u32)>> = vec![Vec::new(); count];
    for row in 0..count {
        for (slot, &column) in (coarse.first_slot(row) as u32..).zip(coarse.row(row)) {
            columns[row].push((column, slot));
            if column as usize != row {
                columns[column as usize].push((row as u32, slot));
            }
        }
    }
    // The slots of the points of the present node with every other point.
    let mut slots: [Vec<u32>; 4] = std::array::from_fn(|_| vec![0; count]);
    let mut targets = Vec::new();
    for i in 0..pattern.nodes() {
        for ((point, _), slots) in lattice.weights(i).zip(&mut slots) {
            for &(other, slot) in &columns[point as usize] {
                slots[other as usize] = slot;
            }
        }
        for &j in pattern.row(i) {
            let itself = i == j as usize;
            for ((index, (a, _)), slots) in lattice.weights(i).enumerate().zip(&slots) {
                let others = if itself { index + 1 } else { usize::MAX };
                for (b, _) in lattice.weights(j as usize).take(others) {
                    let how = match a.cmp(&b) {
                        std::cmp::Ordering::Greater => STRAIGHT,
                        std::cmp::Ordering::Less => TRANSPOSED,
                        std::cmp::Ordering::Equal if itself => STRAIGHT,
                        std::cmp::Ordering::Equal => BOTH,
                    };
                    targets.push(slots[b as usize] << 2 | how);
                }
            }
        }
    }
    targets
}

#[cfg(test)]
mod tests;
