//! A cantilever under a hundredth of its weight against beam theory: `cargo run --release --example beam -p microsim-tissue`.

use microsim_mesh::{Block, CellSplit};
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Material, Method, Newton, Serial,
    State, build_model,
};
use nalgebra::Vector3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (length, side, young, poisson, density, gravity) = (0.1_f64, 0.02, 1e5, 0.3, 1e3, 0.0981);
    let block = Block {
        center: [0.5 * length, 0.0, 0.0],
        size: [length, side, side],
        cells: [30, 6, 6],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh()?;
    let material = Material {
        density,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::NeoHookean.into(),
            young,
            poisson,
            discretisation: Discretisation::Selective,
            plasticity: None,
        }),
    };
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < 1e-9).collect();
    let model = build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new())?;

    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -gravity),
        ..Control::default()
    };
    let mut state = State::at_rest(&model);
    let mut solver = Method::QuasiStatic(Newton::default()).solver(&model)?;
    solver.step(&model, &mut state, &control, &[], 1.0, &Serial)?;

    let tip = |p: &&Vector3<f64>| p.x > length - 1e-3;
    let end: Vec<f64> = state.positions.iter().filter(tip).map(|p| p.z).collect();
    let sag = -end.iter().sum::<f64>() / end.len() as f64;
    // q L⁴/(8 E I) + q L²/(2 κ G A) with κ = 10 (1 + ν)/(12 + 11 ν) (Timoshenko; Cowper 1966).
    let (load, area) = (density * gravity * side * side, side * side);
    let bending = load * length * length * length * length / (8.0 * young * area * area / 12.0);
    let kappa = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    let shear = load * length * length / (kappa * young / (1.0 + poisson) * area);
    println!("sag at the end    {:.4} mm", 1e3 * sag);
    println!("beam theory       {:.4} mm", 1e3 * (bending + shear));
    Ok(())
}
