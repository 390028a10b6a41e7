//! The beam: 0.1 × 0.02 × 0.02 m, clamped over the face x = 0, under gravity along −z.

use microsim_mesh::TetMesh;
use microsim_mesh::format::{MeshFormat, read_tet_mesh};
use microsim_tests::repository;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Material, Method, Newton, Serial,
    State, TissueModel, build_model,
};
use nalgebra::Vector3;
use serde_json::Value;

/// Length \[m\].
pub const LENGTH: f64 = 0.1;

/// Gravity \[m/s²\].
pub const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// The reference values, whole.
pub fn reference() -> Value {
    let path = repository().join("tests/data/reference/cantilever.json");
    let text = std::fs::read_to_string(path).expect("the reference");
    serde_json::from_str(&text).expect("JSON")
}

/// A value of the reference \[m\], by its path.
pub fn expected(path: &str) -> f64 {
    let found = reference().pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no value at {path}"))
}

/// Laws with their names in the reference.
pub const LAWS: [(LawName, &str); 4] = [
    (LawName::StVenantKirchhoff, "stvk"),
    (LawName::NeoHookean, "neo_hookean"),
    (LawName::Corotational, "corotational"),
    (LawName::StableNeoHookean, "stable_neo_hookean"),
];

/// The mesh S or M of the reference, read from its file.
pub fn mesh(name: &str) -> TetMesh {
    let path = repository().join(format!("tests/data/reference/cantilever-{name}.msh"));
    let bytes = std::fs::read(path).expect("the mesh");
    read_tet_mesh(MeshFormat::Gmsh, &[&bytes])
        .expect("a mesh")
        .mesh
}

/// The beam of a law, a Poisson's ratio and a discretisation.
pub fn beam(
    mesh: &TetMesh,
    law: LawName,
    poisson: f64,
    discretisation: Discretisation,
) -> TissueModel {
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: law.into(),
            young: 1e5,
            poisson,
            discretisation,
            plasticity: None,
        }),
    };
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < 1e-9).collect();
    let regions = mesh.regions.first().map(|&region| (region, material));
    build_model(
        mesh,
        &regions.into_iter().collect::<Vec<_>>(),
        &clamped,
        0.0,
        Vec::new(),
    )
    .expect("a model")
}

/// Mean of −z displacements of the nodes of the free end \[m\].
pub fn sag(model: &TissueModel, state: &State) -> f64 {
    let ends: Vec<usize> = (0..model.node_count())
        .filter(|&node| model.rest_positions()[node].x > LENGTH * (1.0 - 1e-6))
        .collect();
    let sum: f64 = ends
        .iter()
        .map(|&node| model.rest_positions()[node].z - state.positions[node].z)
        .sum();
    sum / ends.len() as f64
}

/// The sag at rest under gravity \[m\], solved to 1e-9 of the forces.
pub fn static_sag(model: &TissueModel) -> f64 {
    let method = Method::QuasiStatic(Newton {
        iterations: 60,
        tolerance: 1e-9,
        must_converge: true,
    });
    let mut state = State::at_rest(model);
    let control = Control {
        gravity: GRAVITY,
        ..Control::default()
    };
    let mut solver = method.solver(model).expect("a solver");
    solver
        .step(model, &mut state, &control, &[], 1.0, &Serial)
        .expect("an equilibrium");
    sag(model, &state)
}
