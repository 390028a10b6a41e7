//! The sums of the rows of stiffness and damping at rest, updated by edits.

use super::TissueModel;
use crate::elements::{Configuration, ElementMatrix, set_norms};

/// The sums of the row of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RowSums {
    /// Of the stiffness, S_i \[N/m\].
    pub stiffness: f64,
    /// Of the damping, D_i \[N·s/m\].
    pub damping: f64,
}

impl TissueModel {
    /// Those of every node at rest, without plastic flow: as [`gershgorin_bound`](crate::stability::gershgorin_bound) sums them. After edits
    /// they are right to the rounding of what has ever been in the sum.
    pub(crate) fn row_sums(&self) -> &[RowSums] {
        self.row_sums.get_or_init(|| {
            let mut sums = vec![RowSums::default(); self.node_count()];
            for (set, elements) in self.sets().iter().enumerate() {
                let all = 0..elements.count() as u32;
                self.add_rows(set, all, 1.0, &mut sums);
            }
            sums
        })
    }

    /// Adds the rows of elements, times a factor, to the sums.
    pub(crate) fn add_rows(
        &self,
        set: usize,
        elements: impl IntoIterator<Item = u32>,
        factor: f64,
        sums: &mut [RowSums],
    ) {
        let (w, set) = (self.inverse_masses(), &self.sets()[set]);
        let mut norms = Vec::new();
        let (mut matrix, mut damping) = (ElementMatrix::new(), Vec::new());
        let at_rest = Configuration {
            positions: self.rest_positions(),
            velocities: self.rest_positions(),
            internal: &[],
        };
        for element in elements {
            let element = element as usize;
            set.rest_norms(element, self.rest_positions(), &mut norms);
            let relaxation_time = set.relaxation_time(element);
            let nodes = set.nodes(element);
            let free_sum = |norms: &[f64]| -> f64 {
                let free = nodes
                    .iter()
                    .zip(norms)
                    .filter(|(column, _)| w[**column as usize] > 0.0);
                free.map(|(_, norm)| norm).sum()
            };
            // In its natural state the damping of an element is its stiffness times the relaxation time; stretched it is not.
            let stretched =
                relaxation_time > 0.0 && !set.is_natural(element, self.rest_positions());
            if stretched {
                set.damping(element, &at_rest, &mut matrix);
                set_norms(&matrix, &mut damping);
            }
            let rows = (0..).step_by(nodes.len()).map(|at| at..at + nodes.len());
            for (&row, columns) in nodes.iter().zip(rows) {
                let sum = free_sum(&norms[columns.clone()]);
                let damping = match stretched {
                    true => free_sum(&damping[columns]),
                    false => relaxation_time * sum,
                };
                let sums = &mut sums[row as usize];
                sums.stiffness += factor * sum;
                sums.damping += factor * damping;
            }
        }
    }
}
