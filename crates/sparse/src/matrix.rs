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
        let slot = self
            .pattern
            .slot(i.max(j), i.min(j))
            .expect("the pattern couples the two nodes");
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
    #[cfg(test)]
    pub(crate) fn constrain(&mut self, fixed: &[bool]) {
        assert_eq!(fixed.len(), self.pattern.nodes(), "one mark per node");
        for i in 0..fixed.len() {
            for (k, &j) in self.pattern.row(i).iter().enumerate() {
                if fixed[i] || fixed[j as usize] {
                    self.values[self.pattern.first_slot(i) + k] = if j as usize == i {
                        Matrix3::identity()
                    } else {
                        Matrix3::zeros()
                    };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{dense, dense_vector, random_matrix, vectors};
    use microsim_random::Congruential;

    #[test]
    fn product_is_that_of_the_dense_matrix() {
        let mut random = Congruential(1);
        for nodes in [1, 2, 7, 30] {
            let matrix = random_matrix(&mut random, nodes, 2 * nodes, 0.5);
            let x = vectors(&mut random, nodes);
            let mut y = vectors(&mut random, nodes);
            matrix.multiply(&x, &mut y);
            let dense = dense(&matrix);
            assert_eq!(dense, dense.transpose());
            let expected = &dense * dense_vector(&x);
            // Both sum at most 3n products of a row, each rounding by ε of the sum of magnitudes: γ_3n twice.
            let bound =
                dense.abs() * dense_vector(&x).abs() * (2.0 * 3.0 * nodes as f64 * f64::EPSILON);
            assert!(
                (dense_vector(&y) - expected)
                    .abs()
                    .iter()
                    .zip(bound.iter())
                    .all(|(error, bound)| error <= bound)
            );
        }
    }

    #[test]
    fn blocks_land_where_they_belong() {
        let mut matrix = BlockMatrix::zeros(Arc::new(Pattern::from_cliques(3, [[0, 2]])));
        let block = Matrix3::from_fn(|r, c| (3 * r + c) as f64);
        matrix.add(2, 0, &block);
        matrix.add(0, 2, &block);
        matrix.add_slot(matrix.pattern().slot(2, 0).unwrap(), &Matrix3::identity());
        matrix.add_diagonal(1, &Matrix3::identity());
        assert_eq!(
            matrix.values()[2],
            block + block.transpose() + Matrix3::identity()
        );
        assert_eq!(*matrix.diagonal(1), Matrix3::identity());
        assert_eq!(*matrix.diagonal(2), Matrix3::zeros());
        matrix.clear();
        assert!(
            matrix
                .values()
                .iter()
                .all(|block| *block == Matrix3::zeros())
        );
    }

    #[test]
    #[should_panic(expected = "couples")]
    fn a_block_beyond_the_pattern_is_a_bug() {
        let mut matrix = BlockMatrix::zeros(Arc::new(Pattern::from_cliques(3, [[0, 2]])));
        matrix.add(1, 0, &Matrix3::identity());
    }

    #[test]
    fn constrained_nodes_are_cut_off() {
        let mut random = Congruential(2);
        let mut matrix = random_matrix(&mut random, 6, 20, 0.5);
        let mut expected = dense(&matrix);
        for node in [1, 4] {
            for a in 3 * node..3 * node + 3 {
                expected.row_mut(a).fill(0.0);
                expected.column_mut(a).fill(0.0);
                expected[(a, a)] = 1.0;
            }
        }
        matrix.constrain(&[false, true, false, false, true, false]);
        assert_eq!(dense(&matrix), expected);
    }
}
