//! Material laws of a continuum: energy density, stress, tangent as functions of the deformation gradient.
//!
//! A law is a type of its own with three functions that share one contract test: at rest no energy and no stress, stress =
//! gradient of energy, tangent = derivative of stress, no change under rotation, isotropy. Every law here is linear in the two
//! Lamé constants, so that the part of μ and the part of λ can be integrated over different domains, and is finite for every F,
//! inverted or collapsed, so that a solver can come back from there.

#[cfg(test)]
mod contract;
mod corotational;
pub mod decomposition;
mod invariants;
mod neo_hookean;
mod neo_hookean_polynomial;
mod principal;
mod st_venant_kirchhoff;
mod stable_neo_hookean;
pub mod viscosity;

pub use corotational::Corotational;
pub use microsim_vocabulary::LawName;
pub use neo_hookean::NeoHookean;
pub use neo_hookean_polynomial::NeoHookeanPolynomial;
pub use principal::PrincipalTangent;
pub use st_venant_kirchhoff::StVenantKirchhoff;
pub use stable_neo_hookean::StableNeoHookean;

use crate::elements::Lanes;
use decomposition::SignedSvd;
use nalgebra::{Matrix3, SMatrix, Vector3};
use std::fmt::Debug;

/// ∂P/∂F with matrices written column after column: entry (i + 3j, k + 3l) is ∂P_ij/∂F_kl.
pub type Matrix9 = SMatrix<f64, 9, 9>;

/// Lamé's constants of linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// Shear modulus μ \[Pa\].
    pub mu: f64,
    /// λ \[Pa\].
    pub lambda: f64,
}

impl Lame {
    /// From Young's modulus \[Pa\] and Poisson's ratio, both already checked.
    pub fn from_young_poisson(young: f64, poisson: f64) -> Self {
        Self {
            mu: young / (2.0 * (1.0 + poisson)),
            lambda: young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
        }
    }
}

/// A hyperelastic, isotropic material law.
pub trait Law: Copy + Default + Debug + Send + Sync + 'static {
    /// Its name in files and reports.
    const NAME: LawName;

    /// Whether Ψ = μ/2 tr FᵀF + (λ+μ)/2 (det F − 1 − μ/(λ+μ))² up to a constant, so that position-based methods can treat it
    /// as two constraints with compliance.
    const IS_SUM_OF_SQUARES: bool = false;

    /// Energy density Ψ(F) \[J/m³\], Ψ(1) = 0.
    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64;

    /// First Piola–Kirchhoff stress P = ∂Ψ/∂F \[Pa\].
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64>;

    /// b' \[Pa\] of four F at once from det F, for a law of the form Ψ = μ/2 tr FᵀF + b(det F) whose forces are to be computed by areas:
    /// half the arithmetic, other roundings.
    #[inline(always)]
    fn slope_of_four(_j: Lanes, _lame: &Lame) -> Option<Lanes> {
        None
    }

    /// ∂P/∂F \[Pa\].
    fn tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9;

    /// The nearest ∂P/∂F without negative eigenvalues \[Pa\] at a decomposed F.
    fn positive_tangent(f: &SignedSvd, lame: &Lame) -> Matrix9 {
        Self::principal_tangent(&f.stretches, lame)
            .positive()
            .rotated(f)
    }

    /// ∂P/∂F \[Pa\] at F = diag(`stretches`).
    fn principal_tangent(stretches: &Vector3<f64>, lame: &Lame) -> PrincipalTangent {
        PrincipalTangent::from_tangent(&Self::tangent(&Matrix3::from_diagonal(stretches), lame))
    }
}

/// Evaluates an expression with the type of a named law: `with_law!(name, L => Continuum::<L>::new(..))`.
macro_rules! with_law {
    ($name:expr, $law:ident => $body:expr) => {
        match $name {
            $crate::law::LawName::StVenantKirchhoff => {
                type $law = $crate::law::StVenantKirchhoff;
                $body
            }
            $crate::law::LawName::NeoHookean => {
                type $law = $crate::law::NeoHookean;
                $body
            }
            $crate::law::LawName::Corotational => {
                type $law = $crate::law::Corotational;
                $body
            }
            $crate::law::LawName::StableNeoHookean => {
                type $law = $crate::law::StableNeoHookean;
                $body
            }
            $crate::law::LawName::NeoHookeanPolynomial => {
                type $law = $crate::law::NeoHookeanPolynomial;
                $body
            }
        }
    };
}
pub(crate) use with_law;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_selects_the_law_that_has_it() {
        for law in LawName::ALL {
            assert_eq!(with_law!(law, L => L::NAME), law);
        }
    }

    #[test]
    fn moduli_are_those_of_linear_elasticity() {
        // E = μ (3λ + 2μ)/(λ + μ), ν = λ/(2 (λ + μ)).
        let Lame { mu, lambda } = Lame::from_young_poisson(3e4, 0.4);
        assert!((mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu) - 3e4).abs() < 1e-9);
        assert!((lambda / (2.0 * (lambda + mu)) - 0.4).abs() < 1e-15);
    }
}
