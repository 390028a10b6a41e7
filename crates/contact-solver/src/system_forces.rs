//! Products with the matrix and with the contacts that are, or are not, in it.

use crate::contact::Contact;
use crate::row::Row;
use crate::solver::LinearSystem;
use crate::vectors::scatter;
use nalgebra::{Matrix3, Vector3};

/// q = (matrix without contacts) p.
pub(crate) fn multiply_without_contacts(
    system: &dyn LinearSystem,
    contacts: &[Contact],
    rows: &[Row],
    p: &[Vector3<f64>],
    q: &mut [Vector3<f64>],
) {
    system.multiply(p, q);
    for (contact, row) in contacts.iter().zip(rows) {
        if let Some(factored) = &row.factored {
            subtract(contact, factored, p, q);
        }
    }
}

/// Adds to q the curvature of the contacts now, less what of it is in the matrix, times p.
pub(crate) fn add_contacts(
    contacts: &[Contact],
    rows: &[Row],
    p: &[Vector3<f64>],
    q: &mut [Vector3<f64>],
) {
    for (contact, row) in contacts.iter().zip(rows) {
        if row.penalty > 0.0 {
            scatter(contact, &(row.hessian * contact.interpolate(p)), q);
            if let Some(factored) = &row.factored {
                subtract(contact, factored, p, q);
            }
        }
    }
}

/// Adds the forces of contacts after the displacement `direction` to those of the nodes \[N\], and sets their curvatures; returns their
/// norm \[N\].
pub(crate) fn add_forces_along(
    contacts: &[Contact],
    rows: &mut [Row],
    direction: &[Vector3<f64>],
    forces: &mut [Vector3<f64>],
) -> f64 {
    let mut pushed = 0.0;
    for (contact, row) in contacts.iter().zip(rows) {
        if row.penalty > 0.0 {
            let y = contact.interpolate(direction);
            let force = row.force_at(contact, &y);
            row.hessian = row.curvature(contact, &y);
            pushed += force.norm_squared();
            scatter(contact, &force, forces);
        }
    }
    pushed.sqrt()
}

/// Subtracts what of a contact is in the matrix, times p, from q: the blocks of each side with itself.
fn subtract(
    contact: &Contact,
    factored: &Matrix3<f64>,
    p: &[Vector3<f64>],
    q: &mut [Vector3<f64>],
) {
    let first = usize::from(contact.first);
    for side in [0..first, first..4] {
        let mut sum = Vector3::zeros();
        for k in side.clone() {
            sum += p[contact.nodes[k] as usize] * contact.weights[k];
        }
        let force = factored * sum;
        for k in side {
            q[contact.nodes[k] as usize] -= force * contact.weights[k];
        }
    }
}
