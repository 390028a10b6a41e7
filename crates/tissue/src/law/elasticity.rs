//! Small-strain elasticity: what every law is close to its rest state.

use crate::number::{Columns, columns_of};
use microsim_mesh::FAMILIES;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// ∂P/∂F with matrices written column after column: entry (i + 3j, k + 3l) is ∂P_ij/∂F_kl.
pub type Matrix9 = SMatrix<f64, 9, 9>;

/// Lamé's constants of linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// Shear modulus μ \[Pa\].
    pub mu: f64,
    /// λ \[Pa\].
    pub lambda: f64,
}

impl Lame {
    /// From Young's modulus \[Pa\] and Poisson's ratio, both already checked.
    ///
    /// ```
    /// use microsim_tissue::law::Lame;
    ///
    /// let Lame { mu, lambda } = Lame::from_young_poisson(30e3, 0.25);
    /// assert!((mu - 12e3).abs() < 1e-9 && (lambda - 12e3).abs() < 1e-9);
    /// ```
    pub fn from_young_poisson(young: f64, poisson: f64) -> Self {
        Self {
            mu: young / (2.0 * (1.0 + poisson)),
            lambda: young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
        }
    }
}

/// Linear elasticity of a law at rest: σ = λ tr ε + 2μ ε, and for each family of fibres + m (H:ε) H.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity {
    /// The isotropic part.
    pub lame: Lame,
    /// The families of fibres of a law that has directions.
    pub families: Option<[Family; FAMILIES]>,
}

/// What a family of fibres adds to the elasticity at rest: σ = m (H:ε) H. Fibres that bear tension alone have it under tension, which is
/// what bounds of the step and viscosity go by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Family {
    /// m \[Pa\], ≥ 0.
    pub stiffness: f64,
    /// Structure tensor H, symmetric: a₀ ⊗ a₀ of fibres that all lie along a₀.
    pub structure: Matrix3<f64>,
}

/// m \[Pa\] and H, column after column, of a [`Family`] of one element or of four.
pub(crate) type FamilyOf<N> = (N, Columns<N>);

/// Those of one family.
#[inline(always)]
pub(crate) fn family_of(family: Family) -> FamilyOf<f64> {
    (family.stiffness, columns_of(&family.structure))
}

impl Family {
    /// No fibres.
    pub const NONE: Self = Self {
        stiffness: 0.0,
        structure: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// Fibres that all lie along a unit vector.
    #[inline(always)]
    pub fn along(direction: Vector3<f64>, stiffness: f64) -> Self {
        Self {
            stiffness,
            structure: direction * direction.transpose(),
        }
    }
}

impl Elasticity {
    /// That of an isotropic law.
    #[inline(always)]
    pub fn isotropic(lame: Lame) -> Self {
        Self {
            lame,
            families: None,
        }
    }

    /// The block K_ij = V (λ b_i b_jᵀ + μ b_j b_iᵀ + μ b_i·b_j 1 + Σ m (H b_i)(H b_j)ᵀ) \[N/m\] of a domain of `volume` V
    /// \[m³\] for the gradients b_i and b_j \[1/m\] of two of its nodes.
    pub(crate) fn block(
        &self,
        volume: f64,
        b_i: &Vector3<f64>,
        b_j: &Vector3<f64>,
    ) -> Matrix3<f64> {
        let Lame { mu, lambda } = self.lame;
        let mut block = b_i * b_j.transpose() * lambda
            + b_j * b_i.transpose() * mu
            + Matrix3::from_diagonal_element(mu * b_i.dot(b_j));
        for family in self.families.iter().flatten() {
            let (row, column) = (family.structure * b_i, family.structure * b_j);
            block += row * column.transpose() * family.stiffness;
        }
        block * volume
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moduli_are_those_of_linear_elasticity() {
        // E = μ (3λ + 2μ)/(λ + μ), ν = λ/(2 (λ + μ)).
        let Lame { mu, lambda } = Lame::from_young_poisson(3e4, 0.4);
        assert!((mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu) - 3e4).abs() < 1e-9);
        assert!((lambda / (2.0 * (lambda + mu)) - 0.4).abs() < 1e-15);
    }
}
