//! Stiff fibres lock linear elements, whatever they are smoothed over.

use microsim_mesh::{Block, CellSplit};
use microsim_tissue::law::{FibreParameters, MaterialLaw};
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Material, Method, Newton, Serial,
    State, build_model,
};
use nalgebra::Vector3;

/// Length of the beam \[m\]; height and width are half of it.
const LENGTH: f64 = 0.04;

/// Sag at rest \[m\] of the free end of a beam with fibres at 0.5 rad to its axis in the plane of bending.
fn sag(cells: usize, fibre_ratio: f64, discretisation: Discretisation) -> f64 {
    let block = Block {
        center: [0.0; 3],
        size: [LENGTH, 0.5 * LENGTH, 0.5 * LENGTH],
        cells: [2 * cells, cells, cells],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block");
    let (sine, cosine) = libm::sincos(0.5);
    mesh.directions = vec![[Vector3::new(cosine, 0.0, sine), Vector3::zeros()]; mesh.tets.len()];
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: MaterialLaw::TransverselyIsotropic(FibreParameters { fibre_ratio }),
            young: 1e5,
            poisson: 0.3,
            discretisation,
            plasticity: None,
        }),
    };
    let end = 0.4999 * LENGTH;
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < -end).collect();
    let model = build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new()).expect("a model");
    let method = Method::QuasiStatic(Newton {
        iterations: 100,
        tolerance: 1e-9,
        must_converge: true,
    });
    let mut state = State::at_rest(&model);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -1.0),
        ..Control::default()
    };
    let mut solver = method.solver(&model).expect("a solver");
    solver
        .step(&model, &mut state, &control, &[], 1.0, &Serial)
        .expect("an equilibrium");
    let rest = model.rest_positions();
    let ends: Vec<usize> = (0..rest.len()).filter(|&n| rest[n].x > end).collect();
    let sum: f64 = ends.iter().map(|&n| rest[n].z - state.positions[n].z).sum();
    sum / ends.len() as f64
}

/// The table in the limitations of the law: sag with two cells over the height relative to that with eight.
#[test]
fn stiff_fibres_lock_as_the_law_states() {
    use Discretisation::{Selective, Tetrahedra};
    for (fibre_ratio, discretisation, expected) in [
        (1.0, Selective, 0.92),
        (10.0, Selective, 0.93),
        (100.0, Selective, 0.73),
        (1000.0, Selective, 0.55),
        (10.0, Tetrahedra, 0.69),
        (100.0, Tetrahedra, 0.58),
    ] {
        let found = sag(2, fibre_ratio, discretisation) / sag(8, fibre_ratio, discretisation);
        assert!(
            (found - expected).abs() < 0.01,
            "{fibre_ratio} {discretisation:?}: {found}"
        );
    }
}
