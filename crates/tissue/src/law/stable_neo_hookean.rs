//! Stable neo-Hookean law.

use super::decomposition::{SignedSvd, cofactor, cofactor_of};
use super::invariants::{self, InvariantDerivatives};
use super::{IsotropicLaw, Lame, Law, LawName, Matrix9, PrincipalTangent};
use crate::lanes::{FourVectors, LANES, Lanes, lanes};
use crate::number::{Columns, Number, columns, columns_of, norm_squared};
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
#[inline(always)]
fn own_constants<N: Number>(mu: N, lambda: N) -> [N; 2] {
    [N::of(4.0 / 3.0) * mu, N::of(5.0 / 6.0).mul_add(mu, lambda)]
}

/// Ψ of one element or of four, each with moduli of its own.
#[inline(always)]
fn energy<N: Number>(f: &Columns<N>, mu: N, lambda: N) -> N {
    let of = N::of;
    let [mu, lambda] = own_constants(mu, lambda);
    let (_, j) = cofactor_of(f);
    let (i, growth) = (norm_squared(f), j - of(1.0));
    let logarithm = (of(0.25) * (i + of(1.0))).natural_log();
    let of_growth = of(0.5) * lambda * growth - of(0.75) * mu;
    (of(0.5) * mu).mul_add(i - of(3.0) - logarithm, of_growth * growth)
}

/// P.
#[inline(always)]
fn stress<N: Number>(f: &Columns<N>, mu: N, lambda: N) -> Columns<N> {
    let of = N::of;
    let [mu, lambda] = own_constants(mu, lambda);
    let (cofactor, j) = cofactor_of(f);
    let along = mu * (of(1.0) - of(1.0) / (norm_squared(f) + of(1.0)));
    let across = lambda * (j - of(1.0)) - of(0.75) * mu;
    columns(|k, i| cofactor[k][i].mul_add(across, f[k][i] * along))
}

/// The moduli of four elements.
#[inline(always)]
fn moduli(lame: &[Lame; LANES]) -> [Lanes; 2] {
    [
        Lanes(lanes(|lane| lame[lane].mu)),
        Lanes(lanes(|lane| lame[lane].lambda)),
    ]
}

impl Law for StableNeoHookean {
    type Constants = Lame;
    type Parameters = ();
    const NAME: LawName = LawName::StableNeoHookean;

    fn constants(lame: &Lame, _parameters: &()) -> Lame {
        *lame
    }

    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64 {
        energy(&columns_of(f), lame.mu, lame.lambda)
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
        stress(&columns_of(f), lame.mu, lame.lambda).into()
    }

    #[inline(always)]
    fn energy_of_each(f: &[FourVectors; 3], lame: &[Lame; LANES]) -> Lanes {
        let [mu, lambda] = moduli(lame);
        energy(f, mu, lambda)
    }

    #[inline(always)]
    fn stress_of_each(f: &[FourVectors; 3], lame: &[Lame; LANES]) -> [FourVectors; 3] {
        let [mu, lambda] = moduli(lame);
        stress(f, mu, lambda)
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
    let [mu, lambda] = own_constants(lame.mu, lame.lambda);
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
