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
use crate::model::{ModelError, TissueModel};
use crate::range::{MaterialError, not_negative, positive};
use microsim_mesh::TetMesh;
use std::sync::Arc;

/// A material.
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

/// Why a body cannot be made of its materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BuildError {
    /// A value of the material of a region is out of range.
    Material {
        /// The region.
        region: u32,
        /// Which value.
        source: MaterialError,
    },
    /// A region of the mesh has no material, or two.
    Region {
        /// The region.
        region: u32,
        /// How many it has.
        materials: usize,
    },
    /// The law of a region needs a fibre direction in each element of the mesh, and one has none.
    Direction {
        /// The region.
        region: u32,
        /// The first element without one.
        element: u32,
    },
    /// The mesh cannot be a body.
    Model(ModelError),
}

impl std::fmt::Display for BuildError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Material { region, source } => write!(f, "material of region {region}: {source}"),
            Self::Region { region, materials } => {
                write!(
                    f,
                    "region {region} of the mesh needs one material, not {materials}"
                )
            }
            Self::Direction { region, element } => write!(
                f,
                "the law of region {region} needs a fibre direction in each element, and element {element} has none"
            ),
            Self::Model(source) => write!(f, "{source}"),
        }
    }
}

impl std::error::Error for BuildError {}

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

    /// Whether it needs a fibre direction in each element of the mesh.
    pub fn has_direction(&self) -> bool {
        match &self.behaviour {
            Behaviour::Springs(_) => false,
            Behaviour::Continuum(constants) => constants.law.has_direction(),
        }
    }

    /// The elements of `mesh` with the indices `elements`, made of this material, part by part.
    fn build(&self, mesh: &TetMesh, elements: &[u32]) -> Vec<(Carried, Arc<dyn Elements>)> {
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

/// The model of a body: each region of `mesh` made of its material, `clamped[i]` fixes node `i`, `drag` per mass \[1/s\].
/// `more` are sets of elements that no region holds, such as couplings.
pub fn build_model(
    mesh: &TetMesh,
    materials: &[(u32, Material)],
    clamped: &[bool],
    drag: f64,
    more: Vec<Arc<dyn Elements>>,
) -> Result<TissueModel, BuildError> {
    let mut regions = mesh.regions.clone();
    regions.sort_unstable();
    regions.dedup();
    let mut densities = vec![0.0; mesh.tets.len()];
    let (mut sets, mut parts) = (Vec::new(), Vec::new());
    for region in regions {
        let mut of_region = materials.iter().filter(|(r, _)| *r == region);
        let material = match (of_region.next(), of_region.count()) {
            (Some((_, material)), 0) => material,
            (first, more) => {
                let materials = more + usize::from(first.is_some());
                return Err(BuildError::Region { region, materials });
            }
        };
        material
            .check()
            .map_err(|source| BuildError::Material { region, source })?;
        let elements: Vec<u32> = (0..mesh.tets.len() as u32)
            .filter(|&e| mesh.regions[e as usize] == region)
            .collect();
        if material.has_direction()
            && let Some(&element) = elements
                .iter()
                .find(|e| mesh.direction(**e as usize).is_none())
        {
            return Err(BuildError::Direction { region, element });
        }
        for &element in &elements {
            densities[element as usize] = material.density;
        }
        for (carried, set) in material.build(mesh, &elements) {
            sets.push(set);
            parts.push(Part {
                region,
                material: *material,
                carried,
            });
        }
    }
    sets.extend(more);
    let model = TissueModel::new(mesh, &densities, clamped, sets, drag);
    Ok(model.map_err(BuildError::Model)?.made_of(parts))
}
