//! The model of a body from a mesh and the materials of its regions.

use crate::elements::{Elements, QuadraturePoints, equivalent_strain};
use crate::material::{Behaviour, Material, Part};
use crate::model::{ModelError, TissueModel};
use crate::range::MaterialError;
use microsim_mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

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
    /// The law of a region needs fibre directions in each element of the mesh, and one lacks some.
    Direction {
        /// The region.
        region: u32,
        /// The first element that lacks some.
        element: u32,
        /// How many directions the law needs.
        families: usize,
    },
    /// A region is made of springs and has prestretches.
    PrestretchedSprings {
        /// The region.
        region: u32,
    },
    /// An element has a prestretch that is no deformation.
    Prestretch {
        /// The first such element.
        element: u32,
    },
    /// The discretisation of a region is quadratic, and its elements are not the parts of tetrahedra with ten nodes, or one is too
    /// curved.
    Quadratic {
        /// The region.
        region: u32,
    },
    /// The material of a region flows, and its discretisation carries a volumetric part apart that flow would change.
    Plasticity {
        /// The region.
        region: u32,
    },
    /// The material of a region yields by the prestretch of its elements alone: their residual stress would be gone after one step.
    YieldsAtRest {
        /// The region.
        region: u32,
        /// The element that is strained most.
        element: u32,
        /// Equivalent logarithmic strain of its prestretch.
        strain: f64,
        /// The strain at which the material yields.
        yield_strain: f64,
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
            Self::Direction {
                region,
                element,
                families: 1,
            } => write!(
                f,
                "the law of region {region} needs a fibre direction in each element, and element {element} has none"
            ),
            Self::Direction {
                region,
                element,
                families,
            } => write!(
                f,
                "the law of region {region} needs {families} fibre directions in each element, and element {element} has fewer"
            ),
            Self::PrestretchedSprings { region } => write!(
                f,
                "region {region} is made of springs, which have no prestretch: take the law of a continuum"
            ),
            Self::Prestretch { element } => write!(
                f,
                "the prestretch of element {element} is no deformation gradient: it needs finite numbers and a positive determinant"
            ),
            Self::Quadratic { region } => write!(
                f,
                "quadratic tetrahedra of region {region} are the parts of a refined mesh, eight each and whole, with middles of edges near their straight places"
            ),
            Self::Plasticity { region } => write!(
                f,
                "the material of region {region} cannot flow: plastic flow preserves volumes, and the volumetric part of its law, which its discretisation carries apart, is no function of the volume alone; take tetrahedra, edge-smoothed, node-smoothed or quadratic, or another law"
            ),
            Self::YieldsAtRest {
                region,
                element,
                strain,
                yield_strain,
            } => write!(
                f,
                "the material of region {region} yields at a strain of {yield_strain:.3}, and the residual state of element {element} alone is a strain of {strain:.3}: yielding counts from the natural state, so expected is a larger `yield_strain`, or no residual state"
            ),
            Self::Model(source) => write!(f, "{source}"),
        }
    }
}

impl std::error::Error for BuildError {}

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
    let is_deformation =
        |g: &Matrix3<f64>| g.iter().all(|x| x.is_finite()) && g.determinant() > 0.0;
    if let Some(element) = mesh.prestretches.iter().position(|g| !is_deformation(g)) {
        return Err(BuildError::Prestretch {
            element: element as u32,
        });
    }
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
        let families = material.directions();
        let lacks = |element: &&u32| {
            let fibres = mesh.fibres(**element as usize);
            fibres[..families].contains(&Vector3::zeros())
        };
        if let Some(&element) = elements.iter().find(lacks) {
            return Err(BuildError::Direction {
                region,
                element,
                families,
            });
        }
        let stretched = |e: &u32| mesh.prestretch(*e as usize) != Matrix3::identity();
        if matches!(material.behaviour, Behaviour::Springs(_)) && elements.iter().any(stretched) {
            return Err(BuildError::PrestretchedSprings { region });
        }
        if material.is_quadratic() && !QuadraturePoints::fit(mesh, &elements) {
            return Err(BuildError::Quadratic { region });
        }
        if !material.can_flow() {
            return Err(BuildError::Plasticity { region });
        }
        if let Some(yields) = yields_at_rest(mesh, &elements, region, &material.behaviour) {
            return Err(yields);
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

/// The error if elements with prestretches yield as they lie.
fn yields_at_rest(
    mesh: &TetMesh,
    elements: &[u32],
    region: u32,
    behaviour: &Behaviour,
) -> Option<BuildError> {
    let Behaviour::Continuum(constants) = behaviour else {
        return None;
    };
    let yield_strain = constants.plasticity?.yield_strain;
    let strained = elements.iter().filter_map(|&element| {
        let prestretch = mesh.prestretches.get(element as usize)?;
        Some((equivalent_strain(prestretch)?, element))
    });
    let most = strained.reduce(|most, next| if next.0 > most.0 { next } else { most });
    let (strain, element) = most.filter(|(strain, _)| *strain > yield_strain)?;
    Some(BuildError::YieldsAtRest {
        region,
        element,
        strain,
        yield_strain,
    })
}
