//! Nodes that respond to forces each by itself: a compliance per node, and a system of such nodes.

use crate::contact::Contact;
use crate::solver::{AddProduct, LinearSystem};
use microsim_sparse::NotPositive;
use nalgebra::{Matrix3, Vector3};

/// Least weight of the nodes of a contact that can move, relative to that of those that are prescribed: each the root of the sum of squares.
const LEAST_FREE_WEIGHT: f64 = 0.01;

/// Whether a contact lies on what is prescribed, by its weights and whether each of its nodes can move: less than a hundredth of the weight is on nodes that can. That,
/// often a rounding error, would have to move them more than a hundred times as far as the sides are to part.
pub(crate) fn is_held(weights: &[f64; 4], moves: [bool; 4]) -> bool {
    let [mut free, mut held] = [0.0; 2];
    for (weight, moves) in weights.iter().zip(moves) {
        *(if moves { &mut free } else { &mut held }) += weight * weight;
    }
    free < LEAST_FREE_WEIGHT * LEAST_FREE_WEIGHT * held
}

/// The response of each contact to its own force, from a compliance of each node: the diagonal of the Delassus operator, by parts.
#[derive(Clone, Debug, Default)]
pub struct NodalCompliance {
    pub(crate) rows: Vec<NodalRow>,
}

/// A contact with the compliances of its nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodalRow {
    /// Weight times compliance of each node \[m/N\].
    pub response: [f64; 4],
    /// How far the sides part for a force \[m/N\].
    pub compliance: f64,
}

impl NodalCompliance {
    /// Sets the response of these contacts; `compliance` is the displacement of a node per force \[m/N\], 0 for a prescribed one. Contacts on prescribed
    /// nodes move nothing.
    pub fn set(&mut self, contacts: &[Contact], compliance: impl Fn(usize) -> f64) {
        self.rows.clear();
        for contact in contacts {
            let compliances = contact.nodes.map(|node| compliance(node as usize));
            let mut row = NodalRow::INERT;
            if !is_held(&contact.weights, compliances.map(|c| c > 0.0)) {
                for ((response, compliance), weight) in row
                    .response
                    .iter_mut()
                    .zip(compliances)
                    .zip(contact.weights)
                {
                    *response = weight * compliance;
                    row.compliance += weight * *response;
                }
            }
            self.rows.push(row);
        }
    }
}

impl NodalRow {
    /// A contact that moves nothing.
    pub const INERT: Self = Self {
        response: [0.0; 4],
        compliance: 0.0,
    };

    /// Moves the nodes of its contact by a force.
    #[inline]
    pub fn shift(&self, contact: &Contact, force: &Vector3<f64>, values: &mut [Vector3<f64>]) {
        for (&node, response) in contact.nodes.iter().zip(self.response) {
            values[node as usize] += force * response;
        }
    }
}

/// A system of nodes that nothing couples, each with a stiffness of its own: for examples and tests of contact solvers.
#[derive(Clone, Debug)]
pub struct NodalSystem {
    blocks: Vec<Matrix3<f64>>,
}

impl NodalSystem {
    /// Nodes with these stiffnesses \[N/m\], 0 for a prescribed one.
    pub fn new(stiffnesses: Vec<f64>) -> Self {
        let blocks = stiffnesses.into_iter();
        Self {
            blocks: blocks.map(Matrix3::from_diagonal_element).collect(),
        }
    }

    fn solve_node(&self, node: usize, force: &Vector3<f64>) -> Option<Vector3<f64>> {
        self.blocks[node]
            .cholesky()
            .map(|factor| factor.solve(force))
    }
}

impl LinearSystem for NodalSystem {
    fn is_small(&self) -> bool {
        true
    }

    fn add_contact(&mut self, contact: &Contact, block: &Matrix3<f64>) -> bool {
        let used = contact.weights.iter().filter(|weight| **weight != 0.0);
        if used.count() != 1 {
            return false;
        }
        let weight = contact.weights[0];
        self.blocks[contact.nodes[0] as usize] += block * (weight * weight);
        true
    }

    /// None: they are not counted.
    fn operations(&self) -> f64 {
        0.0
    }

    fn multiply(&self, p: &[Vector3<f64>], q: &mut [Vector3<f64>]) {
        for ((q, p), block) in q.iter_mut().zip(p).zip(&self.blocks) {
            *q = block * p;
        }
    }

    fn solve(&mut self, x: &mut [Vector3<f64>], _tolerance: f64) -> Result<(), NotPositive> {
        for (node, x) in x.iter_mut().enumerate() {
            if self.blocks[node] != Matrix3::zeros() {
                *x = self.solve_node(node, x).ok_or(NotPositive { node })?;
            }
        }
        Ok(())
    }

    fn solve_with(
        &mut self,
        add: AddProduct<'_>,
        x: &mut [Vector3<f64>],
        tolerance: f64,
    ) -> Result<(), NotPositive> {
        // What is added is probed one component after another: nothing couples the nodes, nor may it.
        let mut with = self.clone();
        let mut product = vec![Vector3::zeros(); x.len()];
        for component in 0..3 {
            let probe = vec![Vector3::ith(component, 1.0); x.len()];
            product.fill(Vector3::zeros());
            add(&probe, &mut product);
            for (block, column) in with.blocks.iter_mut().zip(&product) {
                let sum = block.column(component) + column;
                block.set_column(component, &sum);
            }
        }
        with.solve(x, tolerance)
    }

    fn set_delassus(&mut self, rows: &[[(u32, Vector3<f64>); 4]], operator: &mut Vec<f64>) -> bool {
        operator.clear();
        for one in rows {
            for other in rows {
                let mut entry = 0.0;
                for (node, a) in one {
                    for (_, b) in other.iter().filter(|(other, _)| other == node) {
                        let response = self.solve_node(*node as usize, b);
                        entry += response.map_or(0.0, |motion| a.dot(&motion));
                    }
                }
                operator.push(entry);
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(weights: [f64; 4]) -> NodalRow {
        let contact = Contact {
            nodes: [0, 1, 2, 3],
            weights,
            ..Contact::of_node(0, Vector3::z(), 0.0)
        };
        let mut compliance = NodalCompliance::default();
        compliance.set(&[contact], |node| if node == 0 { 2.0 } else { 0.0 });
        compliance.rows[0]
    }

    /// The compliance is w² of the free node times its own; with less than a hundredth of the weight there is none.
    #[test]
    fn a_contact_on_what_is_prescribed_moves_nothing() {
        assert_eq!(row([0.5, 0.5, 0.0, 0.0]).compliance, 0.5);
        assert_eq!(
            row([0.015_625, 1.0, 0.0, 0.0]).response,
            [0.031_25, 0.0, 0.0, 0.0]
        );
        for weight in [0.007_812_5, 1e-17, 0.0] {
            let row = row([weight, 1.0, 0.0, 0.0]);
            assert_eq!((row.response, row.compliance), ([0.0; 4], 0.0));
        }
    }
}
