//! Stiffness or damping of a body as one sparse matrix of 3×3 blocks.

use super::Part;
use crate::gershgorin::each_matrix;
use crate::model::TissueModel;
use crate::state::State;
use microsim_random::Congruential;
use nalgebra::{Matrix3, Vector3};

/// Rows of blocks, columns ascending (compressed sparse rows): some 15 blocks per node, not 16 per tetrahedron.
pub(super) struct BlockMatrix {
    /// Where the blocks of each row start, and the end.
    starts: Vec<usize>,
    columns: Vec<u32>,
    blocks: Vec<Matrix3<f64>>,
}

impl BlockMatrix {
    /// The matrix of `model` in `state`.
    pub(super) fn new(model: &TissueModel, state: &State, part: Part) -> Self {
        let (starts, columns) = pattern(model);
        let mut matrix = Self {
            blocks: vec![Matrix3::zeros(); columns.len()],
            starts,
            columns,
        };
        each_matrix(model, state, part, |nodes, element| {
            for (i, &row) in nodes.iter().enumerate() {
                let start = matrix.starts[row as usize];
                let columns = &matrix.columns[start..matrix.starts[row as usize + 1]];
                for (j, &column) in nodes.iter().enumerate() {
                    // Every pair of nodes of an element is in the pattern.
                    if let Ok(place) = columns.binary_search(&column) {
                        matrix.blocks[start + place] += element.block(i, j);
                    }
                }
            }
        });
        matrix
    }

    /// The eigenvalue of largest size of W·A, `w` the diagonal of W, as a size, by `steps` steps of power iteration.
    pub(super) fn largest_eigenvalue(&self, w: &[f64], steps: usize) -> f64 {
        // Fixed numbers without symmetry, so that no eigenvector is missed.
        let mut random = Congruential(1);
        let start = |&w: &f64| {
            let direction = random.vector();
            if w > 0.0 { direction } else { Vector3::zeros() }
        };
        let mut x: Vec<Vector3<f64>> = w.iter().map(start).collect();
        let mut y = x.clone();
        let mut lambda = 0.0;
        for _ in 0..steps {
            // y = A x, then x = W y, scaled. The estimate is the growth of x in the norm of W⁻¹: from below like the Rayleigh
            // quotient, but two eigenvalues of opposite sign do not cancel in it.
            self.multiply(&x, &mut y);
            let (mut yy, mut xx, mut size) = (0.0, 0.0, 0.0f64);
            for ((x, y), &w) in x.iter_mut().zip(&y).zip(w) {
                if w > 0.0 {
                    yy += y.norm_squared() * w;
                    xx += x.norm_squared() / w;
                }
                *x = y * w;
                size = size.max(x.amax());
            }
            if xx == 0.0 || size == 0.0 {
                return 0.0;
            }
            lambda = f64::sqrt(yy / xx);
            x.iter_mut().for_each(|v| *v /= size);
        }
        lambda
    }

    fn multiply(&self, x: &[Vector3<f64>], y: &mut [Vector3<f64>]) {
        for (row, y) in self.starts.windows(2).zip(y) {
            let mut sum = Vector3::zeros();
            let blocks = &self.blocks[row[0]..row[1]];
            for (column, block) in self.columns[row[0]..row[1]].iter().zip(blocks) {
                sum += block * x[*column as usize];
            }
            *y = sum;
        }
    }
}

/// Starts of rows and ascending columns of all pairs of nodes of a common element.
fn pattern(model: &TissueModel) -> (Vec<usize>, Vec<u32>) {
    let n = model.node_count();
    // Sorted per row, and freed of copies whenever a row has doubled: memory follows the pattern, not the elements.
    let mut rows: Vec<(Vec<u32>, usize)> = vec![(Vec::new(), 32); n];
    for set in model.sets() {
        for element in 0..set.count() {
            let nodes = set.nodes(element);
            for &row in nodes {
                let (columns, bound) = &mut rows[row as usize];
                columns.extend_from_slice(nodes);
                if columns.len() >= *bound {
                    columns.sort_unstable();
                    columns.dedup();
                    *bound = 2 * columns.len().max(16);
                }
            }
        }
    }
    let mut starts = Vec::with_capacity(n + 1);
    let mut all = Vec::new();
    for (mut columns, _) in rows {
        columns.sort_unstable();
        columns.dedup();
        starts.push(all.len());
        all.extend(columns);
    }
    starts.push(all.len());
    (starts, all)
}
