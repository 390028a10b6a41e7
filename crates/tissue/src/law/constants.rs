//! What the functions of a law take beside the deformation gradient.

use super::elasticity::{Elasticity, Lame};
use crate::range::MaterialError;
use nalgebra::Vector3;
use std::fmt::Debug;

/// The constants of a law as its functions take them: moduli, and the fibre direction where it has one.
pub trait Constants: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Whether the law needs a fibre direction in each element.
    const HAS_DIRECTION: bool = false;

    /// The same with the fibre direction a₀, a unit vector in the rest state; itself where there is none.
    #[inline(always)]
    fn along(self, _direction: Vector3<f64>) -> Self {
        self
    }

    /// The elasticity at rest: what bounds of the step, mass floors and viscosity go by.
    fn elasticity(&self) -> Elasticity;

    /// Those of the isochoric and of the volumetric part of the energy, each of which has a lowest value at rest up to a constant
    /// stress that the other one balances; `None` where the law has no resistance to volume to be split off.
    ///
    /// Discretisations against locking integrate the two over different domains. Fibres belong to the isochoric part.
    fn split(self) -> Option<[Self; 2]>;
}

impl Constants for Lame {
    #[inline(always)]
    fn elasticity(&self) -> Elasticity {
        Elasticity::isotropic(*self)
    }

    /// The terms of μ and of λ. A part with λ ≤ 0 alone would have no lowest energy.
    fn split(self) -> Option<[Self; 2]> {
        let shear = Self {
            lambda: 0.0,
            ..self
        };
        let pressure = Self { mu: 0.0, ..self };
        (self.lambda > 0.0).then_some([shear, pressure])
    }
}

/// What a law is given beside E and ν; `()` for a law of these two alone.
pub trait Parameters: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// Those of these values by their keys in files ([`LawName::parameters`](super::LawName::parameters)), or the error of the first
    /// that is not there.
    fn read<E>(value: &dyn Fn(&'static str) -> Result<f64, E>) -> Result<Self, E>;

    /// Whether all values are in range, together with Poisson's ratio.
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
