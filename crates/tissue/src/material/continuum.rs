//! Continua: Young's modulus and Poisson's ratio of a material in, elements of a law and a discretisation out.

use super::{MaterialError, positive};
use crate::elements::{Continuum, Elements, Smoothed, SmoothingDomains, Tetrahedra};
use crate::law::{Lame, Law, LawName, with_law};
use microsim_mesh::TetMesh;
use std::sync::Arc;

/// Constants of a continuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuumConstants {
    /// The material law.
    pub law: LawName,
    /// Young's modulus E [Pa], > 0.
    pub young: f64,
    /// Poisson's ratio ν, > −1 and < 0.5.
    pub poisson: f64,
    /// How the mesh carries it.
    pub discretisation: Discretisation,
}

/// How the tetrahedra of a mesh carry a continuum.
///
/// Six tetrahedra per cell have more volumes than nodes to move: the more volume counts, the less they can do. What is left of
/// the sag of the cantilever of NUMERICS 1.6 on its meshes S (3 cells through the height) and M (7):
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Discretisation {
    /// The tetrahedra themselves.
    Tetrahedra,
    /// Domains around edges.
    EdgeSmoothed,
    /// Domains around nodes.
    NodeSmoothed,
    /// The part of μ around edges, the part of λ around nodes.
    Selective,
    /// The part of μ in tetrahedra, the part of λ around nodes.
    NodalPressure,
}

impl Discretisation {
    /// All discretisations.
    pub const ALL: [Self; 5] = [
        Self::Tetrahedra,
        Self::EdgeSmoothed,
        Self::NodeSmoothed,
        Self::Selective,
        Self::NodalPressure,
    ];

    /// Names of all discretisations, in the order of [`ALL`](Self::ALL).
    pub const NAMES: [&'static str; 5] = [
        "tetrahedra",
        "edge-smoothed",
        "node-smoothed",
        "selective",
        "nodal-pressure",
    ];

    /// Its name in files and reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The discretisation of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }

    /// Whether the elements lock at this Poisson's ratio.
    pub fn locks(self, poisson: f64) -> bool {
        match self {
            Self::Tetrahedra | Self::EdgeSmoothed => poisson >= LOCKING_POISSON,
            Self::NodeSmoothed | Self::Selective | Self::NodalPressure => false,
        }
    }
}

/// Poisson's ratio from which on volumes of single tetrahedra lock.
const LOCKING_POISSON: f64 = 0.4;

impl ContinuumConstants {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        positive("young", self.young, "> 0 Pa")?;
        if self.poisson > -1.0 && self.poisson < 0.5 {
            return Ok(());
        }
        Err(MaterialError {
            value_name: "poisson",
            value: self.poisson,
            allowed: "> -1 and < 0.5; for incompressible tissue take 0.49 with the discretisation selective or nodal-pressure",
        })
    }

    /// The elements of the mesh with these indices, as one or two sets.
    pub(super) fn build(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        relaxation_time: f64,
    ) -> Vec<Arc<dyn Elements>> {
        with_law!(self.law, L => self.build_law::<L>(mesh, elements, relaxation_time))
    }

    fn build_law<L: Law>(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        relaxation_time: f64,
    ) -> Vec<Arc<dyn Elements>> {
        let lame = Lame::from_young_poisson(self.young, self.poisson);
        let tetrahedra = |lame| -> Arc<dyn Elements> {
            let domains = Tetrahedra::new(mesh, elements);
            Arc::new(Continuum::<L>::new(domains, lame, relaxation_time))
        };
        let smoothed = |domains, lame| -> Arc<dyn Elements> {
            Arc::new(Smoothed::<L>::new(domains, lame, relaxation_time))
        };
        let edges = |lame| smoothed(SmoothingDomains::around_edges(mesh, elements), lame);
        let nodes = |lame| smoothed(SmoothingDomains::around_nodes(mesh, elements), lame);
        // A part with λ ≤ 0 alone would have no lowest energy; without pressure nothing locks either, so nothing is split.
        let split = lame.lambda > 0.0;
        let shear = Lame { lambda: 0.0, ..lame };
        let pressure = Lame { mu: 0.0, ..lame };
        match self.discretisation {
            Discretisation::Tetrahedra => vec![tetrahedra(lame)],
            Discretisation::EdgeSmoothed => vec![edges(lame)],
            Discretisation::NodeSmoothed => vec![nodes(lame)],
            Discretisation::Selective if split => vec![edges(shear), nodes(pressure)],
            Discretisation::Selective => vec![edges(lame)],
            Discretisation::NodalPressure if split => vec![tetrahedra(shear), nodes(pressure)],
            Discretisation::NodalPressure => vec![tetrahedra(lame)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constants(young: f64, poisson: f64) -> ContinuumConstants {
        ContinuumConstants {
            law: LawName::StableNeoHookean,
            young,
            poisson,
            discretisation: Discretisation::Selective,
        }
    }

    #[test]
    fn moduli_out_of_range_are_named_with_the_remedy() {
        assert_eq!(constants(1e4, 0.49).check(), Ok(()));
        assert_eq!(constants(1e4, -0.5).check(), Ok(()));
        for young in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let message = constants(young, 0.3).check().unwrap_err().to_string();
            assert!(message.starts_with("young is") && message.ends_with("> 0 Pa"), "{message}");
        }
        for poisson in [0.5, 0.6, -1.0, f64::NAN] {
            let message = constants(1e4, poisson).check().unwrap_err().to_string();
            assert!(message.contains("take 0.49") && message.contains("selective"), "{message}");
        }
    }

    #[test]
    fn names_lead_back_to_their_discretisations() {
        for (one, name) in Discretisation::ALL.into_iter().zip(Discretisation::NAMES) {
            assert_eq!((one.name(), Discretisation::from_name(name)), (name, Some(one)));
        }
        assert_eq!(Discretisation::from_name("hexahedra"), None);
    }
}
