//! Times of the forces of each kind of element on a block of 35 × 7 × 7 cells (10,290 tetrahedra).
//!
//! `cargo run --release -p microsim-tissue --example bench_kernels [repetitions]`; the fastest repetition counts. The body is
//! bent and stretched a little, so that no branch is that of the rest shape.

use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Forces, Material, Serial,
    SpringConstants, State, build_model,
};
use nalgebra::Vector3;
use std::time::Instant;

fn main() {
    let repetitions = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(50);
    let block = Block {
        center: [0.0; 3],
        size: [0.1, 0.02, 0.02],
        cells: [35, 7, 7],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("a block with positive sizes");
    println!("behaviour                                   ns per tetrahedron, elastic and viscous");
    let springs = Behaviour::Springs(SpringConstants::scaled(1e5, 1e5));
    print_row("springs and volumes", &mesh, springs, repetitions);
    for law in LawName::ALL {
        for discretisation in Discretisation::ALL {
            let constants = ContinuumConstants {
                law,
                young: 1e5,
                poisson: 0.45,
                discretisation,
            };
            let name = format!("{} {}", law.name(), discretisation.name());
            print_row(&name, &mesh, Behaviour::Continuum(constants), repetitions);
        }
    }
}

fn print_row(name: &str, mesh: &TetMesh, behaviour: Behaviour, repetitions: usize) {
    let [elastic, viscous] =
        [0.0, 1e-3].map(|time| nanoseconds(mesh, behaviour, time, repetitions));
    println!("{name:43} {elastic:8.1} {viscous:8.1}");
}

/// Time of one evaluation of all forces, per tetrahedron.
fn nanoseconds(
    mesh: &TetMesh,
    behaviour: Behaviour,
    relaxation_time: f64,
    repetitions: usize,
) -> f64 {
    let material = Material {
        density: 1000.0,
        relaxation_time,
        behaviour,
    };
    let clamped = vec![false; mesh.positions.len()];
    let model = build_model(mesh, &[(0, material)], &clamped, 0.0, Vec::new())
        .expect("a material in range on a block");
    let mut state = State::at_rest(&model);
    for (position, velocity) in state.positions.iter_mut().zip(&mut state.velocities) {
        let rest = *position;
        *position += Vector3::new(0.1 * rest.x, -0.02 * rest.y, -4.0 * rest.x * rest.x);
        *velocity = Vector3::new(0.0, 0.1 * rest.z, rest.x);
    }
    let mut forces = Forces::new(&model);
    let control = Control::default();
    let mut fastest = f64::INFINITY;
    for _ in 0..repetitions {
        let start = Instant::now();
        forces.compute(&model, &state, &control, &Serial);
        fastest = fastest.min(start.elapsed().as_secs_f64());
    }
    fastest * 1e9 / mesh.tets.len() as f64
}
