//! Small operations on vectors of nodes, and the search along a direction.

use crate::contact::Contact;
use nalgebra::Vector3;

/// a·b.
#[inline]
pub(crate) fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

/// The norm of the forces at the nodes that are not fixed \[N\].
#[inline]
pub(crate) fn norm_of_free(forces: &[Vector3<f64>], fixed: &[bool]) -> f64 {
    let free = forces.iter().zip(fixed).filter(|(_, fixed)| !**fixed);
    free.map(|(f, _)| f.norm_squared()).sum::<f64>().sqrt()
}

/// Sets the entries of fixed nodes to zero.
pub(crate) fn clear_fixed(values: &mut [Vector3<f64>], fixed: &[bool]) {
    for (value, fixed) in values.iter_mut().zip(fixed) {
        if *fixed {
            *value = Vector3::zeros();
        }
    }
}

/// Adds a force on the first side, and its opposite on the other, to the nodes.
#[inline]
pub(crate) fn scatter(contact: &Contact, force: &Vector3<f64>, forces: &mut [Vector3<f64>]) {
    for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
        forces[node as usize] += force * weight;
    }
}

/// The step length in (0, 1] at which an energy that is convex along a direction is lowest, by its slope there and at the start: 1 where
/// it rises by at most `flat` of the slope at the start; else by so many `bisections`.
pub(crate) fn convex_search(
    start: f64,
    flat: f64,
    bisections: u32,
    slope_at: impl Fn(f64) -> f64,
) -> f64 {
    if slope_at(1.0) <= flat * start.abs() {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..bisections {
        let middle = 0.5 * (low + high);
        if slope_at(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}
