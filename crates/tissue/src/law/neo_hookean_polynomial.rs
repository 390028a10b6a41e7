//! Neo-Hookean law without logarithm.

use super::decomposition::{SignedSvd, cofactor};
use super::invariants::{self, InvariantDerivatives};
use super::{IsotropicLaw, Lame, Law, LawName, Matrix9, PrincipalTangent};
use crate::lanes::Lanes;
use nalgebra::{Matrix3, Vector3};

/// Ψ = μ/2 (tr FᵀF − 3) − μ (J − 1) + (λ+μ)/2 (J − 1)², J = det F: the simplest form of Smith, de Goes, Kim 2018 (with
/// the constants of linear elasticity), and what XPBD of Macklin & Müller 2021 solves.
///
/// A polynomial: finite everywhere, the cheapest law, and inverted matter is pushed back. With the square completed it is
/// μ/2 tr FᵀF + (λ+μ)/2 (J − 1 − μ/(λ+μ))² up to a constant.
///
/// # Limitations
/// Collapse costs finite energy, and F = 0 is an equilibrium that attracts: a domain that is pressed into a point stays there
/// (the stable law of Smith, de Goes, Kim 2018 has a logarithm against it).
#[derive(Clone, Copy, Debug, Default)]
pub struct NeoHookeanPolynomial;

impl Law for NeoHookeanPolynomial {
    type Constants = Lame;
    type Parameters = ();
    const NAME: LawName = LawName::NeoHookeanPolynomial;
    const IS_SUM_OF_SQUARES: bool = true;

    fn constants(lame: &Lame, _parameters: &()) -> Lame {
        *lame
    }

    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64 {
        let growth = f.determinant() - 1.0;
        0.5 * lame.mu * (f.norm_squared() - 3.0) - lame.mu * growth
            + 0.5 * (lame.lambda + lame.mu) * growth * growth
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
        let (cofactor, j) = cofactor(f);
        let b1 = (lame.lambda + lame.mu) * (j - 1.0) - lame.mu;
        invariants::stress(f, &cofactor, 0.5 * lame.mu, b1)
    }

    #[inline(always)]
    fn slope_of_four(j: Lanes, lame: &Lame) -> Option<Lanes> {
        let of = Lanes::splat;
        Some(of(lame.lambda + lame.mu) * (j - of(1.0)) - of(lame.mu))
    }

    #[inline(always)]
    fn tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9 {
        let (cofactor, j) = cofactor(f);
        invariants::tangent(f, &cofactor, &derivatives(f.norm_squared(), j, lame))
    }

    fn positive_principal_tangent(f: &SignedSvd, lame: &Lame) -> PrincipalTangent {
        Self::principal_tangent(&f.stretches, lame).positive()
    }
}

impl IsotropicLaw for NeoHookeanPolynomial {
    fn principal_tangent(stretches: &Vector3<f64>, lame: &Lame) -> PrincipalTangent {
        let derivatives = derivatives(stretches.norm_squared(), stretches.product(), lame);
        invariants::principal_tangent(stretches, &derivatives)
    }
}

#[inline(always)]
fn derivatives(_i: f64, j: f64, lame: &Lame) -> InvariantDerivatives {
    InvariantDerivatives {
        a1: 0.5 * lame.mu,
        a2: 0.0,
        b1: (lame.lambda + lame.mu) * (j - 1.0) - lame.mu,
        b2: lame.lambda + lame.mu,
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn keeps_the_contract() {
        crate::law::contract::check_isotropic::<super::NeoHookeanPolynomial>();
    }
}
