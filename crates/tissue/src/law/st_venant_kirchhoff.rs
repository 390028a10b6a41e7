//! St Venant–Kirchhoff: linear in Green's strain.

use super::decomposition::SignedSvd;
use super::{IsotropicLaw, Lame, Law, LawName, Matrix9, PrincipalTangent};
use crate::number::{Columns, Columns9, Number, columns, columns_of};
use nalgebra::Matrix3;

/// Ψ = μ E:E + λ/2 tr²E with Green's strain E = (FᵀF − 1)/2.
///
/// # Limitations
/// Softens under compression and has no resistance left at a stretch of 1/√3. Mirrored matter is at rest: what is inverted stays
/// inverted. Fit for large rotations with small strain only.
#[derive(Clone, Copy, Debug, Default)]
pub struct StVenantKirchhoff;

/// Green's strain.
#[inline]
fn strain(f: &Matrix3<f64>) -> Matrix3<f64> {
    (f.tr_mul(f) - Matrix3::identity()) * 0.5
}

/// Second Piola–Kirchhoff stress of a strain of Green's kind, 2μ E + λ tr E \[Pa\].
#[inline]
pub(super) fn second_piola(strain: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
    let mut stress = strain * (2.0 * lame.mu);
    let pressure = lame.lambda * strain.trace();
    for k in 0..3 {
        stress[(k, k)] += pressure;
    }
    stress
}

/// The part of ∂P/∂F that comes from the change of the strain: λ F_ij F_kl + μ ((FFᵀ)_ik δ_jl + F_il F_kj); symmetric, no
/// negative eigenvalue for μ ≥ 0, λ ≥ 0.
#[inline(always)]
pub(super) fn material_tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9 {
    let mut tangent = [[0.0; 9]; 9];
    set_material_tangent(&columns_of(f), lame, &mut tangent);
    tangent.into()
}

/// As [`material_tangent`], of one matrix or of four.
#[inline(always)]
pub(super) fn set_material_tangent<N: Number>(
    f: &Columns<N>,
    lame: &Lame,
    tangent: &mut Columns9<N>,
) {
    let (lambda, mu) = (N::of(lame.lambda), N::of(lame.mu));
    let left = |i: usize, k: usize| f[0][i] * f[0][k] + f[1][i] * f[1][k] + f[2][i] * f[2][k];
    let left = columns(|k, i| left(i, k) * mu);
    for (j, l) in (0..9).map(|b| (b % 3, b / 3)) {
        for k in 0..3 {
            let (along, across) = (lambda * f[l][k], mu * f[j][k]);
            for i in 0..3 {
                let mut entry = f[j][i] * along + f[l][i] * across;
                if j == l {
                    entry = entry + left[k][i];
                }
                tangent[k + 3 * l][i + 3 * j] = entry;
            }
        }
    }
}

impl Law for StVenantKirchhoff {
    type Constants = Lame;
    type Parameters = ();
    const NAME: LawName = LawName::StVenantKirchhoff;

    fn constants(lame: &Lame, _parameters: &()) -> Lame {
        *lame
    }

    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64 {
        let strain = strain(f);
        let trace = strain.trace();
        lame.mu * strain.norm_squared() + 0.5 * lame.lambda * trace * trace
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64> {
        f * second_piola(&strain(f), lame)
    }

    fn tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9 {
        let mut tangent = material_tangent(f, lame);
        let stress = second_piola(&strain(f), lame);
        for j in 0..3 {
            for l in 0..3 {
                for i in 0..3 {
                    tangent[(i + 3 * j, i + 3 * l)] += stress[(l, j)];
                }
            }
        }
        tangent
    }

    fn positive_principal_tangent(f: &SignedSvd, lame: &Lame) -> PrincipalTangent {
        Self::principal_tangent(&f.stretches, lame).positive()
    }
}

impl IsotropicLaw for StVenantKirchhoff {}

#[cfg(test)]
mod tests {
    #[test]
    fn keeps_the_contract() {
        crate::law::contract::check_isotropic::<super::StVenantKirchhoff>();
    }
}
