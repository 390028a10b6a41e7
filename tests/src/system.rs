//! The linear system of a body, phase by phase: what measurements need and solvers keep to themselves.

use microsim_sparse::{BlockMatrix, LinearSolver, Ordering, Pattern, Symbolic};
use microsim_tissue::elements::{MatrixWindow, Slots, Tangent};
use microsim_tissue::{State, TissueModel};
use std::sync::Arc;

/// The stiffness of a model and the solver of its systems.
#[derive(Debug)]
pub struct System {
    /// The stiffness that was assembled last.
    pub matrix: BlockMatrix,
    /// The linear solver that the pattern chooses.
    pub solver: LinearSolver,
    /// Where each set of elements adds its blocks.
    slots: Vec<Slots>,
}

impl System {
    /// Pattern and analysis of `model`.
    ///
    /// # Panics
    /// Never for a model that was built: the nodes of its elements are coupled.
    pub fn new(model: &TissueModel) -> Self {
        let sets = model.sets().iter().map(|set| &**set);
        let (pattern, slots) = Slots::of_sets(model.node_count(), sets);
        Self {
            slots,
            solver: LinearSolver::new(&pattern, model.rest_positions()),
            matrix: BlockMatrix::zeros(pattern),
        }
    }

    /// Assembles the stiffness at `state`.
    pub fn assemble(&mut self, model: &TissueModel, state: &State, tangent: Tangent) {
        self.matrix.clear();
        for (index, (set, slots)) in model.sets().iter().zip(&self.slots).enumerate() {
            let mut window = MatrixWindow {
                slots,
                values: self.matrix.values_mut(),
            };
            let at = state.configuration(model, index);
            set.add_tangent(&at, tangent, 0.0, &mut window);
        }
    }

    /// Bytes of what solves, of the matrix and of the places of its blocks.
    pub fn bytes(&self, model: &TissueModel) -> usize {
        let places: usize = model
            .sets()
            .iter()
            .flat_map(|set| (0..set.count()).map(|element| set.nodes(element).len()))
            .map(|nodes| 4 * (nodes * (nodes + 1) / 2 + 1))
            .sum();
        self.solver.bytes() + size_of_val(self.matrix.values()) + places
    }
}

/// The analysis of a factor on `pattern`.
pub fn analyse(model: &TissueModel, pattern: &Arc<Pattern>) -> Arc<Symbolic> {
    let ordering = Ordering::nested_dissection(pattern, Some(model.rest_positions()));
    Arc::new(Symbolic::analyse(pattern, &ordering))
}
