//! Springs, triangles and volumes: constants of a material in, stiffness of each element out.
//!
//! There are four forms of the constants; elements know the plain one alone.
//!
//! - *Plain* (4.1, 4.2): E = ½ k (q − q0)², one k for all elements of a kind.
//! - *Normalised* (THMG04; 3.5–3.8): E = ½ k ((q − q0)/q̃0)², so k_plain = k/q̃0². q̃0 is q0; for an element that is nearly
//!   flat it is that of the regular one with the same mean edge length l̄: (√2/12) l̄³ for a tetrahedron (NUMERICS 1.1), (√3/4)
//!   l̄² for a triangle.
//! - *Scaled*: moduli in pascals, whose energy does not depend on how fine the mesh is. Springs carry k = Σ c·E·L0 over the
//!   tetrahedra around the edge, c = 2√2/25 (Lloyd, Székely, Harders 2007, for near-regular tetrahedra); triangles E = ½ α V_f
//!   ((A − A0)/Ã0)², V_f a quarter of the volume of the tetrahedra at the face; volumes E = ½ κ V0 ((V − V0)/Ṽ0)².
//! - *Fitted* to Young's modulus and Poisson's ratio: see [`fit`].
//!
//! Plain and normalised constants are those of a mesh: the same k on a finer one is another material. Triangles are all faces
//! of the tetrahedra, each once. Every region brings elements of its own: an edge on an interface carries a spring of each.
//!
//! Limitations: a spring network has a Poisson's ratio of its own, ¼, and is anisotropic unless the mesh is balanced
//! ([`Fit::error`]); strong volume forces lock on linear tetrahedra (NUMERICS 1.6).

mod edges;
mod fit;
mod region;

pub use fit::{Fit, fit};

use super::Carried;
use crate::elements::key::Key;
use crate::elements::{
    Area, Constraint, ConstraintSet, Elements, Length, Measure, Plasticity, Volume,
};
use crate::range::{MaterialError, not_negative, positive};
use microsim_mesh::TetMesh;
use region::Region;
use std::sync::Arc;

/// A material of springs, triangles and volumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringConstants {
    /// Its constants.
    pub form: SpringForm,
    /// Flow of rest lengths, areas and volumes, if they flow.
    pub plasticity: Option<Plasticity>,
}

/// What constants of springs mean: four forms in which they can be given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpringForm {
    /// k in N/m, N/m³ and N/m⁵, k_d in N·s/m, N·s/m³ and N·s/m⁵ for springs, triangles and volumes.
    Plain(KindConstants),
    /// k in J, k_d in J·s.
    Normalised(KindConstants),
    /// Moduli of any mesh.
    Scaled(SpringModuli),
    /// Fitted to a continuum.
    Fitted {
        /// Young's modulus \[Pa\], > 0.
        young: f64,
        /// Poisson's ratio, 0 to below 0.5; below ¼ the springs keep ¼.
        poisson: f64,
    },
}

/// Constants for each kind of element: edges, triangles and tetrahedra.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KindConstants {
    /// Of springs.
    pub length: Coefficients,
    /// Of triangles.
    pub area: Coefficients,
    /// Of volumes.
    pub volume: Coefficients,
}

/// Stiffness and damping of one kind of element; their units depend on the form.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// k, ≥ 0.
    pub stiffness: f64,
    /// k_d of (3.8), ≥ 0; viscosity by relaxation time comes on top.
    pub damping: f64,
}

/// Moduli of springs, triangles and volumes that do not depend on the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpringModuli {
    /// E of the springs \[Pa\], ≥ 0.
    pub stretch: f64,
    /// α of the triangles \[Pa\], ≥ 0.
    pub area: f64,
    /// κ of the volumes \[Pa\], ≥ 0.
    pub volume: f64,
}

impl SpringConstants {
    /// Springs and volumes by moduli \[Pa\], without triangles and flow.
    pub fn scaled(stretch: f64, volume: f64) -> Self {
        let area = 0.0;
        Self {
            form: SpringForm::Scaled(SpringModuli {
                stretch,
                area,
                volume,
            }),
            plasticity: None,
        }
    }

    /// Fitted to Young's modulus \[Pa\] and Poisson's ratio, without flow.
    pub fn fitted(young: f64, poisson: f64) -> Self {
        Self {
            form: SpringForm::Fitted { young, poisson },
            plasticity: None,
        }
    }

    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        if let Some(plasticity) = &self.plasticity {
            plasticity.check()?;
        }
        match &self.form {
            SpringForm::Plain(constants) | SpringForm::Normalised(constants) => {
                let KindConstants {
                    length,
                    area,
                    volume,
                } = constants;
                not_negative("length stiffness", length.stiffness, ">= 0")?;
                not_negative("length damping", length.damping, ">= 0")?;
                not_negative("area stiffness", area.stiffness, ">= 0")?;
                not_negative("area damping", area.damping, ">= 0")?;
                not_negative("volume stiffness", volume.stiffness, ">= 0")?;
                not_negative("volume damping", volume.damping, ">= 0")?;
                let sum = length.stiffness + area.stiffness + volume.stiffness;
                positive("the sum of all stiffnesses", sum, "> 0")
            }
            SpringForm::Scaled(moduli) => {
                not_negative("stretch modulus", moduli.stretch, ">= 0 Pa")?;
                not_negative("area modulus", moduli.area, ">= 0 Pa")?;
                not_negative("volume modulus", moduli.volume, ">= 0 Pa")?;
                let sum = moduli.stretch + moduli.area + moduli.volume;
                positive("the sum of all moduli", sum, "> 0 Pa")
            }
            SpringForm::Fitted { young, poisson } => {
                positive("young", *young, "> 0 Pa")?;
                if (0.0..0.5).contains(poisson) {
                    return Ok(());
                }
                Err(MaterialError {
                    value_name: "poisson",
                    value: *poisson,
                    allowed: ">= 0 and < 0.5",
                })
            }
        }
    }

    /// One spring per edge of these elements, one triangle per face, one volume per element, as far as they resist anything.
    pub(super) fn build(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        relaxation_time: f64,
    ) -> Vec<Arc<dyn Elements>> {
        let parts = self.build_parts(mesh, elements, relaxation_time);
        parts.into_iter().map(|(_, set)| set).collect()
    }

    /// As [`build`](Self::build), with what each set is.
    pub(super) fn build_parts(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        relaxation_time: f64,
    ) -> Vec<(Carried, Arc<dyn Elements>)> {
        let region = Region {
            mesh,
            elements,
            form: &self.form,
            relaxation_time,
        };
        let (springs, areas, volumes) = (region.springs(), region.areas(), region.volumes());
        let sets = [
            resists(&springs).then(|| (Carried::Springs, self.set::<Length, 2>(springs))),
            resists(&areas).then(|| (Carried::Areas, self.set::<Area, 3>(areas))),
            resists(&volumes).then(|| (Carried::Volumes, self.set::<Volume, 4>(volumes))),
        ];
        sets.into_iter().flatten().collect()
    }

    /// Elements of one of the sets: those with these keys, each with all tetrahedra that have a part in it, ascending.
    pub(super) fn build_around(
        &self,
        carried: Carried,
        mesh: &TetMesh,
        around: &[(Key, u32)],
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        let elements: Vec<u32> = around.iter().map(|(_, element)| *element).collect();
        let region = Region {
            mesh,
            elements: &elements,
            form: &self.form,
            relaxation_time,
        };
        match carried {
            Carried::Springs => self.set::<Length, 2>(region.springs_around(&keyed(around))),
            Carried::Areas => self.set::<Area, 3>(region.areas_around(&keyed(around))),
            _ => self.set::<Volume, 4>(region.volumes()),
        }
    }

    /// The set of these constraints.
    fn set<M: Measure<N>, const N: usize>(
        &self,
        constraints: Vec<Constraint<N>>,
    ) -> Arc<dyn Elements> {
        let set = ConstraintSet::<M, N>::new(constraints);
        Arc::new(match self.plasticity {
            Some(plasticity) => set.with_plasticity(plasticity),
            None => set,
        })
    }
}

/// Whether any of these constraints resists anything.
fn resists<const N: usize>(constraints: &[Constraint<N>]) -> bool {
    let resists = |c: &Constraint<N>| c.stiffness > 0.0 || c.damping > 0.0;
    constraints.iter().any(resists)
}

/// Keys of N nodes as these.
fn keyed<const N: usize>(around: &[(Key, u32)]) -> Vec<([u32; N], u32)> {
    let nodes = around.iter().map(|(key, element)| {
        let mut nodes = [0; N];
        nodes.copy_from_slice(&key.nodes()[..N]);
        (nodes, *element)
    });
    nodes.collect()
}

#[cfg(test)]
mod tests;
