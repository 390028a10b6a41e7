//! Compressible Mooney–Rivlin law.

use super::decomposition::{SignedSvd, cofactor};
use super::elasticity::{Elasticity, Lame};
use super::invariants::{self, InvariantDerivatives};
use super::st_venant_kirchhoff::material_tangent;
use super::volume::{log_volume, log_volume_slopes};
use super::{Constants, IsotropicLaw, Law, LawName, Matrix9, Parameters, PrincipalTangent};
use crate::range::{MaterialError, require};
use nalgebra::Matrix3;

/// Ψ = c₁₀ (I₁ − 3) + c₀₁ (I₂ − 3) − 2 (c₁₀ + 2c₀₁) ln J + κ/2 (J − 1)² with I₁ = tr FᵀF, I₂ = |cof F|², J = det F (Ciarlet &
/// Geymonat 1982; Holzapfel 2000, eq. 6.147, there with c = κ/2).
///
/// At small strain it is linear elasticity with μ = 2 (c₁₀ + c₀₁) and λ = κ + 4c₀₁. The volumetric part of its
/// [split](Constants::split) is κ/2 (J − 1)², the isochoric part all the rest, with λ = 4c₀₁ of its own. The logarithm goes on below J = 1/5 as in
/// [`NeoHookean`](super::NeoHookean): finite everywhere, and inverted matter is pushed back.
///
/// # Limitations
/// λ ≥ 4c₀₁, that is ν ≥ r/(1 + 2r) with r = c₀₁/(c₁₀ + c₀₁): no compressible foams.
#[derive(Clone, Copy, Debug, Default)]
pub struct MooneyRivlin;

/// What a Mooney–Rivlin law is given beside E and ν, which are those at small strain: E = 4 (1 + ν) (c₁₀ + c₀₁).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlinParameters {
    /// c₀₁/(c₁₀ + c₀₁), 0 to 1.
    pub c01_fraction: f64,
}

impl Default for MooneyRivlinParameters {
    /// A quarter: c₁₀ = 3c₀₁.
    fn default() -> Self {
        Self { c01_fraction: 0.25 }
    }
}

impl Parameters for MooneyRivlinParameters {
    fn read<E>(value: &dyn Fn(&'static str) -> Result<f64, E>) -> Result<Self, E> {
        Ok(Self {
            c01_fraction: value("c01_fraction")?,
        })
    }

    fn check(&self, poisson: f64) -> Result<(), MaterialError> {
        let r = self.c01_fraction;
        require((0.0..=1.0).contains(&r), "c01_fraction", r, ">= 0 and <= 1")?;
        require(
            poisson >= r / (1.0 + 2.0 * r),
            "poisson",
            poisson,
            ">= r/(1 + 2 r) with r the c01_fraction of mooney-rivlin",
        )
    }
}

/// c₁₀, c₀₁ and κ of a Mooney–Rivlin law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooneyRivlinConstants {
    /// c₁₀ \[Pa\].
    pub c10: f64,
    /// c₀₁ \[Pa\].
    pub c01: f64,
    /// κ \[Pa\] of κ/2 (J − 1)²; the bulk modulus at rest is κ + 4c₀₁ + 4/3 (c₁₀ + c₀₁).
    pub volumetric: f64,
}

impl Constants for MooneyRivlinConstants {
    #[inline(always)]
    fn elasticity(&self) -> Elasticity {
        Elasticity::isotropic(Lame {
            mu: 2.0 * (self.c10 + self.c01),
            lambda: self.volumetric + 4.0 * self.c01,
        })
    }

    fn split(self) -> Option<[Self; 2]> {
        let isochoric = Self {
            volumetric: 0.0,
            ..self
        };
        let volumetric = Self {
            c10: 0.0,
            c01: 0.0,
            ..self
        };
        (self.volumetric > 0.0).then_some([isochoric, volumetric])
    }

    fn with_volumetric(self, factor: f64) -> Self {
        Self {
            volumetric: factor * self.volumetric,
            ..self
        }
    }
}

impl MooneyRivlinConstants {
    /// b'(J) and b''(J) of the terms of the volume ratio.
    #[inline(always)]
    fn of_volume(&self, j: f64) -> [f64; 2] {
        let [slope, curvature] = log_volume_slopes(j);
        let pull = 2.0 * (self.c10 + 2.0 * self.c01);
        [
            self.volumetric * (j - 1.0) - pull * slope,
            self.volumetric - pull * curvature,
        ]
    }
}

impl Law for MooneyRivlin {
    type Constants = MooneyRivlinConstants;
    type Parameters = MooneyRivlinParameters;
    const NAME: LawName = LawName::MooneyRivlin;

    fn constants(lame: &Lame, parameters: &Self::Parameters) -> Self::Constants {
        let c01 = 0.5 * lame.mu * parameters.c01_fraction;
        MooneyRivlinConstants {
            c10: 0.5 * lame.mu - c01,
            c01,
            // At the bound of ν rounding must not leave a negative one.
            volumetric: (lame.lambda - 4.0 * c01).max(0.0),
        }
    }

    fn energy(f: &Matrix3<f64>, c: &Self::Constants) -> f64 {
        let (cofactor, j) = cofactor(f);
        let log = log_volume(j);
        let growth = j - 1.0;
        c.c10 * (f.norm_squared() - 3.0) + c.c01 * (cofactor.norm_squared() - 3.0)
            - 2.0 * (c.c10 + 2.0 * c.c01) * log
            + 0.5 * c.volumetric * growth * growth
    }

    /// ∂I₂/∂F = 2 (I₁ F − F FᵀF).
    #[inline(always)]
    fn stress(f: &Matrix3<f64>, c: &Self::Constants) -> Matrix3<f64> {
        let (cofactor, j) = cofactor(f);
        let a1 = c.c10 + c.c01 * f.norm_squared();
        let [b1, _] = c.of_volume(j);
        invariants::stress(f, &cofactor, a1, b1) - f * (f.tr_mul(f) * (2.0 * c.c01))
    }

    fn tangent(f: &Matrix3<f64>, c: &Self::Constants) -> Matrix9 {
        let (cofactor, j) = cofactor(f);
        let [b1, b2] = c.of_volume(j);
        let derivatives = InvariantDerivatives {
            a1: c.c10 + c.c01 * f.norm_squared(),
            a2: c.c01,
            b1,
            b2,
        };
        let second = Lame {
            mu: 2.0 * c.c01,
            lambda: 0.0,
        };
        // The derivative of F FᵀF: two terms that St Venant–Kirchhoff has too, and dF FᵀF.
        let mut tangent =
            invariants::tangent(f, &cofactor, &derivatives) - material_tangent(f, &second);
        let right = f.tr_mul(f) * second.mu;
        for (j, l) in (0..9).map(|b| (b % 3, b / 3)) {
            for i in 0..3 {
                tangent[(i + 3 * j, i + 3 * l)] -= right[(l, j)];
            }
        }
        tangent
    }

    fn positive_principal_tangent(f: &SignedSvd, c: &Self::Constants) -> PrincipalTangent {
        Self::principal_tangent(&f.stretches, c).positive()
    }
}

impl IsotropicLaw for MooneyRivlin {}

#[cfg(test)]
mod tests {
    use super::*;

    const CONSTANTS: MooneyRivlinConstants = MooneyRivlinConstants {
        c10: 0.3,
        c01: 0.1,
        volumetric: 2.1,
    };

    #[test]
    fn keeps_the_contract() {
        crate::law::contract::check_isotropic::<MooneyRivlin>();
    }

    /// Uniaxial stretch λ of incompressible tissue: P = 2 (λ − λ⁻²) (c₁₀ + c₀₁/λ) (Holzapfel 2000, section 6.5). The compressible
    /// law has it as the difference of the stresses along and, times λ^(−3/2), across at det F = 1.
    #[test]
    fn uniaxial_stretch_at_constant_volume_is_the_closed_form() {
        for stretch in [0.6_f64, 0.9, 1.2, 2.0] {
            let across = 1.0 / stretch.sqrt();
            let f = Matrix3::from_diagonal(&[stretch, across, across].into());
            let stress = MooneyRivlin::stress(&f, &CONSTANTS);
            // A pressure p cof F is free: the one that makes the sides stress-free.
            let pulled = stress[(0, 0)] - stress[(1, 1)] * across / stretch;
            let expected = 2.0
                * (stretch - 1.0 / (stretch * stretch))
                * (CONSTANTS.c10 + CONSTANTS.c01 / stretch);
            assert!((pulled - expected).abs() < 1e-14, "{stretch}: {pulled}");
        }
    }

    /// Simple shear γ: σ₁₂ = 2 (c₁₀ + c₀₁) γ, and the normal stresses differ by σ₁₁ − σ₂₂ = γ σ₁₂ (Rivlin 1948).
    #[test]
    fn simple_shear_is_the_closed_form() {
        for gamma in [-0.4, 0.01, 1.3] {
            let mut f = Matrix3::identity();
            f[(0, 1)] = gamma;
            let cauchy = MooneyRivlin::stress(&f, &CONSTANTS) * f.transpose();
            let expected = 2.0 * (CONSTANTS.c10 + CONSTANTS.c01) * gamma;
            assert!((cauchy[(0, 1)] - expected).abs() < 1e-15);
            let difference = cauchy[(0, 0)] - cauchy[(1, 1)];
            assert!((difference - gamma * expected).abs() < 1e-14);
        }
    }

    #[test]
    fn constants_are_those_of_the_moduli_and_the_fraction() {
        let lame = Lame::from_young_poisson(3e4, 0.45);
        let parameters = MooneyRivlinParameters { c01_fraction: 0.3 };
        let c = MooneyRivlin::constants(&lame, &parameters);
        // E = 4 (1 + ν) (c₁₀ + c₀₁).
        assert!((4.0 * 1.45 * (c.c10 + c.c01) - 3e4).abs() < 1e-9);
        assert!((c.c01 / (c.c10 + c.c01) - 0.3).abs() < 1e-15);
        let lambda = c.elasticity().lame.lambda;
        assert!((lambda - lame.lambda).abs() < 1e-9 * lambda);
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        let check = |c01_fraction, poisson| MooneyRivlinParameters { c01_fraction }.check(poisson);
        assert_eq!(check(0.0, 0.0), Ok(()));
        assert_eq!(check(1.0, 1.0 / 3.0), Ok(()));
        for (fraction, poisson, name) in [
            (-0.1, 0.4, "c01_fraction"),
            (1.1, 0.4, "c01_fraction"),
            (f64::NAN, 0.4, "c01_fraction"),
            (0.5, 0.2, "poisson"),
        ] {
            assert_eq!(check(fraction, poisson).unwrap_err().value_name, name);
        }
    }
}
