//! The contacts of a reduced problem: one direction along the normal of each, two more across it where there is friction.

use crate::contact::Contact;
use nalgebra::{Matrix3, Vector3};

/// A row of J: how the nodes of a contact take part in its motion along a direction.
pub(crate) type Row = [(u32, Vector3<f64>); 4];

/// A contact of a reduced problem.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member {
    /// Its place among all contacts.
    pub contact: usize,
    /// Its first direction, and how many there are.
    pub first: usize,
    pub count: usize,
    /// The unit vectors of its directions.
    pub frame: Matrix3<f64>,
}

impl Member {
    /// The contact at `index`, with its directions added to `rows`.
    pub fn new(index: usize, contact: &Contact, rows: &mut Vec<Row>) -> Self {
        Self::with_count(index, contact, directions(contact), rows)
    }

    /// One that takes part only along its normal.
    pub fn along_normal(index: usize, contact: &Contact, rows: &mut Vec<Row>) -> Self {
        Self::with_count(index, contact, 1, rows)
    }

    fn with_count(index: usize, contact: &Contact, count: usize, rows: &mut Vec<Row>) -> Self {
        let member = Self {
            contact: index,
            first: rows.len(),
            count,
            frame: frame(contact),
        };
        for k in 0..member.count {
            rows.push(row(contact, &member.frame, k));
        }
        member
    }

    /// The vector with these components along the directions.
    #[inline]
    pub fn vector(&self, components: &[f64]) -> Vector3<f64> {
        let mut vector = Vector3::zeros();
        for k in 0..self.count {
            vector += self.frame.column(k) * components[self.first + k];
        }
        vector
    }
}

/// How many directions a contact has.
pub(crate) fn directions(contact: &Contact) -> usize {
    if contact.friction > 0.0 { 3 } else { 1 }
}

/// The normal, and two directions across it.
fn frame(contact: &Contact) -> Matrix3<f64> {
    let n = contact.normal;
    let across = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
    Matrix3::from_columns(&[n, across, n.cross(&across)])
}

fn row(contact: &Contact, frame: &Matrix3<f64>, k: usize) -> Row {
    std::array::from_fn(|i| (contact.nodes[i], frame.column(k) * contact.weights[i]))
}
