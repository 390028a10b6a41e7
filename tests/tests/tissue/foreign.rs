//! Meshes that others made (`assets/meshes`), imported and computed: what holds them carries their weight.

use crate::beam::GRAVITY;
use microsim_mesh::defects;
use microsim_mesh::format::{MeshFormat, read_tet_mesh};
use microsim_tests::repository;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Forces, Material, Method, Newton,
    Serial, State, build_model,
};
use nalgebra::Vector3;

/// Path and format.
const MESHES: [(&str, MeshFormat); 3] = [
    ("sfepy/cylinder.vtk", MeshFormat::VtkLegacy),
    ("sfepy/cylinder_in_box.msh", MeshFormat::Gmsh),
    ("meshio/02_raw_compressed.vtu", MeshFormat::Vtu),
];

#[test]
fn what_holds_a_foreign_mesh_carries_its_weight() {
    for (name, format) in MESHES {
        let path = repository().join("assets/meshes").join(name);
        let bytes = std::fs::read(&path).expect("the mesh");
        let mesh = read_tet_mesh(format, &[&bytes]).expect("a mesh").mesh;
        assert_eq!(defects(&mesh).len(), 0, "{name}");
        let (low, high) = mesh
            .positions
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (low.min(p.x), high.max(p.x))
            });
        let clamped: Vec<bool> = mesh
            .positions
            .iter()
            .map(|p| p.x < low + 1e-6 * (high - low))
            .collect();
        // Stiff enough for the size of each mesh that the weight strains it by a few per cent.
        let material = Material {
            density: 1000.0,
            relaxation_time: 0.0,
            behaviour: Behaviour::Continuum(ContinuumConstants {
                law: LawName::StableNeoHookean.into(),
                young: 30.0 * 1000.0 * 9.81 * (high - low),
                poisson: 0.45,
                discretisation: Discretisation::Selective,
                plasticity: None,
            }),
        };
        let mut regions = mesh.regions.clone();
        regions.sort_unstable();
        regions.dedup();
        let materials: Vec<_> = regions
            .into_iter()
            .map(|region| (region, material))
            .collect();
        let model = build_model(&mesh, &materials, &clamped, 0.0, Vec::new()).expect("a model");
        let control = Control {
            gravity: GRAVITY,
            ..Control::default()
        };
        let newton = Newton {
            iterations: 60,
            tolerance: 1e-9,
            must_converge: true,
        };
        let mut state = State::at_rest(&model);
        let mut solver = Method::QuasiStatic(newton)
            .solver(&model)
            .expect("a solver");
        solver
            .step(&model, &mut state, &control, &[], 1.0, &Serial)
            .expect("an equilibrium");

        // The force on a clamped node is what the clamp holds: together, the weight, as closely as the rest is balanced.
        let mut forces = Forces::new(&model);
        let forces = forces.compute(&model, &state, &control, &Serial);
        let held: Vector3<f64> = model
            .clamped()
            .iter()
            .map(|&node| forces[node as usize])
            .sum();
        let weight = GRAVITY * model.masses().iter().sum::<f64>();
        println!(
            "{name}: {} tetrahedra, weight {:.4e} N",
            mesh.tets.len(),
            weight.norm()
        );
        assert!(
            (held - weight).norm() < 1e-7 * weight.norm(),
            "{name}: {held} {weight}"
        );
        let sag =
            (0..model.node_count()).map(|i| model.rest_positions()[i].z - state.positions[i].z);
        assert!(sag.fold(0.0, f64::max) > 1e-3 * (high - low), "{name} sags");
    }
}
