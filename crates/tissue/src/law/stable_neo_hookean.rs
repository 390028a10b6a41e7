//! Stable neo-Hookean law.

use super::decomposition::{SignedSvd, cofactor};
use super::invariants::{self, InvariantDerivatives};
use super::{IsotropicLaw, Lame, Law, LawName, Matrix9, PrincipalTangent};
use nalgebra::{Matrix3, Vector3};

/// Ψ = μ'/2 (I − 3) + λ'/2 (J − α)² − μ'/2 ln(I + 1) up to a constant, I = tr FᵀF, J = det F, α = 1 + 3μ'/(4λ') (Smith, de Goes,
/// Kim 2018), with μ' = 4μ/3 and λ' = λ + 5μ/6 so that small strains obey linear elasticity with μ and λ.
///
/// With the square multiplied out, λ'/2 (J − 1)² − 3μ'/4 (J − 1), nothing is divided by λ' and the law is linear in both
/// constants. Finite everywhere; the logarithm keeps F = 0 from being an equilibrium that holds: inverted and collapsed matter
/// is pushed back.
#[derive(Clone, Copy, Debug, Default)]
pub struct StableNeoHookean;

/// μ' and λ' \[Pa\].
#[inline]
fn own_constants(lame: &Lame) -> (f64, f64) {
    (4.0 / 3.0 * lame.mu, lame.lambda + 5.0 / 6.0 * lame.mu)
}

impl Law for StableNeoHookean {
    type Constants = Lame;
    type Parameters = ();
    const NAME: LawName = LawName::StableNeoHookean;

    fn constants(lame: &Lame, _parameters: &()) -> Lame {
        *lame
    }

    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64 {
        let (mu, lambda) = own_constants(lame);
        let (i, growth) = (f.norm_squared(), f.determinant() - 1.0);
        0.5 * mu * (i - 3.0 - libm::log(0.25 * (i + 1.0))) - 0.75 * mu * growth
            + 0.5 * lambda * growth * growth
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
        let (mu, lambda) = own_constants(lame);
        let (cofactor, j) = cofactor(f);
        let a1 = 0.5 * mu * (1.0 - 1.0 / (f.norm_squared() + 1.0));
        invariants::stress(f, &cofactor, a1, lambda * (j - 1.0) - 0.75 * mu)
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

impl IsotropicLaw for StableNeoHookean {
    fn principal_tangent(stretches: &Vector3<f64>, lame: &Lame) -> PrincipalTangent {
        let derivatives = derivatives(stretches.norm_squared(), stretches.product(), lame);
        invariants::principal_tangent(stretches, &derivatives)
    }
}

#[inline(always)]
fn derivatives(i: f64, j: f64, lame: &Lame) -> InvariantDerivatives {
    let (mu, lambda) = own_constants(lame);
    let inverse = 1.0 / (i + 1.0);
    InvariantDerivatives {
        a1: 0.5 * mu * (1.0 - inverse),
        a2: 0.5 * mu * inverse * inverse,
        b1: lambda * (j - 1.0) - 0.75 * mu,
        b2: lambda,
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn keeps_the_contract() {
        crate::law::contract::check_isotropic::<super::StableNeoHookean>();
    }
}
