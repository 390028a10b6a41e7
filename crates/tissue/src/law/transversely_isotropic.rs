//! Transversely isotropic neo-Hookean law: one family of fibres in a neo-Hookean matrix.

use super::decomposition::SignedSvd;
use super::elasticity::{Elasticity, Family, Lame};
use super::{Constants, Law, LawName, Matrix9, NeoHookean, Parameters, PrincipalTangent};
use crate::range::{MaterialError, require};
use microsim_mesh::FAMILIES;
use nalgebra::{Matrix3, Vector3};

/// Ψ = Ψ_nH(F) + m/8 (I₄ − 1)² with I₄ = |F a₀|², the neo-Hookean law of Bonet & Wood (1997) with the standard reinforcing model (Qiu
/// & Pence 1997; Merodio & Ogden 2005, there with γμ = m/4) along the fibre direction a₀.
///
/// E and ν are those of the matrix. At small strain the fibres add m to the stiffness along a₀ alone, so that with n = 1 + m/E
///
/// - along the fibres Young's modulus is n E, and the contraction across them ν;
/// - across them it is E/(1 − ν² (1 − 1/n));
/// - both shear moduli are those of the matrix, E/(2 (1 + ν)).
///
/// The fibres belong to the isochoric part; they resist stretch and compression alike. A polynomial beside the matrix: finite
/// everywhere, and inverted matter is pushed back by the matrix.
///
/// # Limitations
/// One family of fibres. Compressed along them the law loses ellipticity, at the latest at I₄ = 1 − 2μ/m = 1 − 1/((1+ν)(n−1)): there the
/// second derivative along b⊗a₀ with b ⊥ F a₀, which is μ + ½m(I₄−1), is zero (n = 5 and ν = 0.45: a stretch of 0.91). Fibres that buckle do
/// the same.
///
/// Stiff fibres that do not lie along edges lock linear elements: they all but prescribe a stretch in each. Of a beam of half its length in
/// height with fibres at 0.5 rad to its axis, two cells over the height sag by this fraction of what eight do (`tests/stiff_fibres.rs`):
///
/// | n | 1 | 10 | 100 | 1000 |
/// |---|---|---|---|---|
/// | selective | 0.92 | 0.93 | 0.73 | 0.55 |
/// | tetrahedra | 0.62 | 0.69 | 0.58 | – |
///
/// At n = 1000 tetrahedra are locked on both meshes. Fibres belong to the isochoric part, which no discretisation integrates over more than
/// what is around an edge; up to n ≈ 10 an edge-smoothed mesh is as good as without fibres, beyond compare two meshes.
#[derive(Clone, Copy, Debug, Default)]
pub struct TransverselyIsotropic;

/// What a transversely isotropic law is given beside E and ν of its matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreParameters {
    /// n: Young's modulus along the fibres over that of the matrix, ≥ 1.
    pub fibre_ratio: f64,
}

impl Default for FibreParameters {
    /// Five times as stiff along the fibres.
    fn default() -> Self {
        Self { fibre_ratio: 5.0 }
    }
}

impl Parameters for FibreParameters {
    fn read<E>(value: &dyn Fn(&'static str) -> Result<f64, E>) -> Result<Self, E> {
        Ok(Self {
            fibre_ratio: value("fibre_ratio")?,
        })
    }

    fn check(&self, _poisson: f64) -> Result<(), MaterialError> {
        let n = self.fibre_ratio;
        require(n.is_finite() && n >= 1.0, "fibre_ratio", n, ">= 1")
    }
}

/// Lamé's constants of the matrix, and the fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreConstants {
    /// Of the matrix.
    pub lame: Lame,
    /// m \[Pa\], what the fibres add to the stiffness along them.
    pub stiffness: f64,
    /// Unit vector a₀ along the fibres at rest.
    pub direction: Vector3<f64>,
}

impl Constants for FibreConstants {
    const DIRECTIONS: usize = 1;

    #[inline(always)]
    fn along(self, [direction, _]: [Vector3<f64>; FAMILIES]) -> Self {
        Self { direction, ..self }
    }

    #[inline(always)]
    fn elasticity(&self) -> Elasticity {
        Elasticity {
            lame: self.lame,
            families: Some([Family::along(self.direction, self.stiffness), Family::NONE]),
        }
    }

    fn split(self) -> Option<[Self; 2]> {
        let [isochoric, volumetric] = self.lame.split()?;
        Some([
            Self {
                lame: isochoric,
                ..self
            },
            Self {
                lame: volumetric,
                stiffness: 0.0,
                ..self
            },
        ])
    }

    fn with_volumetric(self, factor: f64) -> Self {
        Self {
            lame: self.lame.with_volumetric(factor),
            ..self
        }
    }
}

impl FibreConstants {
    /// F a₀ and ½ m (I₄ − 1) \[Pa\].
    #[inline(always)]
    fn pull(&self, stretched: Vector3<f64>) -> (Vector3<f64>, f64) {
        let pull = 0.5 * self.stiffness * (stretched.norm_squared() - 1.0);
        (stretched, pull)
    }

    /// Adds T_ik a_j a_l: the derivative of a force along the fibre by its change.
    #[inline(always)]
    fn add_to(&self, tangent: &mut Matrix9, of_fibre: &Matrix3<f64>) {
        let a = &self.direction;
        for (j, l) in (0..9).map(|b| (b % 3, b / 3)) {
            let along = a[j] * a[l];
            for (i, k) in (0..9).map(|b| (b % 3, b / 3)) {
                tangent[(i + 3 * j, k + 3 * l)] += of_fibre[(i, k)] * along;
            }
        }
    }
}

impl Law for TransverselyIsotropic {
    type Constants = FibreConstants;
    type Parameters = FibreParameters;
    const NAME: LawName = LawName::TransverselyIsotropic;

    fn constants(lame: &Lame, parameters: &Self::Parameters) -> Self::Constants {
        let Lame { mu, lambda } = *lame;
        let young = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
        FibreConstants {
            lame: *lame,
            stiffness: young * (parameters.fibre_ratio - 1.0),
            direction: Vector3::x(),
        }
    }

    fn energy(f: &Matrix3<f64>, c: &Self::Constants) -> f64 {
        let growth = (f * c.direction).norm_squared() - 1.0;
        NeoHookean::energy(f, &c.lame) + 0.125 * c.stiffness * growth * growth
    }

    #[inline(always)]
    fn stress(f: &Matrix3<f64>, c: &Self::Constants) -> Matrix3<f64> {
        let (stretched, pull) = c.pull(f * c.direction);
        NeoHookean::stress(f, &c.lame) + stretched * pull * c.direction.transpose()
    }

    fn tangent(f: &Matrix3<f64>, c: &Self::Constants) -> Matrix9 {
        let (stretched, pull) = c.pull(f * c.direction);
        let mut tangent = NeoHookean::tangent(f, &c.lame);
        let of_fibre =
            stretched * stretched.transpose() * c.stiffness + Matrix3::from_diagonal_element(pull);
        c.add_to(&mut tangent, &of_fibre);
        tangent
    }

    fn positive_principal_tangent(f: &SignedSvd, c: &Self::Constants) -> PrincipalTangent {
        NeoHookean::positive_principal_tangent(f, &c.lame)
    }

    /// The nearest one: it has the eigenvalues ½ m (I₄ − 1) across F a₀, twice, and ½ m (3 I₄ − 1) along it.
    fn add_positive_fibres(f: &SignedSvd, c: &Self::Constants, tangent: &mut Matrix9) {
        let in_axes = f.v.tr_mul(&c.direction).component_mul(&f.stretches);
        let (stretched, pull) = c.pull(f.u * in_axes);
        let square = stretched.norm_squared();
        let across = pull.max(0.0);
        let along = (pull + c.stiffness * square).max(0.0);
        let mut of_fibre = Matrix3::from_diagonal_element(across);
        // Of a fibre without length nothing is left: both eigenvalues are cut off.
        if along > across {
            of_fibre += stretched * stretched.transpose() * ((along - across) / square);
        }
        c.add_to(tangent, &of_fibre);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::contract;

    fn constants(direction: Vector3<f64>) -> FibreConstants {
        FibreConstants {
            lame: Lame {
                mu: 0.8,
                lambda: 2.5,
            },
            stiffness: 3.7,
            direction,
        }
    }

    #[test]
    fn keeps_the_contract() {
        contract::check::<TransverselyIsotropic>();
    }

    /// Stretches ℓ along and q across the fibre, the fibre free of the sides: P_∥ = μ (ℓ − 1/ℓ) + λ ln(J)/ℓ + m/2 (ℓ² − 1) ℓ and
    /// P_⊥ = μ (q − 1/q) + λ ln(J)/q with J = ℓ q².
    #[test]
    fn stretch_along_the_fibre_is_the_closed_form() {
        let c = constants(Vector3::z());
        for (along, across) in [(1.3_f64, 0.9_f64), (0.7, 1.1), (2.0, 0.7)] {
            let f = Matrix3::from_diagonal(&[across, across, along].into());
            let stress = TransverselyIsotropic::stress(&f, &c);
            let log = libm::log(along * across * across);
            let of_matrix = |stretch: f64| {
                c.lame.mu * (stretch - 1.0 / stretch) + c.lame.lambda * log / stretch
            };
            let pull = 0.5 * c.stiffness * (along * along - 1.0) * along;
            assert!((stress[(2, 2)] - of_matrix(along) - pull).abs() < 1e-14);
            assert!((stress[(0, 0)] - of_matrix(across)).abs() < 1e-14);
        }
    }

    /// Simple shear γ across fibres at an angle φ to its direction: I₄ = 1 + γ sin 2φ + γ² sin²φ, and the shear stress is μ γ and
    /// what the fibre pulls, m/2 (I₄ − 1) (cos φ + γ sin φ) sin φ (Merodio & Ogden 2005).
    #[test]
    fn simple_shear_at_an_angle_is_the_closed_form() {
        for phi in [0.0_f64, 0.4, 1.2, 2.5] {
            let (sin, cos) = libm::sincos(phi);
            let c = constants(Vector3::new(cos, sin, 0.0));
            for gamma in [-0.6, 0.05, 1.1] {
                let mut f = Matrix3::identity();
                f[(0, 1)] = gamma;
                let stress = TransverselyIsotropic::stress(&f, &c);
                let growth = 2.0 * gamma * sin * cos + gamma * gamma * sin * sin;
                let pull = 0.5 * c.stiffness * growth * (cos + gamma * sin) * sin;
                let expected = c.lame.mu * gamma + pull;
                assert!((stress[(0, 1)] - expected).abs() < 1e-14, "{phi} {gamma}");
            }
        }
    }

    /// The compliance at small strain: n E along, E/(1 − ν² (1 − 1/n)) across, ν and the shear moduli of the matrix.
    #[test]
    fn moduli_at_small_strain_are_those_that_are_documented() {
        let (young, poisson, ratio) = (3.0, 0.4, 6.0);
        let parameters = FibreParameters { fibre_ratio: ratio };
        let lame = Lame::from_young_poisson(young, poisson);
        let c = TransverselyIsotropic::constants(&lame, &parameters)
            .along([Vector3::x(), Vector3::zeros()]);
        let tangent = TransverselyIsotropic::tangent(&Matrix3::identity(), &c);
        let stiffness = Matrix3::from_fn(|i, j| tangent[(4 * i, 4 * j)]);
        let compliance = stiffness.try_inverse().unwrap();
        let near = |value: f64, expected: f64| {
            assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        };
        near(1.0 / compliance[(0, 0)], ratio * young);
        near(-compliance[(1, 0)] / compliance[(0, 0)], poisson);
        let across = young / (1.0 - poisson * poisson * (1.0 - 1.0 / ratio));
        near(1.0 / compliance[(1, 1)], across);
        near(1.0 / compliance[(2, 2)], across);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            near(tangent[(i + 3 * j, i + 3 * j)], lame.mu);
        }
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        assert_eq!(FibreParameters { fibre_ratio: 1.0 }.check(0.3), Ok(()));
        for fibre_ratio in [0.99, -1.0, f64::NAN, f64::INFINITY] {
            let error = FibreParameters { fibre_ratio }.check(0.3).unwrap_err();
            assert_eq!(error.value_name, "fibre_ratio");
        }
    }
}
