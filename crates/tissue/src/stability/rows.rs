//! The sums S_i of the rows of the stiffness at rest, kept up to date by edits.

use crate::model::TissueModel;

impl TissueModel {
    /// S_i of every node at rest [N/m], without plastic flow: as [`gershgorin_bound`](super::gershgorin_bound) sums it. After edits
    /// they are right to the rounding of what has ever been in the sum.
    pub(crate) fn row_sums(&self) -> &[f64] {
        self.row_sums.get_or_init(|| {
            let mut sums = vec![0.0; self.node_count()];
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
        sums: &mut [f64],
    ) {
        let (w, set) = (self.inverse_masses(), &self.sets()[set]);
        let mut norms = Vec::new();
        for element in elements {
            let element = element as usize;
            set.rest_norms(element, self.rest_positions(), &mut norms);
            let nodes = set.nodes(element);
            for (&row, norms) in nodes.iter().zip(norms.chunks_exact(nodes.len())) {
                let free = nodes
                    .iter()
                    .zip(norms)
                    .filter(|(column, _)| w[**column as usize] > 0.0);
                let sum: f64 = free.map(|(_, norm)| norm).sum();
                sums[row as usize] += factor * sum;
            }
        }
    }
}
