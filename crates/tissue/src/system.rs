//! The linear systems of implicit methods: K + b·D + c·M of a model, assembled, factored, solved.
//!
//! Where the blocks of each element go is found once per model; a step only adds numbers, in a fixed order, and gives
//! [`LinearSolver`] the prescribed nodes. No number is retained from one system to the next.

use crate::elements::{MatrixWindow, Slots, Tangent};
use crate::model::TissueModel;
use crate::state::{Control, PressedTriangle, State};
use microsim_contact_solver::{AddProduct, Contact, LinearSystem};
use microsim_sparse::{BlockMatrix, LinearSolver, NotPositive, Pattern};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The coefficients of a matrix K + b·D + r (r + c) M, c the drag per mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MatrixCoefficients {
    /// b \[1/s\].
    pub damping: f64,
    /// r \[1/s\].
    pub rate: f64,
}

/// A linear system with the pattern of one model.
#[derive(Clone, Debug)]
pub(crate) struct System {
    /// Of each set.
    slots: Arc<[Slots]>,
    matrix: BlockMatrix,
    solver: LinearSolver,
}

impl System {
    /// The system of `model`.
    pub fn new(model: &TissueModel) -> Self {
        Self::with(model, LinearSolver::new)
    }

    /// That of the same body after an edit.
    pub fn following(&self, model: &TissueModel) -> Self {
        Self::with(model, |pattern, positions| {
            self.solver.following(pattern, positions)
        })
    }

    fn with(
        model: &TissueModel,
        solver: impl Fn(&Arc<Pattern>, &[Vector3<f64>]) -> LinearSolver,
    ) -> Self {
        let sets = model.sets().iter().map(|set| &**set);
        let (pattern, slots) = Slots::of_sets(model.node_count(), sets);
        Self {
            slots: slots.into(),
            solver: solver(&pattern, model.rest_positions()),
            matrix: BlockMatrix::zeros(pattern),
        }
    }

    /// Sets the matrix to K + b·D + r (r + c) M of the elements at the positions and velocities of `state`.
    pub fn assemble(
        &mut self,
        model: &TissueModel,
        state: &State,
        coefficients: MatrixCoefficients,
        tangent: Tangent,
    ) {
        self.matrix.clear();
        let values = self.matrix.values_mut();
        for (index, (set, slots)) in model.sets().iter().zip(&*self.slots).enumerate() {
            let at = state.configuration(model, index);
            let mut window = MatrixWindow { slots, values };
            set.add_tangent(&at, tangent, coefficients.damping, &mut window);
        }
        if coefficients.rate > 0.0 {
            for (nodes, drag) in model.drags() {
                let factor = coefficients.rate * (coefficients.rate + drag);
                for node in nodes.clone() {
                    let block = Matrix3::from_diagonal_element(factor * model.inertia(node));
                    self.matrix.add_diagonal(node, &block);
                }
            }
        }
    }

    /// Adds the symmetric part of minus the derivative of pressures that follow their surfaces. Over a closed surface, or one with
    /// a prescribed rim, the other part sums to zero. Triangles whose corners no element couples are left out.
    pub fn add_pressures(&mut self, control: &Control, positions: &[Vector3<f64>]) {
        for PressedTriangle { nodes, pressure } in control.pressed_triangles() {
            // Each corner has the force −p/6 n with n the double area vector, ∂n/∂x_j = [e_j]× of the edge across from j.
            let [a, b, c] = nodes.map(|node| positions[node as usize]);
            let edges = [c - b, a - c, b - a];
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let (i, j) = if nodes[i] >= nodes[j] { (i, j) } else { (j, i) };
                let [row, column] = [i, j].map(|corner| nodes[corner] as usize);
                if let Some(slot) = self.matrix.pattern().slot(row, column) {
                    let block = (edges[j] - edges[i]).cross_matrix() * (pressure / 12.0);
                    self.matrix.add_slot(slot, &block);
                }
            }
        }
    }

    /// Adds this much to the diagonal of a node \[N/m\].
    pub fn add_diagonal(&mut self, node: usize, stiffness: f64) {
        let block = Matrix3::from_diagonal_element(stiffness);
        self.matrix.add_diagonal(node, &block);
    }

    /// See [`LinearSolver::take_operations`].
    pub fn take_operations(&mut self) -> f64 {
        self.solver.take_operations()
    }

    /// See [`LinearSolver::factor_operations`].
    pub fn factor_operations(&self) -> f64 {
        self.solver.factor_operations(self.matrix.pattern())
    }

    /// See [`LinearSolver::compliance_operations`].
    pub fn delassus_operations(&self, rows: usize) -> f64 {
        self.solver.compliance_operations(rows)
    }

    /// The assembled matrix.
    pub fn matrix(&self) -> &BlockMatrix {
        &self.matrix
    }

    /// Prepares solutions with the assembled matrix, with rows and columns of the nodes marked in `fixed` those of the identity.
    pub fn factorise(&mut self, fixed: &[bool]) -> Result<(), NotPositive> {
        self.solver.factorise(&self.matrix, fixed)
    }

    /// As [`factorise`](Self::factorise), with an f64 Cholesky factor.
    pub fn factorise_f64(&mut self, fixed: &[bool]) -> Result<(), NotPositive> {
        self.solver.factorise_f64(&self.matrix, fixed)
    }
}

impl LinearSystem for System {
    fn is_small(&self) -> bool {
        self.solver.is_small()
    }

    fn add_contact(&mut self, contact: &Contact, block: &Matrix3<f64>) -> bool {
        let first = usize::from(contact.first);
        let mut places = [(0, 0.0); 12];
        let mut count = 0;
        for side in [0..first, first..4] {
            for i in side.clone().filter(|&i| contact.weights[i] != 0.0) {
                for j in side.start..=i {
                    let nodes = [contact.nodes[i] as usize, contact.nodes[j] as usize];
                    if contact.weights[j] == 0.0 {
                        continue;
                    }
                    let (row, column) = (nodes[0].max(nodes[1]), nodes[0].min(nodes[1]));
                    let Some(slot) = self.matrix.pattern().slot(row, column) else {
                        return false;
                    };
                    places[count] = (slot, contact.weights[i] * contact.weights[j]);
                    count += 1;
                }
            }
        }
        // A block of a contact is symmetric.
        for (slot, weight) in &places[..count] {
            self.matrix.add_slot(*slot, &(block * *weight));
        }
        true
    }

    fn operations(&self) -> f64 {
        self.solver.operations()
    }

    fn multiply(&self, p: &[Vector3<f64>], q: &mut [Vector3<f64>]) {
        self.matrix.multiply(p, q);
    }

    fn solve(&mut self, x: &mut [Vector3<f64>], tolerance: f64) -> Result<(), NotPositive> {
        self.solver.solve(&self.matrix, x, tolerance)
    }

    fn solve_with(
        &mut self,
        add: AddProduct<'_>,
        x: &mut [Vector3<f64>],
        tolerance: f64,
    ) -> Result<(), NotPositive> {
        self.solver.solve_with(&self.matrix, add, x, tolerance)
    }

    fn set_delassus(&mut self, rows: &[[(u32, Vector3<f64>); 4]], operator: &mut Vec<f64>) -> bool {
        self.solver.set_compliance(rows, operator)
    }
}
