//! Continua: Young's modulus and Poisson's ratio of a material in, elements of a law and a discretisation out.

use super::{Carried, EnergyPart};
use crate::elements::key::Key;
use crate::elements::{
    Continuum, ContinuumPlasticity, ContinuumSet, Domains, EDGE_FRACTION, Elements, NODE_FRACTION,
    PlasticSet, PlasticState, Quadratic, QuadraturePoints, Smoothed, SmoothingDomains, Tetrahedra,
};
use crate::law::{Constants, Lame, Law, MaterialLaw, with_law};
use crate::range::{MaterialError, positive, require};
use microsim_mesh::{FAMILIES, TetMesh};
use microsim_vocabulary::Discretisation;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A continuum: law, Young's modulus, Poisson's ratio and discretisation.
///
/// ```
/// use microsim_tissue::law::{FibreParameters, LawName, MaterialLaw};
/// use microsim_tissue::{ContinuumConstants, Discretisation};
///
/// let muscle = ContinuumConstants {
///     law: MaterialLaw::TransverselyIsotropic(FibreParameters { fibre_ratio: 4.0 }),
///     young: 20e3,
///     poisson: 0.45,
///     discretisation: Discretisation::Selective,
///     plasticity: None,
/// };
/// assert!(muscle.check().is_ok() && muscle.law.directions() == 1);
/// let fat = ContinuumConstants {
///     law: LawName::NeoHookean.into(),
///     ..muscle
/// };
/// assert!(fat.law.directions() == 0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuumConstants {
    /// The material law, with what it is given beside E and ν.
    pub law: MaterialLaw,
    /// Young's modulus E at small strain \[Pa\], > 0; with fibres that of their matrix.
    pub young: f64,
    /// Poisson's ratio ν at small strain, > −1 and < 0.5; with fibres that of their matrix.
    pub poisson: f64,
    /// How the mesh carries it.
    pub discretisation: Discretisation,
    /// Its plastic flow, if it flows.
    pub plasticity: Option<ContinuumPlasticity>,
}

impl ContinuumConstants {
    /// Whether all values are in range.
    pub fn check(&self) -> Result<(), MaterialError> {
        positive("young", self.young, "> 0 Pa")?;
        require(
            self.poisson > -1.0 && self.poisson < 0.5,
            "poisson",
            self.poisson,
            "> -1 and < 0.5; for incompressible tissue take 0.49 with the discretisation selective or patch-pressure",
        )?;
        if let Some(plasticity) = &self.plasticity {
            plasticity.check()?;
        }
        self.law.check(self.poisson)
    }

    /// Whether it is elastic, or can flow: plastic flow is isochoric, so the volumetric part of the energy, where it is integrated over
    /// other domains, must be a [function of J alone](microsim_vocabulary::LawName::is_volumetric_of_j).
    pub fn can_flow(&self) -> bool {
        let apart = self.discretisation.is_split() && !self.law.name().is_volumetric_of_j();
        self.plasticity.is_none() || !apart
    }

    /// The elastic Cauchy stress P Fᵀ/det F \[Pa\] at the deformation gradient `f` of an element with these fibre directions, which an
    /// isotropic law ignores, and with what has flowed in it. Where the volume is gone to rounding, or
    /// inverted, there is no such stress and it is zero.
    pub fn cauchy_stress(
        &self,
        f: &Matrix3<f64>,
        directions: [Vector3<f64>; FAMILIES],
        flowed: &PlasticState,
    ) -> Matrix3<f64> {
        let (volume, size) = (f.determinant(), f.norm());
        if volume <= f64::EPSILON * size * size * size {
            return Matrix3::zeros();
        }
        let stress = with_law!(&self.law, L, p => {
            flowed.stress::<L>(f, &L::constants(&self.lame(), p).along(directions))
        });
        stress * f.transpose() / volume
    }

    /// Lamé's constants of E and ν.
    pub(crate) fn lame(&self) -> Lame {
        Lame::from_young_poisson(self.young, self.poisson)
    }

    /// The parts, one or two, each of one set.
    fn parts(&self) -> Vec<Carried> {
        use EnergyPart::{Excess, Isochoric, Moderate, Volumetric, Whole};
        let lame = self.lame();
        // Without pressure nothing locks, so nothing is split.
        let split = with_law!(&self.law, L, p => L::constants(&lame, p).split().is_some());
        let excess = with_law!(&self.law, L, p => excess_fraction(&L::constants(&lame, p)) > 0.0);
        match self.discretisation {
            Discretisation::EdgeSmoothed => vec![Carried::Edges(Whole)],
            Discretisation::NodeSmoothed => vec![Carried::Nodes(Whole)],
            Discretisation::Selective if split => {
                vec![Carried::Edges(Isochoric), Carried::Nodes(Volumetric)]
            }
            Discretisation::Selective => vec![Carried::Edges(Whole)],
            Discretisation::NodalPressure if split => {
                vec![Carried::Tetrahedra(Isochoric), Carried::Nodes(Volumetric)]
            }
            Discretisation::PatchPressure if split => {
                vec![Carried::Tetrahedra(Isochoric), Carried::Patches(Volumetric)]
            }
            Discretisation::QuadraticPressure if excess => {
                vec![
                    Carried::Quadratic(Moderate),
                    Carried::QuadraticMeans(Excess),
                ]
            }
            Discretisation::Quadratic | Discretisation::QuadraticPressure => {
                vec![Carried::Quadratic(Whole)]
            }
            Discretisation::Tetrahedra
            | Discretisation::NodalPressure
            | Discretisation::PatchPressure => vec![Carried::Tetrahedra(Whole)],
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
            Carried::Edges(part) => {
                let domains = SmoothingDomains::around_edges(mesh, elements);
                self.smoothed(domains, part, relaxation_time)
            }
            Carried::Nodes(part) => {
                let domains = SmoothingDomains::around_nodes(mesh, elements);
                self.smoothed(domains, part, relaxation_time)
            }
            Carried::Patches(part) => {
                let domains = SmoothingDomains::of_patches(mesh, elements);
                self.smoothed(domains, part, relaxation_time)
            }
            Carried::Quadratic(part) => {
                let points = QuadraturePoints::of(mesh, elements);
                self.quadratic(points, part, relaxation_time)
            }
            Carried::QuadraticMeans(part) => {
                let means = QuadraturePoints::of(mesh, elements).means();
                self.quadratic(means, part, relaxation_time)
            }
            _ => self.tetrahedra(mesh, elements, carried, relaxation_time),
        };
        let parts = self.parts().into_iter();
        parts.map(|carried| (carried, set(carried))).collect()
    }

    /// Elements of one of the sets: those with these keys, each with all tetrahedra that have a part in it, ascending.
    pub(super) fn build_around(
        &self,
        carried: Carried,
        mesh: &TetMesh,
        around: &[(Key, u32)],
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        match carried {
            Carried::Edges(part) => {
                let domains = SmoothingDomains::around(mesh, around, EDGE_FRACTION);
                self.smoothed(domains, part, relaxation_time)
            }
            Carried::Nodes(part) => {
                let domains = SmoothingDomains::around(mesh, around, NODE_FRACTION);
                self.smoothed(domains, part, relaxation_time)
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
        part: EnergyPart,
        mesh: &TetMesh,
        members: &[(u32, u32)],
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        self.smoothed(SmoothingDomains::of(mesh, members), part, relaxation_time)
    }

    fn smoothed(
        &self,
        domains: SmoothingDomains,
        part: EnergyPart,
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        let lame = self.lame();
        with_law!(&self.law, L, p => {
            let constants = of_part(L::constants(&lame, p), part);
            self.set(Smoothed::<L>::new(domains, constants, relaxation_time), part)
        })
    }

    fn quadratic(
        &self,
        points: QuadraturePoints,
        part: EnergyPart,
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        let lame = self.lame();
        with_law!(&self.law, L, p => {
            let constants = of_part(L::constants(&lame, p), part);
            self.set(Quadratic::<L>::new(points, constants, relaxation_time), part)
        })
    }

    fn tetrahedra(
        &self,
        mesh: &TetMesh,
        elements: &[u32],
        carried: Carried,
        relaxation_time: f64,
    ) -> Arc<dyn Elements> {
        let part = match carried {
            Carried::Tetrahedra(part) => part,
            _ => EnergyPart::Whole,
        };
        let domains = Tetrahedra::new(mesh, elements);
        let lame = self.lame();
        with_law!(&self.law, L, p => {
            let constants = of_part(L::constants(&lame, p), part);
            self.set(Continuum::<L>::new(domains, constants, relaxation_time), part)
        })
    }

    /// A set that carries this part of the energy: one that flows, if the material does. What is a function of J alone does not see flow.
    fn set<L: Law, D: Domains>(
        &self,
        set: ContinuumSet<L, D>,
        part: EnergyPart,
    ) -> Arc<dyn Elements> {
        match (self.plasticity, part) {
            (None, _) | (_, EnergyPart::Volumetric | EnergyPart::Excess) => Arc::new(set),
            (Some(plasticity), _) => Arc::new(PlasticSet::new(set, plasticity)),
        }
    }
}

/// The constants of a part of the energy; of what cannot be split the whole.
fn of_part<C: Constants>(constants: C, part: EnergyPart) -> C {
    match (part, constants.split()) {
        (EnergyPart::Isochoric, Some([isochoric, _])) => isochoric,
        (EnergyPart::Volumetric, Some([_, volumetric])) => volumetric,
        (EnergyPart::Moderate, _) => constants.with_volumetric(1.0 - excess_fraction(&constants)),
        (EnergyPart::Excess, Some([_, volumetric])) => {
            volumetric.with_volumetric(excess_fraction(&constants))
        }
        _ => constants,
    }
}

/// The fraction of the volumetric part of the energy without which λ is μ, or as near to it as can be.
fn excess_fraction<C: Constants>(constants: &C) -> f64 {
    let Some([_, volumetric]) = constants.split() else {
        return 0.0;
    };
    let Lame { mu, lambda } = constants.elasticity().lame;
    ((lambda - mu) / volumetric.elasticity().lame.lambda).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::{Configuration, NodeWindow};
    use crate::law::{LawName, MooneyRivlinConstants, MooneyRivlinParameters};
    use crate::testing::block_mesh;

    fn constants(young: f64, poisson: f64) -> ContinuumConstants {
        ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young,
            poisson,
            discretisation: Discretisation::Selective,
            plasticity: None,
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
                law: law.into(),
                ..constants(3e4, 0.4)
            };
            // Fibres would pull as well: none are there.
            let cauchy_stress = |f: &Matrix3<f64>| {
                constants.cauchy_stress(f, Default::default(), &PlasticState::START)
            };
            let stretched = |z| Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, z));
            let stress = cauchy_stress(&stretched(1.0 + strain));
            let error = stress - Matrix3::from_diagonal(&expected);
            assert!(
                error.norm() < 10.0 * strain * expected.norm(),
                "{law:?} {stress}"
            );
            for gone in [0.0, 1e-17, -1.0] {
                assert_eq!(cauchy_stress(&stretched(gone)), Matrix3::zeros());
            }
        }
    }

    /// Where the pressure of a Mooney–Rivlin law is all in its isochoric part, at the least ν = r/(1 + 2 r) of its range, nothing is split
    /// off, and a split of next to nothing just above it gives the same forces.
    #[test]
    fn a_law_without_volumetric_part_is_whole() {
        let none = MooneyRivlinConstants {
            c10: 0.3,
            c01: 0.1,
            volumetric: 0.0,
        };
        assert_eq!(none.split(), None);
        let c01_fraction = 0.5;
        let law = MaterialLaw::MooneyRivlin(MooneyRivlinParameters { c01_fraction });
        let mesh = block_mesh([1.0; 3], [1; 3]).refined().mesh;
        let all: Vec<u32> = (0..mesh.tets.len() as u32).collect();
        let place = |p: &Vector3<f64>| Vector3::new(1.1 * p.x, p.y + 0.2 * p.x * p.z, 0.9 * p.z);
        let positions: Vec<_> = mesh.positions.iter().map(place).collect();
        let at = Configuration {
            positions: &positions,
            velocities: &vec![Vector3::zeros(); positions.len()],
            internal: &[],
        };
        for discretisation in Discretisation::ALL {
            let forces = |poisson, sets| {
                let constants = ContinuumConstants {
                    law,
                    discretisation,
                    ..constants(3e4, poisson)
                };
                assert_eq!(constants.check(), Ok(()));
                let built = constants.build(&mesh, &all, 0.0);
                assert_eq!(built.len(), sets, "{discretisation:?}");
                let mut values = vec![Vector3::zeros(); positions.len()];
                for (_, set) in built {
                    let window = &mut NodeWindow {
                        first: 0,
                        values: &mut values,
                    };
                    set.add_forces(0..set.count(), &at, window);
                }
                values
            };
            let parts = constants(3e4, 0.4);
            let parts = ContinuumConstants {
                discretisation,
                ..parts
            }
            .parts()
            .len();
            // 0.5/(1 + 2·0.5), and λ = 4c₀₁ there, are exact.
            let (whole, split) = (forces(0.25, 1), forces(0.25 + 1e-10, parts));
            let largest = whole.iter().map(Vector3::norm).fold(0.0, f64::max);
            for (a, b) in whole.iter().zip(&split) {
                assert!(
                    (a - b).norm() < 1e-8 * largest,
                    "{discretisation:?}: {a} {b}"
                );
            }
        }
    }

    #[test]
    fn parameters_of_the_law_are_checked_with_the_ratio() {
        let law = MaterialLaw::MooneyRivlin(MooneyRivlinParameters { c01_fraction: 1.0 });
        let of = |poisson| ContinuumConstants {
            law,
            ..constants(3e4, poisson)
        };
        assert_eq!(of(0.4).check(), Ok(()));
        assert_eq!(of(0.3).check().unwrap_err().value_name, "poisson");
    }
}
