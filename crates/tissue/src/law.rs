//! Material laws of a continuum: energy density, stress, tangent as functions of the deformation gradient.
//!
//! A law is a type of its own with three functions that share one contract test: at rest no energy and no stress, stress =
//! gradient of energy, tangent = derivative of stress, no change under rotation, isotropy. Every law here is linear in the two
//! Lamé constants, so that the part of μ and the part of λ can be integrated over different domains.

use nalgebra::{Matrix3, SMatrix};
use std::fmt::Debug;

/// ∂P/∂F with matrices written column after column: entry (i + 3j, k + 3l) is ∂P_ij/∂F_kl.
pub type Matrix9 = SMatrix<f64, 9, 9>;

/// Lamé's constants of linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// Shear modulus μ [Pa].
    pub mu: f64,
    /// λ [Pa].
    pub lambda: f64,
}

impl Lame {
    /// From Young's modulus [Pa] and Poisson's ratio, both already checked.
    pub fn from_young_poisson(young: f64, poisson: f64) -> Self {
        Self {
            mu: young / (2.0 * (1.0 + poisson)),
            lambda: young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
        }
    }
}

/// A hyperelastic, isotropic material law.
pub trait Law: Copy + Default + Debug + Send + Sync + 'static {
    /// Its name in files and reports.
    const NAME: &'static str;

    /// Energy density Ψ(F) [J/m³], up to nothing: Ψ(1) = 0.
    fn energy(f: &Matrix3<f64>, lame: &Lame) -> f64;

    /// First Piola–Kirchhoff stress P = ∂Ψ/∂F [Pa].
    fn stress(f: &Matrix3<f64>, lame: &Lame) -> Matrix3<f64>;

    /// ∂P/∂F [Pa].
    fn tangent(f: &Matrix3<f64>, lame: &Lame) -> Matrix9;
}
