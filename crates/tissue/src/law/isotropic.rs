//! Laws that have no direction of their own.

use super::definition::Law;
use super::principal::PrincipalTangent;
use nalgebra::{Matrix3, Vector3};

/// A law that has no direction of its own: Ψ(F Q) = Ψ(F) for every rotation Q. `impl IsotropicLaw for MyLaw {}` is enough.
pub trait IsotropicLaw: Law {
    /// Tangent ∂P/∂F \[Pa\] at F = diag(`stretches`), by default from [`Law::tangent`]; a closed form is faster.
    fn principal_tangent(
        stretches: &Vector3<f64>,
        constants: &Self::Constants,
    ) -> PrincipalTangent {
        let f = Matrix3::from_diagonal(stretches);
        PrincipalTangent::from_tangent(&Self::tangent(&f, constants))
    }
}
