//! Compressible neo-Hookean law with logarithms.

use super::decomposition::{SignedSvd, cofactor};
use super::invariants::{self, InvariantDerivatives};
use super::isotropic::nearest_positive;
use super::volume::log_volume;
use super::{IsotropicLaw, Lame, Law, LawName, Matrix9, PrincipalTangent};
use nalgebra::{Matrix3, Vector3};

/// Ψ = μ/2 (tr FᵀF − 3) − μ ln J + λ/2 ln²J, J = det F (Bonet & Wood 1997).
///
/// The logarithm has no value at J ≤ 0, and next to it a stiffness that no step survives. Below J = 1/5 it goes on as its
/// Taylor polynomial of second order: energy, stress and tangent are continuous and finite for every F, and the pressure
/// against collapse goes on growing through inversion, so that line searches and explicit steps find back. For J ≥ 1/5, far
/// beyond what tissue bears, it is the law as printed.
#[derive(Clone, Copy, Debug, Default)]
pub struct NeoHookean;

impl Law for NeoHookean {
    type Constants = Lame;
    type Parameters = ();
    const NAME: LawName = LawName::NeoHookean;

    fn constants(lame: &Lame, _parameters: &()) -> Lame {
        *lame
    }

    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64 {
        let [log, ..] = log_volume(f.determinant());
        0.5 * lame.mu * (f.norm_squared() - 3.0) - lame.mu * log + 0.5 * lame.lambda * log * log
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
        let (cofactor, j) = cofactor(f);
        let [log, slope, _] = log_volume(j);
        let b1 = (lame.lambda * log - lame.mu) * slope;
        invariants::stress(f, &cofactor, 0.5 * lame.mu, b1)
    }

    #[inline(always)]
    fn tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9 {
        let (cofactor, j) = cofactor(f);
        invariants::tangent(f, &cofactor, &derivatives(f.norm_squared(), j, lame))
    }

    fn positive_tangent(f: &SignedSvd, lame: &Lame) -> Matrix9 {
        nearest_positive::<Self>(f, lame)
    }
}

impl IsotropicLaw for NeoHookean {
    fn principal_tangent(stretches: &Vector3<f64>, lame: &Lame) -> PrincipalTangent {
        let derivatives = derivatives(stretches.norm_squared(), stretches.product(), lame);
        invariants::principal_tangent(stretches, &derivatives)
    }
}

#[inline(always)]
fn derivatives(_i: f64, j: f64, lame: &Lame) -> InvariantDerivatives {
    let [log, slope, curvature] = log_volume(j);
    let pull = lame.lambda * log - lame.mu;
    InvariantDerivatives {
        a1: 0.5 * lame.mu,
        a2: 0.0,
        b1: pull * slope,
        b2: lame.lambda * slope * slope + pull * curvature,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_contract() {
        crate::law::contract::check_isotropic::<NeoHookean>();
    }

    #[test]
    fn collapse_and_inversion_are_pushed_back_ever_harder() {
        let lame = Lame {
            mu: 1.0,
            lambda: 2.0,
        };
        let derivative = |j: f64| {
            let [log, slope, _] = log_volume(j);
            (lame.lambda * log - lame.mu) * slope
        };
        let pressures: Vec<f64> = (0..40).map(|k| derivative(0.5 - 0.05 * k as f64)).collect();
        assert!(
            pressures[0] < 0.0 && pressures.is_sorted_by(|a, b| a > b),
            "{pressures:?}"
        );
    }
}
