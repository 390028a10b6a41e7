//! Continua: Young's modulus and Poisson's ratio of a material in, elements of a law and a discretisation out.

use super::{Carried, MaterialError, positive};
use crate::elements::key::Key;
use crate::elements::{
    Continuum, EDGE_SHARE, Elements, NODE_SHARE, Smoothed, SmoothingDomains, Tetrahedra,
};
use crate::law::{Lame, Law, with_law};
use microsim_mesh::TetMesh;
use microsim_vocabulary::{Discretisation, LawName};
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
}
