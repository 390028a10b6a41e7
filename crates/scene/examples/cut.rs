//! A block is cut in two: a blade goes through it from above, and the halves fall apart.
//!
//! `cargo run --release -p microsim-scene --example cut`

use microsim_geometry::signed_volume;
use microsim_mesh::{Block, CellSplit};
use microsim_scene::*;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};
use nalgebra::Vector3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A block of soft tissue, 4 × 2 × 2 mm.
    let block = Block {
        center: [0.0; 3],
        size: [4e-3, 2e-3, 2e-3],
        cells: [8, 4, 4],
        split: CellSplit::Kuhn,
    };
    let behaviour = Behaviour::Continuum(ContinuumConstants {
        law: LawName::StableNeoHookean.into(),
        young: 20e3,
        poisson: 0.4,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    });
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour,
    };
    let body = BodySpec {
        drag: 20.0,
        ..BodySpec::new("block", block.mesh()?, material)
    };

    // A blade across the block: its axis is a line of no return. As it does not touch the body, it cuts whatever it passes.
    let line = CapsuleSpec {
        lonor: true,
        ..CapsuleSpec::new([0.0, -2e-3, 0.0], [0.0, 2e-3, 0.0], 0.1e-3)
    };
    let blade = ToolSpec {
        name: "blade".into(),
        capsules: vec![line],
        sharpness: 1.0,
        jaw_stiffness: f64::INFINITY,
        irrigation: None,
        motion: Vec::new(),
    };
    let cut = CutSpec::new("block", "blade");
    let mut scene = Scene::new(&SceneSpec {
        tools: vec![blade],
        cuts: vec![cut],
        ..SceneSpec::new(vec![body], Method::StoermerVerlet)
    })?;

    // From 1.5 mm above the middle to 1.5 mm below it in 30 ticks of 1 ms.
    let at = |tick: u32| Pose {
        position: Vector3::new(0.3e-3, 0.0, 1.5e-3 - 0.1e-3 * f64::from(tick)),
        ..Pose::identity()
    };
    let steps = 2 * scene.required_steps(1e-3);
    for tick in 0..30 {
        let motion = ToolMotion {
            tool: 0,
            from: at(tick),
            to: at(tick + 1),
            opening_from: 0.0,
            opening_to: 0.0,
            active: true,
        };
        let report = scene.tick(&[motion], 1e-3, steps, &Serial)?;
        for cut in &report.cuts {
            println!("{:>3} ms: {:.2} mm² opened", tick + 1, cut.area * 1e6);
        }
    }

    // The volume of each piece now.
    let body = scene.body(0);
    for piece in 0..body.piece_count() {
        let tets = body.tets().iter();
        let of_piece = tets.filter(|tet| body.pieces()[tet[0] as usize] == piece);
        let volume: f64 = of_piece
            .map(|tet| {
                let [a, b, c, d] = tet.map(|node| &body.positions()[node as usize]);
                signed_volume(a, b, c, d)
            })
            .sum();
        println!("piece {piece}: {:.3} mm³", volume * 1e9);
    }
    Ok(())
}
