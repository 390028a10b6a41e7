//! The parts of a material: each makes one set of elements, of a whole region or of what an edit of the mesh has touched.

use super::{Behaviour, Material};
use crate::elements::Elements;
use crate::elements::key::Key;
use microsim_mesh::TetMesh;
use std::sync::Arc;

/// Which part of the energy of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EnergyPart {
    /// All of it.
    Whole,
    /// All that is not volumetric: shear stiffness, fibres.
    Isochoric,
    /// The term with λ or κ.
    Volumetric,
    /// All but [`Excess`](Self::Excess).
    Moderate,
    /// Of the term with λ or κ what is above μ: the modulus λ − μ.
    Excess,
}

/// By what a part of a material is carried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Carried {
    /// Springs along the edges.
    Springs,
    /// The areas of the faces.
    Areas,
    /// The volumes of the tetrahedra.
    Volumes,
    /// A continuum in the tetrahedra.
    Tetrahedra(EnergyPart),
    /// A continuum around edges.
    Edges(EnergyPart),
    /// A continuum around nodes.
    Nodes(EnergyPart),
    /// A continuum in patches of tetrahedra.
    Patches(EnergyPart),
    /// A continuum at the points of quadrature of quadratic tetrahedra.
    Quadratic(EnergyPart),
    /// A continuum of the mean deformation of each quadratic tetrahedron.
    QuadraticMeans(EnergyPart),
}

impl Carried {
    /// Calls `visit` with the key of each element of the set of which a tetrahedron is a part.
    pub fn keys(&self, tet: &[u32; 4], mut visit: impl FnMut(Key)) {
        let [a, b, c, d] = *tet;
        match self {
            Self::Springs | Self::Edges(_) => {
                for edge in [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]] {
                    visit(Key::new(&edge));
                }
            }
            Self::Areas => {
                for face in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
                    visit(Key::new(&face));
                }
            }
            Self::Nodes(_) => tet.iter().for_each(|node| visit(Key::new(&[*node]))),
            Self::Volumes
            | Self::Tetrahedra(_)
            | Self::Patches(_)
            | Self::Quadratic(_)
            | Self::QuadraticMeans(_) => visit(Key::new(tet)),
        }
    }
}

/// What makes one set of elements of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// The region of the mesh.
    pub region: u32,
    /// Its material.
    pub material: Material,
    /// The part of it.
    pub carried: Carried,
}

impl Part {
    /// The elements of the set with the keys in `around`, each with all tetrahedra that have a part in it: ascending pairs.
    pub fn build_around(&self, mesh: &TetMesh, around: &[(Key, u32)]) -> Arc<dyn Elements> {
        let time = self.material.relaxation_time;
        match &self.material.behaviour {
            Behaviour::Springs(constants) => {
                constants.build_around(self.carried, mesh, around, time)
            }
            Behaviour::Continuum(constants) => {
                constants.build_around(self.carried, mesh, around, time)
            }
        }
    }

    /// Elements of the set that are patches of these tetrahedra: ascending pairs of patch and tetrahedron. None where it has no patches.
    pub fn build_patches(
        &self,
        mesh: &TetMesh,
        members: &[(u32, u32)],
    ) -> Option<Arc<dyn Elements>> {
        match (&self.material.behaviour, self.carried) {
            (Behaviour::Continuum(constants), Carried::Patches(part)) => {
                Some(constants.build_patches(part, mesh, members, self.material.relaxation_time))
            }
            _ => None,
        }
    }
}
