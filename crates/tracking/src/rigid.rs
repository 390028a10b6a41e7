//! The rotation that takes one set of points closest to another.

use nalgebra::{Matrix3, Vector3};

/// A rotation with what it was found from.
pub(crate) struct Alignment {
    /// `to_from_from`.
    pub rotation: Matrix3<f64>,
    /// Singular values of Σ to fromᵀ, largest first, the last with the sign of the determinant.
    pub values: [f64; 3],
}

/// The rotation R that minimises Σ|R from − to|² over centred points, from Σ to fromᵀ (Arun et al. 1987, with the sign of Umeyama 1991: never a mirror image);
/// `None` of what is not finite.
pub(crate) fn align(products: Matrix3<f64>) -> Option<Alignment> {
    if !products.iter().all(|x| x.is_finite()) {
        return None;
    }
    let decomposed = products.svd(true, true);
    let (u, v_t) = (decomposed.u?, decomposed.v_t?);
    let values = decomposed.singular_values;
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let sign = (u * v_t).determinant().signum();
    let mut signs = Vector3::repeat(1.0);
    signs[order[2]] = sign;
    Some(Alignment {
        rotation: u * Matrix3::from_diagonal(&signs) * v_t,
        values: order.map(|axis| values[axis] * signs[axis]),
    })
}
