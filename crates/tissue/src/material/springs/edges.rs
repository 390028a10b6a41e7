//! The edges of tetrahedra.

use nalgebra::Vector3;

/// The six edges of a tetrahedron.
pub(super) fn edges(corners: &[Vector3<f64>; 4]) -> impl Iterator<Item = Vector3<f64>> + '_ {
    (0..4).flat_map(move |i| (0..i).map(move |j| corners[i] - corners[j]))
}
