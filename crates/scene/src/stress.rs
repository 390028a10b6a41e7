//! Stress and strain of each element, for pictures and reports.
//!
//! The deformation is that of the tetrahedron itself, whatever smoothing its discretisation does.

use crate::spec::BodySpec;
use microsim_mesh::TetMesh;
use microsim_tissue::elements::PlasticState;
use microsim_tissue::law::decomposition;
use microsim_tissue::{Behaviour, ContinuumConstants, Material};
use nalgebra::{Matrix3, Vector3};

/// Elastic Cauchy stress σ = P Fᵀ/J of each element of `mesh`, that of the body as it is now, with its nodes at `positions` \[m\], in pascals. `flowed`
/// is what has [flowed](microsim_tissue::TissueModel::plastic_states) in each element; empty where nothing flows.
/// Zero in regions that are no continuum and in elements without volume or inverted; `None` for a body without any continuum.
pub fn cauchy_stresses(
    body: &BodySpec,
    mesh: &TetMesh,
    positions: &[Vector3<f64>],
    flowed: &[PlasticState],
) -> Option<Vec<Matrix3<f64>>> {
    stresses(&body.materials, mesh, positions, flowed)
}

/// The same of the materials of the body.
pub(crate) fn stresses(
    materials: &[(u32, Material)],
    mesh: &TetMesh,
    positions: &[Vector3<f64>],
    flowed: &[PlasticState],
) -> Option<Vec<Matrix3<f64>>> {
    let continua: Vec<(u32, ContinuumConstants)> = materials
        .iter()
        .filter_map(|(region, material)| match material.behaviour {
            Behaviour::Continuum(constants) => Some((*region, constants)),
            Behaviour::Springs(_) => None,
        })
        .collect();
    if continua.is_empty() {
        return None;
    }
    let stresses = mesh.regions.iter().enumerate().map(|(element, region)| {
        let constants = continua.iter().find(|(of, _)| of == region);
        constants.map_or_else(Matrix3::zeros, |(_, constants)| {
            let f = deformation(mesh, element, positions);
            let flowed = flowed.get(element).unwrap_or(&PlasticState::START);
            constants.cauchy_stress(&f, mesh.fibres(element), flowed)
        })
    });
    Some(stresses.collect())
}

/// F of an element from its natural state: edges now times the inverse of the edges at rest, times its prestretch.
fn deformation(mesh: &TetMesh, element: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
    let edges = |[a, b, c, d]: [Vector3<f64>; 4]| Matrix3::from_columns(&[b - a, c - a, d - a]);
    let now = mesh.tets[element].map(|node| positions[node as usize]);
    let rest = edges(mesh.corners(element)).try_inverse();
    // A body with an element without volume cannot be built.
    edges(now) * rest.unwrap_or_else(Matrix3::identity) * mesh.prestretch(element)
}

/// Green's strain (FᵀF − 1)/2 from the natural state of each element of `mesh` with its nodes at `positions` \[m\].
pub fn green_strains(mesh: &TetMesh, positions: &[Vector3<f64>]) -> Vec<Matrix3<f64>> {
    let strains = (0..mesh.tets.len()).map(|element| {
        let f = deformation(mesh, element, positions);
        0.5 * (f.transpose() * f - Matrix3::identity())
    });
    strains.collect()
}

/// Largest principal stretch from the natural state of each element of `mesh` with its nodes at `positions` \[m\], by the deformation of its corners; with what has flowed.
pub fn largest_stretches(mesh: &TetMesh, positions: &[Vector3<f64>]) -> Vec<f64> {
    decomposition::largest_stretches(
        (0..mesh.tets.len()).map(|element| deformation(mesh, element, positions)),
    )
}

/// Von Mises stress √(3/2 s:s) of a stress with deviator s, in its unit.
pub fn von_mises(stress: &Matrix3<f64>) -> f64 {
    let deviator = stress - Matrix3::identity() * (stress.trace() / 3.0);
    (1.5 * deviator.norm_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_mesh::{Block, CellSplit};
    use microsim_tissue::elements::ContinuumPlasticity;
    use microsim_tissue::law::LawName;
    use microsim_tissue::{Discretisation, State, build_model, flow};
    use nalgebra::Rotation3;

    fn cube(cells: [usize; 3]) -> TetMesh {
        let block = Block {
            center: [0.0; 3],
            size: [1e-3; 3],
            cells,
            split: CellSplit::Kuhn,
        };
        block.mesh().expect("a block")
    }

    /// Simple shear γ of linear elasticity has σ_xz = μγ alone, so √3 μγ; a change of volume has none. All laws are linear
    /// elasticity up to γ².
    #[test]
    fn shear_has_its_stress_and_pressure_none() {
        let mesh = cube([1; 3]);
        let (young, poisson) = (1e5, 0.3);
        for law in LawName::ALL {
            let constants = ContinuumConstants {
                law: law.into(),
                young,
                poisson,
                discretisation: Discretisation::Tetrahedra,
                plasticity: None,
            };
            let material = Material {
                density: 1000.0,
                relaxation_time: 0.0,
                behaviour: Behaviour::Continuum(constants),
            };
            let body = BodySpec::new("cube", mesh.clone(), material);
            let shear = 1e-5;
            let sheared: Vec<Vector3<f64>> = mesh
                .positions
                .iter()
                .map(|p| p + Vector3::x() * (shear * p.z))
                .collect();
            let expected = 3f64.sqrt() * young / (2.0 * (1.0 + poisson)) * shear;
            let equivalent = |positions: &[Vector3<f64>]| -> Vec<f64> {
                let stresses = cauchy_stresses(&body, &mesh, positions, &[]).expect("a continuum");
                stresses.iter().map(von_mises).collect()
            };
            for stress in equivalent(&sheared) {
                assert!(
                    (stress / expected - 1.0).abs() < 10.0 * shear,
                    "{law:?} {stress}"
                );
            }
            let swollen: Vec<Vector3<f64>> = mesh.positions.iter().map(|p| p * 1.1).collect();
            for stress in equivalent(&swollen) {
                assert!(stress < 1e-9 * young, "{law:?} {stress}");
            }
        }
    }

    /// Uniaxial tension of St Venant–Kirchhoff, S = λ tr(E) 1 + 2μ E with Green's strain E: a free side has S = 0, which is E_side = −ν e for
    /// E_axis = e and leaves S_axis = Y e, with Young's modulus Y. The Cauchy stress F S Fᵀ/J is then Y e a/b² along the axis, a² = 1 + 2 e
    /// and b² = 1 − 2 ν e, and nothing else; its von Mises stress is the same.
    #[test]
    fn uniaxial_tension_has_one_stress_and_the_strains_of_its_stretches() {
        let mesh = cube([2; 3]);
        let (young, poisson, strain) = (1e5, 0.3, 0.2_f64);
        let constants = ContinuumConstants {
            law: LawName::StVenantKirchhoff.into(),
            young,
            poisson,
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        };
        let material = Material {
            density: 1000.0,
            relaxation_time: 0.0,
            behaviour: Behaviour::Continuum(constants),
        };
        let body = BodySpec::new("cube", mesh.clone(), material);
        let (a, b) = (
            (1.0 + 2.0 * strain).sqrt(),
            (1.0 - 2.0 * poisson * strain).sqrt(),
        );
        let stretches = Vector3::new(b, a, b);
        let positions: Vec<Vector3<f64>> = mesh
            .positions
            .iter()
            .map(|p| p.component_mul(&stretches))
            .collect();
        let stress = young * strain * a / (b * b);
        let expected = Matrix3::from_diagonal(&Vector3::new(0.0, stress, 0.0));
        let stresses = cauchy_stresses(&body, &mesh, &positions, &[]).expect("a continuum");
        assert_eq!(stresses.len(), mesh.tets.len());
        for found in stresses {
            assert!((found - expected).norm() < 1e-12 * stress, "{found}");
            assert!((von_mises(&found) / stress - 1.0).abs() < 1e-12);
        }
        let side = -poisson * strain;
        let expected = Matrix3::from_diagonal(&Vector3::new(side, strain, side));
        for found in green_strains(&mesh, &positions) {
            assert!((found - expected).norm() < 1e-14, "{found}");
        }
        // Turned as well, which is no stretch.
        let turn = Rotation3::new(Vector3::new(0.3, -1.1, 0.7));
        let turned: Vec<Vector3<f64>> = positions.iter().map(|p| turn * p).collect();
        let found: Vec<f64> = largest_stretches(&mesh, &turned);
        assert_eq!(found.len(), mesh.tets.len());
        assert!(found.iter().all(|of| (of - a).abs() < 1e-14), "{found:?}");
    }

    /// Stretched by a logarithmic strain of 0.3 at constant volume an incompressible deviator without hardening bears what it does at its yield
    /// strain y: σ_x − σ_y = μ (e^(2y) − e^(−y)) of the neo-Hookean law, whatever carries it; before the flow it is that of 0.3.
    #[test]
    fn the_stress_of_what_has_flowed_is_that_of_its_yield_strain() {
        let (young, poisson, strain, yielding) = (1e5, 0.3, 0.3, 0.02);
        let mu = young / (2.0 * (1.0 + poisson));
        let expected = |e: f64| mu * (libm::exp(2.0 * e) - libm::exp(-e));
        let across = libm::exp(-0.5 * strain);
        let stretches = Vector3::new(libm::exp(strain), across, across);
        for discretisation in Discretisation::ALL {
            let mut mesh = cube([1; 3]);
            if discretisation.is_quadratic() {
                mesh = mesh.refined().mesh;
            }
            let constants = ContinuumConstants {
                law: LawName::NeoHookean.into(),
                young,
                poisson,
                discretisation,
                plasticity: Some(ContinuumPlasticity {
                    yield_strain: yielding,
                    yield_growth: 0.0,
                    creep_rate: None,
                    max_strain: 1.0,
                    hardening: 0.0,
                    max_stiffening: 1.0,
                }),
            };
            let material = Material {
                density: 1000.0,
                relaxation_time: 0.0,
                behaviour: Behaviour::Continuum(constants),
            };
            let body = BodySpec::new("cube", mesh.clone(), material);
            let clamped = vec![false; mesh.positions.len()];
            let model = build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new());
            let model = model.expect("a body");
            let mut state = State::at_rest(&model);
            let rest = mesh.positions.iter();
            state.positions = rest.map(|p| p.component_mul(&stretches)).collect();
            for now in [strain, yielding] {
                let flowed = model.plastic_states(&mesh, &state).expect("it can flow");
                let stresses = cauchy_stresses(&body, &mesh, &state.positions, &flowed);
                for stress in stresses.expect("a continuum") {
                    let found = stress[(0, 0)] - stress[(1, 1)];
                    // Roundings of the pressure, which is of the size of the modulus.
                    assert!(
                        (found - expected(now)).abs() < 1e-12 * young,
                        "{discretisation:?}"
                    );
                }
                flow(&model, &mut state, 1.0);
            }
        }
    }
}
