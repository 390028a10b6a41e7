//! Compressible neo-Hookean law with logarithms.

use super::decomposition::{SignedSvd, cofactor, cofactor_of};
use super::invariants::{self, InvariantDerivatives};
use super::volume::{log_volume, log_volume_slopes};
use super::{IsotropicLaw, Lame, Law, LawName, Matrix9, PrincipalTangent};
use crate::lanes::FourVectors;
use crate::number::{Columns, Number, columns, columns_of};
use microsim_mesh::FAMILIES;
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
        energy(f.norm_squared(), f.determinant(), lame)
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
        stress(&columns_of(f), lame).into()
    }

    #[inline(always)]
    fn stress_of_four(
        f: &[FourVectors; 3],
        _directions: &[FourVectors; FAMILIES],
        lame: &Lame,
    ) -> [FourVectors; 3] {
        stress(f, lame)
    }

    #[inline(always)]
    fn tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9 {
        let (cofactor, j) = cofactor(f);
        invariants::tangent(f, &cofactor, &derivatives(j, lame))
    }

    fn positive_principal_tangent(f: &SignedSvd, lame: &Lame) -> PrincipalTangent {
        Self::principal_tangent(&f.stretches, lame).positive()
    }
}

impl IsotropicLaw for NeoHookean {
    fn principal_tangent(stretches: &Vector3<f64>, lame: &Lame) -> PrincipalTangent {
        let derivatives = derivatives(stretches.product(), lame);
        invariants::principal_tangent(stretches, &derivatives)
    }
}

#[inline(always)]
pub(super) fn derivatives<N: Number>(j: N, lame: &Lame) -> InvariantDerivatives<N> {
    let [b1, b2] = volume_slopes(j, lame);
    InvariantDerivatives {
        a1: N::of(0.5 * lame.mu),
        a2: N::of(0.0),
        b1,
        b2,
    }
}

/// Ψ of I and J.
#[inline(always)]
pub(super) fn energy<N: Number>(i: N, j: N, lame: &Lame) -> N {
    let (of, log) = (N::of, log_volume(j));
    of(0.5 * lame.mu) * (i - of(3.0)) - of(lame.mu) * log + of(0.5 * lame.lambda) * log * log
}

/// P = μ F + b' cof F.
#[inline(always)]
fn stress<N: Number>(f: &Columns<N>, lame: &Lame) -> Columns<N> {
    let (cofactor, j) = cofactor_of(f);
    let [b1, _] = volume_slopes(j, lame);
    let mu = N::of(lame.mu);
    columns(|k, i| f[k][i] * mu + cofactor[k][i] * b1)
}

/// b' and b'' of b(J) = −μ ln J + λ/2 ln²J.
#[inline(always)]
pub(super) fn volume_slopes<N: Number>(j: N, lame: &Lame) -> [N; 2] {
    let [slope, curvature] = log_volume_slopes(j);
    let (lambda, mu) = (N::of(lame.lambda), N::of(lame.mu));
    // Of the isochoric part the logarithm is not needed, which takes longer than all the rest.
    let pull = match lame.lambda == 0.0 {
        true => -mu,
        false => lambda * log_volume(j) - mu,
    };
    [pull * slope, lambda * slope * slope + pull * curvature]
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
            let [b1, _] = volume_slopes(j, &lame);
            b1
        };
        let pressures: Vec<f64> = (0..40).map(|k| derivative(0.5 - 0.05 * k as f64)).collect();
        assert!(
            pressures[0] < 0.0 && pressures.is_sorted_by(|a, b| a > b),
            "{pressures:?}"
        );
    }
}
