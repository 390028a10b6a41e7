//! Kelvin–Voigt viscosity of a continuum: the stress of the rate of Green's strain, for a relaxation time.
//!
//! Second Piola–Kirchhoff stress S = τ (λ tr Ė + 2μ Ė) with Ė = sym(Fᵀ Ḟ). A rigid rotation has Ė = 0 and no stress; the power
//! −τ (λ tr²Ė + 2μ Ė:Ė) is never positive; at rest the damping matrix is τ times the stiffness of linear elasticity.

use super::st_venant_kirchhoff::{material_tangent, second_piola};
use super::{Elasticity, Lame, Matrix9};
use nalgebra::{Matrix3, SVector};

/// First Piola–Kirchhoff stress F S \[Pa\] of the rate `rate` = Ḟ \[1/s\]; `relaxation_time` τ \[s\].
#[inline]
pub fn stress(
    f: &Matrix3<f64>,
    rate: &Matrix3<f64>,
    elasticity: &Elasticity,
    relaxation_time: f64,
) -> Matrix3<f64> {
    let product = f.tr_mul(rate);
    let strain_rate = (product + product.transpose()) * (0.5 * relaxation_time);
    let mut second = second_piola(&strain_rate, &elasticity.lame);
    for family in elasticity.families.iter().flatten() {
        second += family.structure * (family.stiffness * family.structure.dot(&strain_rate));
    }
    f * second
}

/// Its derivative by Ḟ \[Pa·s\]; symmetric, no negative eigenvalue for μ ≥ 0, λ ≥ 0.
#[inline(always)]
pub fn tangent(f: &Matrix3<f64>, elasticity: &Elasticity, relaxation_time: f64) -> Matrix9 {
    let Lame { mu, lambda } = elasticity.lame;
    let viscosities = Lame {
        mu: mu * relaxation_time,
        lambda: lambda * relaxation_time,
    };
    let mut tangent = material_tangent(f, &viscosities);
    for family in elasticity.families.iter().flatten() {
        // F H, column after column: the power is τ m (H:Ė)².
        let along = Vector9::from_column_slice((f * family.structure).as_slice());
        tangent += along * along.transpose() * (family.stiffness * relaxation_time);
    }
    tangent
}

/// A change of F, column after column.
type Vector9 = SVector<f64, 9>;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Family;
    use crate::testing::numbers;

    /// Isotropic, and with fibres.
    fn both() -> [Elasticity; 2] {
        let lame = Lame {
            mu: 3.0,
            lambda: 7.0,
        };
        let dispersed = Family {
            stiffness: 2.0,
            structure: Matrix3::new(0.3, 0.1, 0.0, 0.1, 0.5, -0.2, 0.0, -0.2, 0.2),
        };
        let families = Some([Family::along([0.48, -0.6, 0.64].into(), 5.0), dispersed]);
        [Elasticity::isotropic(lame), Elasticity { lame, families }]
    }

    const TIME: f64 = 0.2;

    fn random(next: &mut impl FnMut() -> f64) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| next())
    }

    #[test]
    fn rigid_rotation_is_free_and_everything_else_costs_power() {
        let mut next = numbers();
        for (_, elasticity) in (0..50).flat_map(|k| both().map(|e| (k, e))) {
            let f = Matrix3::identity() + random(&mut next) * 0.5;
            let spin = random(&mut next);
            let spin = spin - spin.transpose();
            // Numbers of size 10; Ė of a spin is zero up to rounding.
            assert!(stress(&f, &(spin * f), &elasticity, TIME).amax() < 1e-13);
            let rate = random(&mut next);
            assert!(stress(&f, &rate, &elasticity, TIME).dot(&rate) > 0.0);
        }
    }

    #[test]
    fn the_stress_is_linear_in_the_rate_with_this_tangent() {
        let mut next = numbers();
        for (_, elasticity) in (0..50).flat_map(|k| both().map(|e| (k, e))) {
            let (f, rate) = (random(&mut next), random(&mut next));
            let tangent = tangent(&f, &elasticity, TIME);
            let stress = stress(&f, &rate, &elasticity, TIME);
            for p in 0..9 {
                let row: f64 = (0..9).map(|q| tangent[(p, q)] * rate.as_slice()[q]).sum();
                assert!((row - stress.as_slice()[p]).abs() < 1e-13);
            }
            assert!((tangent - tangent.transpose()).amax() < 1e-14);
        }
    }
}
