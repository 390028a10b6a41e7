//! Bodies and numbers of the tests of this crate.

use crate::build::build_model;
use crate::law::LawName;
use crate::material::{Behaviour, ContinuumConstants, Material, SpringConstants};
use crate::model::TissueModel;
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_random::Congruential;
use microsim_vocabulary::Discretisation;
use nalgebra::Vector3;

/// Soft tissue of springs and volumes.
pub fn soft() -> Material {
    Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Springs(SpringConstants::scaled(25e3, 5e4)),
    }
}

/// A block around the origin.
pub fn block_mesh(size: [f64; 3], cells: [usize; 3]) -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size,
        cells,
        split: CellSplit::Kuhn,
    };
    block.mesh().unwrap()
}

/// Stable neo-Hookean tetrahedra of this density \[kg/m³\], modulus \[Pa\] and ratio of Poisson, without viscosity.
pub fn neo_hookean(density: f64, young: f64, poisson: f64) -> Material {
    Material {
        density,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young,
            poisson,
            discretisation: Discretisation::Tetrahedra,
            plasticity: None,
        }),
    }
}

/// The beam S of the reference (`tests/data/reference`) around the origin, stable neo-Hookean, clamped at its low end.
pub fn beam(poisson: f64) -> TissueModel {
    let mesh = block_mesh([0.1, 0.02, 0.02], [15, 3, 3]);
    let material = neo_hookean(1000.0, 1e5, poisson);
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < -0.0499).collect();
    build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new()).unwrap()
}

/// A block of 2 × 2 × 1 mm around the origin.
pub fn soft_block(cells: [usize; 3]) -> TetMesh {
    block_mesh([2e-3, 2e-3, 1e-3], cells)
}

/// Gives each element of a mesh fibre directions of its own, within half a radian of common ones.
pub fn fibres(mesh: &mut TetMesh) {
    let mut next = numbers();
    let oblique = [
        Vector3::new(0.48, -0.6, 0.64),
        Vector3::new(0.36, 0.48, 0.8),
    ];
    let mut near = |a: Vector3<f64>| (a + Vector3::from_fn(|_, _| next()) * 0.3).normalize();
    mesh.directions = mesh.tets.iter().map(|_| oblique.map(&mut near)).collect();
}

/// The body of a mesh of soft tissue, clamped where `clamp` is true of the rest position.
pub fn build(mesh: &TetMesh, clamp: impl Fn(&Vector3<f64>) -> bool) -> TissueModel {
    let clamped: Vec<bool> = mesh.positions.iter().map(clamp).collect();
    build_model(mesh, &[(0, soft())], &clamped, 0.0, Vec::new()).unwrap()
}

/// A fixed sequence of numbers in −1..1.
pub fn numbers() -> impl FnMut() -> f64 {
    let mut random = Congruential(7);
    move || random.number()
}
