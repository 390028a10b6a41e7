//! Corotational linear elasticity.

use super::decomposition::{SignedSvd, rotation_of};
use super::{IsotropicLaw, Lame, Law, LawName, Matrix9, PrincipalTangent};
use nalgebra::{Matrix3, Vector3};

/// Ψ = μ ‖F − R‖² + λ/2 tr²(RᵀF − 1), R the proper rotation nearest to F: P = 2μ (F − R) + λ tr(RᵀF − 1) R (Müller & Gross 2004;
/// McAdams et al. 2011).
///
/// Finite everywhere; inverted matter is pushed back along the axis of the smallest stretch.
///
/// # Limitations
/// λ resists the sum of the stretches, not the volume: at large strain the volume is not preserved. Where the two smallest signed
/// stretches sum to zero R jumps, and so does the stress: the tangent is not defined there and is bounded instead.
#[derive(Clone, Copy, Debug, Default)]
pub struct Corotational;

/// Least sum of two stretches that the tangent is computed with.
const SMALLEST_SUM: f64 = 1e-8;

impl Law for Corotational {
    type Constants = Lame;
    type Parameters = ();
    const NAME: LawName = LawName::Corotational;

    fn constants(lame: &Lame, _parameters: &()) -> Lame {
        *lame
    }

    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64 {
        let r = rotation_of(f);
        let growth = r.dot(f) - 3.0;
        lame.mu * (f - r).norm_squared() + 0.5 * lame.lambda * growth * growth
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
        let r = rotation_of(f);
        let along_r = lame.lambda * (r.dot(f) - 3.0) - 2.0 * lame.mu;
        f * (2.0 * lame.mu) + r * along_r
    }

    fn tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9 {
        let svd = SignedSvd::new(f);
        Self::principal_tangent(&svd.stretches, lame).rotated(&svd)
    }

    fn positive_principal_tangent(f: &SignedSvd, lame: &Lame) -> PrincipalTangent {
        Self::principal_tangent(&f.stretches, lame).positive()
    }
}

impl IsotropicLaw for Corotational {
    /// Symmetric shear has 2μ, as without rotation; the other one turns R too and has (ψ_i + ψ_j)/(σ_i + σ_j) with
    /// ψ_i = 2μ (σ_i − 1) + λ (Σσ − 3).
    fn principal_tangent(stretches: &Vector3<f64>, lame: &Lame) -> PrincipalTangent {
        let symmetric = 2.0 * lame.mu;
        let along_r = lame.lambda * (stretches.sum() - 3.0) - 2.0 * lame.mu;
        let twist = [[1, 2], [2, 0], [0, 1]].map(|[i, j]: [usize; 2]| {
            symmetric + 2.0 * along_r / (stretches[i] + stretches[j]).max(SMALLEST_SUM)
        });
        let mut stretch = Matrix3::repeat(lame.lambda);
        for k in 0..3 {
            stretch[(k, k)] += symmetric;
        }
        PrincipalTangent {
            stretch,
            direct: twist.map(|twist| 0.5 * (symmetric + twist)),
            crossed: twist.map(|twist| 0.5 * (symmetric - twist)),
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn keeps_the_contract() {
        crate::law::contract::check_isotropic::<super::Corotational>();
    }
}
