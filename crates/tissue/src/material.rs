//! What a body is made of: checked values in, sets of elements out.
//!
//! A material belongs to a region of a mesh; layers are regions with materials of their own. Static values are physical
//! (NUMERICS 1.1): moduli in pascals, not constants of a mesh.

mod continuum;
mod part;
mod springs;

pub use continuum::ContinuumConstants;
pub(crate) use part::{Carried, EnergyPart, Part};
pub use springs::{
    Coefficients, Fit, KindConstants, SpringConstants, SpringForm, SpringModuli, fit,
};

use crate::elements::Elements;
use crate::range::{MaterialError, not_negative, positive};
use microsim_mesh::TetMesh;
use std::sync::Arc;

/// What a region of a body is made of: density, damping, elasticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Density \[kg/m³\], > 0.
    pub density: f64,
    /// Time τ of Kelvin–Voigt damping \[s\], ≥ 0: the stress of a strain rate ε̇ is that of the strain τ ε̇. For a viscosity η
    /// \[Pa·s\] in uniaxial stretch τ = η/E.
    pub relaxation_time: f64,
    /// How it resists deformation.
    pub behaviour: Behaviour,
}

/// How a material resists deformation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Behaviour {
    /// Springs along the edges, and areas and volumes of the tetrahedra.
    Springs(SpringConstants),
    /// A continuum of a material law.
    Continuum(ContinuumConstants),
}

impl Material {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        positive("density", self.density, "> 0 kg/m³")?;
        not_negative("relaxation_time", self.relaxation_time, ">= 0 s")?;
        match &self.behaviour {
            Behaviour::Springs(constants) => constants.check(),
            Behaviour::Continuum(constants) => constants.check(),
        }
    }

    /// How many fibre directions it needs in each element of the mesh.
    pub fn directions(&self) -> usize {
        match &self.behaviour {
            Behaviour::Springs(_) => 0,
            Behaviour::Continuum(constants) => constants.law.directions(),
        }
    }

    /// Whether it does not flow, or [can](ContinuumConstants::can_flow).
    pub fn can_flow(&self) -> bool {
        match &self.behaviour {
            Behaviour::Springs(_) => true,
            Behaviour::Continuum(constants) => constants.can_flow(),
        }
    }

    /// Whether its elements are [quadratic](microsim_vocabulary::Discretisation::is_quadratic).
    pub fn is_quadratic(&self) -> bool {
        match &self.behaviour {
            Behaviour::Springs(_) => false,
            Behaviour::Continuum(constants) => constants.discretisation.is_quadratic(),
        }
    }

    /// The elements of `mesh` with the indices `elements`, made of this material, part by part.
    pub(crate) fn build(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
    ) -> Vec<(Carried, Arc<dyn Elements>)> {
        match &self.behaviour {
            Behaviour::Springs(constants) => {
                constants.build_parts(mesh, elements, self.relaxation_time)
            }
            Behaviour::Continuum(constants) => {
                constants.build(mesh, elements, self.relaxation_time)
            }
        }
    }
}
