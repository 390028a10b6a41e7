//! What a law is given, and what its functions take beside the deformation gradient.

use super::elasticity::{Elasticity, Family, Lame};
use crate::lanes::{FourVectors, LANES, Lanes, set_matrix, vector_of};
use crate::range::MaterialError;
use microsim_mesh::FAMILIES;
use nalgebra::Vector3;
use std::fmt::Debug;

/// The constants of a law as its functions take them: moduli, and the fibre direction where it has one. [`Lame`] is one for laws of μ
/// and λ.
pub trait Constants: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// How many fibre directions the law needs in each element.
    const DIRECTIONS: usize = 0;

    /// The same with the fibre directions a₀, unit vectors in the natural state, zero for a family that is not there; itself where the law
    /// takes none.
    #[inline(always)]
    fn along(self, _directions: [Vector3<f64>; FAMILIES]) -> Self {
        self
    }

    /// The elasticity at rest: what bounds of the step, mass floors and viscosity go by.
    fn elasticity(&self) -> Elasticity;

    /// The families of [`elasticity`](Self::elasticity) of four elements with these directions, for viscosity. By default one after the other.
    #[inline(always)]
    fn families_of_four(&self, directions: &[FourVectors; FAMILIES]) -> Option<FourFamilies> {
        if Self::DIRECTIONS == 0 {
            return None;
        }
        let mut families = NO_FAMILIES;
        for lane in 0..LANES {
            let one = self.along(directions.map(|a| vector_of(&a, lane)));
            let of_lane = one
                .elasticity()
                .families
                .unwrap_or([Family::NONE; FAMILIES]);
            for ((stiffness, structure), family) in families.iter_mut().zip(&of_lane) {
                stiffness.0[lane] = family.stiffness;
                set_matrix(structure, lane, &family.structure);
            }
        }
        Some(families)
    }

    /// Constants \[isochoric, volumetric\] of the two parts of the energy, whose sum is the energy. Discretisations against locking
    /// integrate them over different domains.
    ///
    /// The volumetric part is the term with λ or κ: a function U(J) for most laws, λ/2 tr²E for St Venant–Kirchhoff and λ/2 tr²(RᵀF − 1)
    /// for the corotational law. The isochoric part is all the rest, shear stiffness and fibres. It is evaluated at F itself, not at
    /// J^(−1/3) F, so it is not the isochoric part of Flory's split, and it may resist a change of volume too. At rest a part may have
    /// a pressure that the other one balances (no law here has one). Neither has λ < 0 at small strain; `None` where nothing is left
    /// for the volumetric part.
    fn split(self) -> Option<[Self; 2]>;

    /// The same with the volumetric part of the energy times a factor, ≥ 0.
    fn with_volumetric(self, factor: f64) -> Self;
}

/// m \[Pa\] and H, column after column, of the families of four elements.
pub type FourFamilies = [(Lanes, [FourVectors; 3]); FAMILIES];

const NO_FAMILIES: FourFamilies = [(Lanes([0.0; LANES]), [[Lanes([0.0; LANES]); 3]; 3]); FAMILIES];

impl Constants for Lame {
    #[inline(always)]
    fn elasticity(&self) -> Elasticity {
        Elasticity::isotropic(*self)
    }

    /// The terms with μ and with λ. With λ ≤ 0 the volumetric part would have no minimum.
    fn split(self) -> Option<[Self; 2]> {
        let shear = Self {
            lambda: 0.0,
            ..self
        };
        let pressure = Self { mu: 0.0, ..self };
        (self.lambda > 0.0).then_some([shear, pressure])
    }

    fn with_volumetric(self, factor: f64) -> Self {
        Self {
            lambda: factor * self.lambda,
            ..self
        }
    }
}

/// What a material gives to a law beside E and ν, as a rule ratios of moduli, so that E alone scales all stresses; `()` for a law of these
/// two alone. The default is what comparisons take.
pub trait Parameters: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// Reads the parameters: `value` gives the number of a key of the file, or an error if it is missing. The keys are those of
    /// [`LawName::parameters`](super::LawName::parameters), in its order.
    fn read<E>(value: &dyn Fn(&'static str) -> Result<f64, E>) -> Result<Self, E>;

    /// An error that names the first value out of range; the range may depend on Poisson's ratio.
    fn check(&self, poisson: f64) -> Result<(), MaterialError>;
}

impl Parameters for () {
    fn read<E>(_value: &dyn Fn(&'static str) -> Result<f64, E>) -> Result<Self, E> {
        Ok(())
    }

    fn check(&self, _poisson: f64) -> Result<(), MaterialError> {
        Ok(())
    }
}
