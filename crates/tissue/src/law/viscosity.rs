//! Kelvin–Voigt viscosity of a continuum: the stress of the rate of Green's strain, for a relaxation time.
//!
//! Second Piola–Kirchhoff stress S = τ (λ tr Ė + 2μ Ė) with Ė = sym(Fᵀ Ḟ). A rigid rotation has Ė = 0 and no stress; the power
//! −τ (λ tr²Ė + 2μ Ė:Ė) is never positive; at rest the damping matrix is τ times the stiffness of linear elasticity.

use super::elasticity::{FamilyOf, family_of};
use super::st_venant_kirchhoff::set_material_tangent;
use super::{Elasticity, Lame, Matrix9};
use crate::number::{
    Columns, Columns9, Number, add_outer, columns, columns_of, dot, entries, product,
};
use microsim_mesh::FAMILIES;
use nalgebra::Matrix3;

/// First Piola–Kirchhoff stress F S \[Pa\] of the rate `rate` = Ḟ \[1/s\]; `relaxation_time` τ \[s\].
#[inline]
pub fn stress(
    f: &Matrix3<f64>,
    rate: &Matrix3<f64>,
    elasticity: &Elasticity,
    relaxation_time: f64,
) -> Matrix3<f64> {
    let families = elasticity.families.map(|families| families.map(family_of));
    let (f, rate) = (columns_of(f), columns_of(rate));
    stress_of(&f, &rate, &elasticity.lame, &families, relaxation_time).into()
}

/// As [`stress`], of one element or of four.
#[inline(always)]
pub(crate) fn stress_of<N: Number>(
    f: &Columns<N>,
    rate: &Columns<N>,
    lame: &Lame,
    families: &Option<[FamilyOf<N>; FAMILIES]>,
    relaxation_time: f64,
) -> Columns<N> {
    let half = N::of(0.5 * relaxation_time);
    let strain_rate = columns(|k, i| (dot(&f[i], &rate[k]) + dot(&f[k], &rate[i])) * half);
    let trace = strain_rate[0][0] + strain_rate[1][1] + strain_rate[2][2];
    let pressure = N::of(lame.lambda) * trace;
    let twice = N::of(2.0 * lame.mu);
    let mut second = columns(|k, i| strain_rate[k][i] * twice);
    for (k, column) in second.iter_mut().enumerate() {
        column[k] = column[k] + pressure;
    }
    for (stiffness, structure) in families.iter().flatten() {
        let [a, b, c] = [0, 1, 2].map(|k| dot(&structure[k], &strain_rate[k]));
        let along = *stiffness * (a + b + c);
        second = columns(|k, i| second[k][i] + structure[k][i] * along);
    }
    [0, 1, 2].map(|k| product(f, &second[k]))
}

/// Its derivative by Ḟ \[Pa·s\]; symmetric, no negative eigenvalue for μ ≥ 0, λ ≥ 0.
#[inline(always)]
pub fn tangent(f: &Matrix3<f64>, elasticity: &Elasticity, relaxation_time: f64) -> Matrix9 {
    let families = elasticity.families.map(|families| families.map(family_of));
    let mut tangent = [[0.0; 9]; 9];
    let lame = &elasticity.lame;
    add_tangent(
        &columns_of(f),
        lame,
        &families,
        relaxation_time,
        &mut tangent,
    );
    tangent.into()
}

/// Adds [`tangent`], of one element or of four.
#[inline(always)]
pub(crate) fn add_tangent<N: Number>(
    f: &Columns<N>,
    lame: &Lame,
    families: &Option<[FamilyOf<N>; FAMILIES]>,
    relaxation_time: f64,
    sum: &mut Columns9<N>,
) {
    let viscosities = Lame {
        mu: lame.mu * relaxation_time,
        lambda: lame.lambda * relaxation_time,
    };
    let mut tangent = [[N::of(0.0); 9]; 9];
    set_material_tangent(f, &viscosities, &mut tangent);
    for (stiffness, structure) in families.iter().flatten() {
        // F H, column after column: the power is τ m (H:Ė)².
        let along = entries(&[0, 1, 2].map(|k| product(f, &structure[k])));
        add_outer(&mut tangent, &along, *stiffness * N::of(relaxation_time));
    }
    for (sum, tangent) in sum.iter_mut().zip(&tangent) {
        for (sum, entry) in sum.iter_mut().zip(tangent) {
            *sum = *sum + *entry;
        }
    }
}

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
