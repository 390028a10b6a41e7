//! A symmetric matrix of 3×3 blocks on a [`Pattern`]: assembly and product.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::Pattern;

/// Symmetric block matrix; the lower triangle is stored, the upper one is its transpose.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    pattern: Arc<Pattern>,
    values: Vec<Matrix3<f64>>,
}

impl BlockMatrix {
    /// The zero matrix.
    pub fn zeros(pattern: Arc<Pattern>) -> Self {
        let values = vec![Matrix3::zeros(); pattern.blocks()];
        Self { pattern, values }
    }

    /// Where the blocks are.
    pub fn pattern(&self) -> &Arc<Pattern> {
        &self.pattern
    }

    /// The blocks by slot.
    pub fn values(&self) -> &[Matrix3<f64>] {
        &self.values
    }

    /// The blocks by slot, for assembly loops that know their slots. Diagonal blocks must stay symmetric.
    pub fn values_mut(&mut self) -> &mut [Matrix3<f64>] {
        &mut self.values
    }

    /// Sets every block to zero.
    pub fn clear(&mut self) {
        self.values.fill(Matrix3::zeros());
    }

    /// Adds `block` at `slot`.
    pub fn add_slot(&mut self, slot: usize, block: &Matrix3<f64>) {
        self.values[slot] += block;
    }

    /// Adds `block` in row `i`, column `j`; for i < j its transpose in row `j`, column `i`. Of the two off-diagonal
    /// blocks of an element matrix give one, not both.
    ///
    /// # Panics
    /// When the pattern does not couple `i` and `j`.
    pub fn add(&mut self, i: usize, j: usize, block: &Matrix3<f64>) {
        let slot = self.pattern.slot(i.max(j), i.min(j)).expect("the pattern couples the two nodes");
        if i >= j {
            self.values[slot] += block;
        } else {
            self.values[slot] += block.transpose();
        }
    }

    /// Adds `block` to the diagonal block of node `i`.
    pub fn add_diagonal(&mut self, i: usize, block: &Matrix3<f64>) {
        self.values[self.pattern.diagonal_slot(i)] += block;
    }

    /// The diagonal block of node `i`.
    pub fn diagonal(&self, i: usize) -> &Matrix3<f64> {
        &self.values[self.pattern.diagonal_slot(i)]
    }

    /// y = A x.
    ///
    /// # Panics
    /// When `x` or `y` does not have one entry per node.
    pub fn multiply(&self, x: &[Vector3<f64>], y: &mut [Vector3<f64>]) {
        let nodes = self.pattern.nodes();
        assert_eq!((x.len(), y.len()), (nodes, nodes), "one vector per node");
        y.fill(Vector3::zeros());
        for i in 0..nodes {
            let row = self.pattern.row(i);
            let blocks = &self.values[self.pattern.first_slot(i)..][..row.len()];
            let (diagonal, others) = blocks.split_last().expect("every row has its diagonal");
            let mut sum = diagonal * x[i];
            for (&j, block) in row.iter().zip(others) {
                sum += block * x[j as usize];
                y[j as usize] += block.tr_mul(&x[i]);
            }
            y[i] += sum;
        }
    }

    /// Gives the rows and columns of the nodes marked in `fixed` the identity and no coupling, so that the solution at
    /// a fixed node is its right-hand side.
    ///
    /// # Panics
    /// When `fixed` does not have one entry per node.
    pub fn constrain(&mut self, fixed: &[bool]) {
        assert_eq!(fixed.len(), self.pattern.nodes(), "one mark per node");
        for i in 0..fixed.len() {
            for (k, &j) in self.pattern.row(i).iter().enumerate() {
                if fixed[i] || fixed[j as usize] {
                    self.values[self.pattern.first_slot(i) + k] =
                        if j as usize == i { Matrix3::identity() } else { Matrix3::zeros() };
                }
            }
        }
    }
}
