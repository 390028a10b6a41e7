//! Stress of each element, for pictures and reports.

use crate::spec::BodySpec;
use microsim_mesh::TetMesh;
use microsim_tissue::{Behaviour, ContinuumConstants};
use nalgebra::{Matrix3, Vector3};

/// Von Mises stress of each element of `mesh`, that of the body as it is now, with its nodes at `positions` \[m\], in pascals: √(3/2 s:s) of the elastic Cauchy stress
/// σ = P Fᵀ/J with deviator s. 0 in regions that are no continuum and in elements without
/// volume or inverted; `None` for a body without any.
///
/// The deformation is that of the tetrahedron itself, whatever smoothing its discretisation does.
pub fn von_mises(body: &BodySpec, mesh: &TetMesh, positions: &[Vector3<f64>]) -> Option<Vec<f64>> {
    let continua: Vec<(u32, ContinuumConstants)> = body
        .materials
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
        constants.map_or(0.0, |(_, constants)| {
            let f = deformation(mesh, element, positions);
            let direction = mesh.direction(element).unwrap_or_default();
            equivalent(&constants.cauchy_stress(&f, direction))
        })
    });
    Some(stresses.collect())
}

/// F of an element: edges now times the inverse of the edges at rest.
fn deformation(mesh: &TetMesh, element: usize, positions: &[Vector3<f64>]) -> Matrix3<f64> {
    let edges = |[a, b, c, d]: [Vector3<f64>; 4]| Matrix3::from_columns(&[b - a, c - a, d - a]);
    let now = mesh.tets[element].map(|node| positions[node as usize]);
    let rest = edges(mesh.corners(element)).try_inverse();
    // A body with an element without volume cannot be built.
    edges(now) * rest.unwrap_or_else(Matrix3::identity)
}

fn equivalent(stress: &Matrix3<f64>) -> f64 {
    let deviator = stress - Matrix3::identity() * (stress.trace() / 3.0);
    (1.5 * deviator.norm_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_mesh::{Block, CellSplit};
    use microsim_tissue::law::LawName;
    use microsim_tissue::{Discretisation, Material};

    /// Simple shear γ of linear elasticity has σ_xz = μγ alone, so √3 μγ; a change of volume has none. All laws are linear
    /// elasticity up to γ².
    #[test]
    fn shear_has_its_stress_and_pressure_none() {
        let block = Block {
            center: [0.0; 3],
            size: [1e-3; 3],
            cells: [1; 3],
            split: CellSplit::Kuhn,
        };
        let mesh = block.mesh().expect("a block");
        let (young, poisson) = (1e5, 0.3);
        for law in LawName::ALL {
            let constants = ContinuumConstants {
                law: law.into(),
                young,
                poisson,
                discretisation: Discretisation::Tetrahedra,
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
            for stress in von_mises(&body, &mesh, &sheared).expect("a continuum") {
                assert!(
                    (stress / expected - 1.0).abs() < 10.0 * shear,
                    "{law:?} {stress}"
                );
            }
            let swollen: Vec<Vector3<f64>> = mesh.positions.iter().map(|p| p * 1.1).collect();
            for stress in von_mises(&body, &mesh, &swollen).expect("a continuum") {
                assert!(stress < 1e-9 * young, "{law:?} {stress}");
            }
        }
    }
}
