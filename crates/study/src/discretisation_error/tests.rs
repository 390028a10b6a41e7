use super::*;
use microsim_mesh::format::{MeshFormat, read_tet_mesh};
use microsim_mesh::{Block, CellSplit};
use microsim_tissue::ContinuumConstants;

fn material(poisson: f64, discretisation: Discretisation) -> Vec<(u32, Material)> {
    let constants = ContinuumConstants {
        law: LawName::NeoHookean.into(),
        young: 1e5,
        poisson,
        discretisation,
        plasticity: None,
    };
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(constants),
    };
    vec![(0, material)]
}

/// The displacement that is estimated for a mesh held where x is smallest.
fn estimate(mesh: &TetMesh, materials: &[(u32, Material)]) -> DiscretisationError {
    let least = mesh
        .positions
        .iter()
        .map(|x| x.x)
        .fold(f64::INFINITY, f64::min);
    let held: Vec<bool> = mesh.positions.iter().map(|x| x.x < least + 1e-9).collect();
    discretisation_error(mesh, materials, &held).expect("an estimate")
}

fn beam(cells: [usize; 3]) -> TetMesh {
    let block = Block {
        center: [0.05, 0.0, 0.0],
        size: [0.1, 0.02, 0.02],
        cells,
        split: CellSplit::Kuhn,
    };
    block.mesh().expect("a mesh")
}

/// Fractions of the right sag by an independent code with quadratic hexahedra (`tests/data/reference/cantilever.md`).
#[test]
fn a_structured_beam_is_as_far_off_as_an_independent_code_has_it() {
    let mesh = beam([15, 3, 3]);
    for (poisson, expected) in [(0.3, 0.73), (0.45, 0.53), (0.49, 0.25)] {
        let found = estimate(&mesh, &material(poisson, Discretisation::Tetrahedra));
        let off = found.displacement - expected;
        assert!(off.abs() < 0.04, "ν = {poisson}: {found:?}");
        assert!((found.selective - 1.0).abs() < 0.1, "{found:?}");
        assert_ne!(found.axis, 0, "it bends");
    }
}

/// It is that of the body without residual stress.
#[test]
fn residual_stress_changes_nothing() {
    let materials = material(0.3, Discretisation::Tetrahedra);
    let mut mesh = beam([6, 2, 2]);
    let without = estimate(&mesh, &materials);
    let compressed = Matrix3::from_diagonal(&Vector3::new(0.5, 1.4, 1.4));
    mesh.prestretches = vec![compressed; mesh.tets.len()];
    assert_eq!(estimate(&mesh, &materials), without);
}

/// Without a constant that is fitted to regular meshes it holds on others: a plate whose sag is known from finer meshes.
#[test]
fn an_unstructured_plate_that_is_far_off_is_found() {
    let bytes = include_bytes!("../../tests/plate.msh");
    let mut mesh = read_tet_mesh(MeshFormat::Gmsh, &[bytes])
        .expect("a mesh")
        .mesh;
    mesh.positions.iter_mut().for_each(|x| *x *= 1e-3);
    let found = estimate(&mesh, &material(0.49, Discretisation::PatchPressure));
    assert!((found.displacement - 0.34).abs() < 0.05, "{found:?}");
    assert!((found.selective - 0.58).abs() < 0.05, "{found:?}");
}

#[test]
fn what_cannot_be_estimated_is_none() {
    let mesh = beam([4, 1, 1]);
    let materials = material(0.3, Discretisation::Tetrahedra);
    let nothing_held = vec![false; mesh.positions.len()];
    assert_eq!(discretisation_error(&mesh, &materials, &nothing_held), None);
    let springs = Material {
        behaviour: Behaviour::Springs(microsim_tissue::SpringConstants::fitted(1e5, 0.3)),
        ..materials[0].1
    };
    let held: Vec<bool> = mesh.positions.iter().map(|x| x.x < 1e-9).collect();
    assert_eq!(discretisation_error(&mesh, &[(0, springs)], &held), None);
    // A part that nothing holds does not fall: it counts as held, and the other is estimated as by itself.
    let mut two = mesh.clone();
    two.append(&beam([2, 1, 1]), 0);
    let mut held_two = held.clone();
    held_two.resize(two.positions.len(), false);
    let [one, both] = [
        discretisation_error(&mesh, &materials, &held),
        discretisation_error(&two, &materials, &held_two),
    ];
    let (one, both) = (one.expect("an estimate"), both.expect("an estimate"));
    assert!(
        (one.displacement - both.displacement).abs() < 1e-4,
        "{one:?} {both:?}"
    );
}
