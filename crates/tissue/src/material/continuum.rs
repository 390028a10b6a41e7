//! Continua: Young's modulus and Poisson's ratio of a material in, elements of a law and a discretisation out.

use super::{Carried, MaterialError, positive};
use crate::elements::key::Key;
use crate::elements::{
    Continuum, EDGE_SHARE, Elements, NODE_SHARE, Smoothed, SmoothingDomains, Tetrahedra,
};
use crate::law::{Lame, Law, LawName, with_law};
use microsim_mesh::TetMesh;
use nalgebra::Matrix3;
use std::sync::Arc;

/// Constants of a continuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuumConstants {
    /// The material law.
    pub law: LawName,
    /// Young's modulus E \[Pa\], > 0.
    pub young: f64,
    /// Poisson's ratio ν, > −1 and < 0.5.
    pub poisson: f64,
    /// How the mesh carries it.
    pub discretisation: Discretisation,
}

/// How the tetrahedra of a mesh carry a continuum.
///
/// Linear tetrahedra are too stiff in bending, and lock when the tissue is nearly incompressible: more volumes want to be kept
/// than nodes can move (NUMERICS 1.6). Share of the right static sag of the cantilever there (quadratic hexahedra, 34.43, 33.87
/// and 33.7 mm) with the neo-Hookean law at ν = 0.3 / 0.45 / 0.49, largest explicit step on M at ν = 0.49:
///
/// | | S, 3 cells high | M, 7 cells high | step |
/// |---|---|---|---|
/// | tetrahedra | 73 / 53 / 25 % | 93 / 84 / 58 % | 42 µs |
/// | edge-smoothed | 98 / 91 / 74 % | 100 / 99 / 95 % | 47 µs |
/// | node-smoothed | 116 / 114 / 112 % | 104 / 104 / 103 % | 54 µs |
/// | selective | 101 / 97 / 93 % | 101 / 100 / 99 % | 54 µs |
/// | nodal-pressure | 80 / 77 / 73 % | 96 / 94 / 93 % | 53 µs |
/// | patch-pressure | 81 / 80 / 79 % | 96 / 95 / 95 % | |
///
/// The other laws differ by less than 1 % (the last row is that of the stable neo-Hookean law). Take selective where it can be paid
/// for, and patch-pressure with implicit methods in real time: its matrices couple hardly more nodes than those of tetrahedra. A
/// static solution of M takes 1.5 (ν = 0.3) to 2.5 times (0.49) as long as with tetrahedra, with nodal-pressure 3.5 to 5 times, with
/// selective 4 to 7 times (`microsim chart --quick`; `cargo xtask bench kernels` and `bench solvers` have the parts).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Discretisation {
    /// The tetrahedra themselves.
    Tetrahedra,
    /// Domains around edges (ES-FEM-T4). Right in bending, locks late.
    EdgeSmoothed,
    /// Domains around nodes (NS-FEM-T4). Does not lock, but is too soft: no mode without energy, yet a crowd of short waves with
    /// hardly any. In a free block of 4 × 3 × 3 cells the 14 lowest modes lie between 46 and 61 Hz, the lowest with
    /// tetrahedra is at 80, around edges at 63 Hz.
    NodeSmoothed,
    /// The part of μ around edges, the part of λ around nodes (selective ES/NS-FEM-T4; Onishi, Amaya 2014). Neither locks nor
    /// has soft short waves.
    Selective,
    /// The part of μ in tetrahedra, the part of λ around nodes: the pressure of the averaged volume of a node (after Bonet &
    /// Burton 1998; their volume is the mean of the volumes, here it is that of the mean deformation gradient). Does not lock,
    /// but stays as stiff in bending as tetrahedra without pressure.
    NodalPressure,
    /// The part of μ in tetrahedra, the part of λ in patches of about five around a common edge: one pressure for each, of the volume
    /// of the mean deformation gradient (after the patches of de Souza Neto et al. 2005). Does not lock: there are fewer patches than
    /// nodes. As stiff in bending as nodal-pressure. After a cut the patches that it touched are formed anew.
    PatchPressure,
}

impl Discretisation {
    /// All discretisations.
    pub const ALL: [Self; 6] = [
        Self::Tetrahedra,
        Self::EdgeSmoothed,
        Self::NodeSmoothed,
        Self::Selective,
        Self::NodalPressure,
        Self::PatchPressure,
    ];

    /// Names of all discretisations, in the order of [`ALL`](Self::ALL).
    pub const NAMES: [&'static str; 6] = [
        "tetrahedra",
        "edge-smoothed",
        "node-smoothed",
        "selective",
        "nodal-pressure",
        "patch-pressure",
    ];

    /// Its name in files and reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The discretisation of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }

    /// Whether the volumes of single tetrahedra make the body too stiff at this Poisson's ratio: from there on the cantilever S
    /// loses at least 7 % of its sag to them.
    pub fn locks(self, poisson: f64) -> bool {
        match self {
            Self::Tetrahedra => poisson >= 0.4,
            Self::EdgeSmoothed => poisson >= 0.45,
            Self::NodeSmoothed | Self::Selective | Self::NodalPressure | Self::PatchPressure => {
                false
            }
        }
    }
}

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
            allowed: "> -1 and < 0.5; for incompressible tissue take 0.49 with the discretisation selective or patch-pressure",
        })
    }

    /// The elastic Cauchy stress P Fᵀ/det F \[Pa\] at the deformation gradient `f`. Where the volume is gone to rounding, or
    /// inverted, there is no such stress and it is zero.
    pub fn cauchy_stress(&self, f: &Matrix3<f64>) -> Matrix3<f64> {
        let (volume, size) = (f.determinant(), f.norm());
        if volume <= f64::EPSILON * size * size * size {
            return Matrix3::zeros();
        }
        let lame = Lame::from_young_poisson(self.young, self.poisson);
        with_law!(self.law, L => L::stress(f, &lame)) * f.transpose() / volume
    }

    /// The parts, one or two, each of one set.
    fn parts(&self) -> Vec<Carried> {
        let lame = Lame::from_young_poisson(self.young, self.poisson);
        // A part with λ ≤ 0 alone would have no lowest energy; without pressure nothing locks either, so nothing is split.
        let split = lame.lambda > 0.0;
        let shear = Lame {
            lambda: 0.0,
            ..lame
        };
        let pressure = Lame { mu: 0.0, ..lame };
        match self.discretisation {
            Discretisation::Tetrahedra => vec![Carried::Tetrahedra(lame)],
            Discretisation::EdgeSmoothed => vec![Carried::Edges(lame)],
            Discretisation::NodeSmoothed => vec![Carried::Nodes(lame)],
            Discretisation::Selective if split => {
                vec![Carried::Edges(shear), Carried::Nodes(pressure)]
            }
            Discretisation::Selective => vec![Carried::Edges(lame)],
            Discretisation::NodalPressure if split => {
                vec![Carried::Tetrahedra(shear), Carried::Nodes(pressure)]
            }
            Discretisation::NodalPressure => vec![Carried::Tetrahedra(lame)],
            Discretisation::PatchPressure if split => {
                vec![Carried::Tetrahedra(shear), Carried::Patches(pressure)]
            }
            Discretisation::PatchPressure => vec![Carried::Tetrahedra(lame)],
        }
    }

    /// The elements of the mesh with these indices, as one or two sets.
    pub(super) fn build(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        relaxation_time: f64,
    ) -> Vec<(Carried, Arc<dyn Elements>)> {
        let set = |carried| match carried {
            Carried::Edges(lame) => {
                let domains = SmoothingDomains::around_edges(mesh, elements);
                self.smoothed(domains, lame, relaxation_time)
            }
            Carried::Nodes(lame) => {
                let domains = SmoothingDomains::around_nodes(mesh, elements);
                self.smoothed(domains, lame, relaxation_time)
            }
            Carried::Patches(lame) => {
                let domains = SmoothingDomains::of_patches(mesh, elements);
                self.smoothed(domains, lame, relaxation_time)
            }
            _ => self.tetrahedra(mesh, elements, carried, relaxation_time),
        };
        let parts = self.parts().into_iter();
        parts.map(|carried| (carried, set(carried))).collect()
    }

    /// Elements of one of the sets: those with these keys, each with all tetrahedra that have a share in it, ascending.
    pub(super) fn build_around(
        &self,
        carried: Carried,
        mesh: &TetMesh,
        around: &[(Key, u32)],
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        match carried {
            Carried::Edges(lame) => {
                let domains = SmoothingDomains::around(mesh, around, EDGE_SHARE);
                self.smoothed(domains, lame, relaxation_time)
            }
            Carried::Nodes(lame) => {
                let domains = SmoothingDomains::around(mesh, around, NODE_SHARE);
                self.smoothed(domains, lame, relaxation_time)
            }
            _ => {
                let elements: Vec<u32> = around.iter().map(|(_, element)| *element).collect();
                self.tetrahedra(mesh, &elements, carried, relaxation_time)
            }
        }
    }

    /// Elements that are patches of these tetrahedra: ascending pairs of patch and tetrahedron.
    pub(super) fn build_patches(
        &self,
        lame: Lame,
        mesh: &TetMesh,
        members: &[(u32, u32)],
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        self.smoothed(SmoothingDomains::of(mesh, members), lame, relaxation_time)
    }

    fn smoothed(
        &self,
        domains: SmoothingDomains,
        lame: Lame,
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        with_law!(self.law, L => Arc::new(Smoothed::<L>::new(domains, lame, relaxation_time)))
    }

    fn tetrahedra(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        carried: Carried,
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        let lame = match carried {
            Carried::Tetrahedra(lame) => lame,
            _ => Lame::from_young_poisson(self.young, self.poisson),
        };
        let domains = Tetrahedra::new(mesh, elements);
        with_law!(self.law, L => Arc::new(Continuum::<L>::new(domains, lame, relaxation_time)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

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
            assert!(
                message.starts_with("young is") && message.ends_with("> 0 Pa"),
                "{message}"
            );
        }
        for poisson in [0.5, 0.6, -1.0, f64::NAN] {
            let message = constants(1e4, poisson).check().unwrap_err().to_string();
            assert!(
                message.contains("take 0.49") && message.contains("selective"),
                "{message}"
            );
        }
    }

    /// Uniaxial strain of 1e-6: σ = (λ + 2μ) ε across it, λ ε beside it, up to ε². Flat and turned inside out: none.
    #[test]
    fn stress_is_that_of_linear_elasticity_and_none_without_volume() {
        let strain = 1e-6;
        let Lame { mu, lambda } = Lame::from_young_poisson(3e4, 0.4);
        let expected = Vector3::new(lambda, lambda, lambda + 2.0 * mu) * strain;
        for law in LawName::ALL {
            let constants = ContinuumConstants {
                law,
                ..constants(3e4, 0.4)
            };
            let stretched = |z| Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, z));
            let stress = constants.cauchy_stress(&stretched(1.0 + strain));
            let error = stress - Matrix3::from_diagonal(&expected);
            assert!(
                error.norm() < 10.0 * strain * expected.norm(),
                "{law:?} {stress}"
            );
            for gone in [0.0, 1e-17, -1.0] {
                assert_eq!(constants.cauchy_stress(&stretched(gone)), Matrix3::zeros());
            }
        }
    }

    #[test]
    fn names_lead_back_to_their_discretisations() {
        for (one, name) in Discretisation::ALL.into_iter().zip(Discretisation::NAMES) {
            assert_eq!(
                (one.name(), Discretisation::from_name(name)),
                (name, Some(one))
            );
        }
        assert_eq!(Discretisation::from_name("hexahedra"), None);
    }
}
