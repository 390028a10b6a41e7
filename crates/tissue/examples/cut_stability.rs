//! Whether the step that was stable before 500 cuts is stable after them, with the mass floor and without.
//!
//! `cargo run --release -p microsim-tissue --example cut_stability [CUTS] [STEPS]` cuts a cube, which nothing holds, at rest, with squares
//! at random places, and lets it swing from small random velocities, undamped, with Störmer–Verlet at the step of the uncut cube.

use microsim_cutting::{Blade, Settings, Sheet, Stroke, Topology};
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_random::Congruential;
use microsim_tissue::law::LawName;
use microsim_tissue::stability::{Part, SAFETY, floor_nodes, power_iteration, stable_step};
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Material, Method, ModelEdit, Serial,
    SpringConstants, State, TissueModel, build_model,
};
use nalgebra::Vector3;

/// Cells of one millimetre along each edge of the cube.
const CELLS: usize = 12;

/// Edge of the squares, in cells.
const SQUARE: f64 = 1.0;

/// Fraction of the limit that the floor leaves.
const FLOOR: f64 = 0.95;

/// The energy is gone beyond all bounds at so many times that of the start.
const BLOWN_UP: f64 = 10.0;

/// The energy is taken every so many steps.
const SAMPLE: usize = 5;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|word| word.parse());
    let mut number = |default: usize| match arguments.next() {
        Some(Ok(number)) => number,
        _ => default,
    };
    let (cuts, steps) = (number(500), number(10_000));
    println!("{cuts} cuts, {steps} steps.\n");
    println!(
        "| material | remedy | tetrahedra | nodes floored | inertia added | edges clamped | edges snapped | crumbs | step over limit | largest drift of the energy |"
    );
    println!("|{}", "---|".repeat(10));
    for (name, behaviour) in behaviours() {
        for floored in [true, false] {
            row(name, behaviour, floored, cuts, steps);
        }
    }
}

fn behaviours() -> [(&'static str, Behaviour); 4] {
    let continuum = |discretisation| {
        Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young: 2e4,
            poisson: 0.45,
            discretisation,
            plasticity: None,
        })
    };
    [
        (
            "springs",
            Behaviour::Springs(SpringConstants::fitted(2e4, 0.4)),
        ),
        ("tetrahedra", continuum(Discretisation::Tetrahedra)),
        ("selective", continuum(Discretisation::Selective)),
        ("patch-pressure", continuum(Discretisation::PatchPressure)),
    ]
}

fn row(name: &str, behaviour: Behaviour, floored: bool, cuts: usize, steps: usize) {
    let size = 1e-3 * CELLS as f64;
    let block = Block {
        center: [0.0; 3],
        size: [size; 3],
        cells: [CELLS; 3],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("cells of one millimetre");
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour,
    };
    let clamped = vec![false; mesh.positions.len()];
    let mut model = build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new())
        .expect("a block can be a body");
    let h = stable_step(&model, SAFETY);
    let mut topology = Topology::new(&mesh);
    let mut next = numbers();
    let (mut clamped, mut snapped, mut crumbs) = (0, 0, 0.0);
    for _ in 0..cuts {
        let Some(cut) = square(&mut mesh, &mut topology, &mut next) else {
            continue;
        };
        clamped += cut.clamped;
        snapped += cut.snapped;
        crumbs += cut.lost_volume;
        let edit = ModelEdit::new(&mesh, &cut.edit, model.clamped());
        let change = model.edit(&edit).expect("cuts are sound");
        if floored {
            floor_nodes(
                &mut model,
                &change.touched,
                &Method::StoermerVerlet,
                h,
                FLOOR,
            );
        }
    }
    let added = model.added_inertia();
    let over_limit = 0.5 * h * power_iteration(&model, Part::Stiffness, 100).sqrt();
    println!(
        "| {name} | {} | {} | {} of {} | {:.2} % | {clamped} | {snapped} | {:.1e} | {over_limit:.2} | {} |",
        if floored { "floor" } else { "none" },
        mesh.tets.len(),
        added.iter().filter(|added| **added > 0.0).count(),
        model.node_count(),
        100.0 * added.iter().sum::<f64>() / model.masses().iter().sum::<f64>(),
        crumbs / (size * size * size),
        swing(&model, h, steps)
    );
}

/// The largest drift of the energy, as a mean over a hundredth of the steps, or when it was gone.
fn swing(model: &TissueModel, h: f64, steps: usize) -> String {
    let mut state = State::at_rest(model);
    let mut next = numbers();
    let speed = 1e-3 * 1e-3 * model.mean_edge_length() / h;
    for v in &mut state.velocities {
        *v = Vector3::new(next(), next(), next()) * speed;
    }
    let mut solver = Method::StoermerVerlet
        .solver(model)
        .expect("any model has it");
    let control = Control::default();
    let window = (steps / 100).max(1).next_multiple_of(SAMPLE);
    let (mut start, mut drift, mut sum) = (None, 0.0f64, 0.0);
    for step in 1..=steps {
        let made = solver.step(model, &mut state, &control, &[], h, &Serial);
        if made.is_err() {
            return format!("not finite after {step} steps");
        }
        if step % SAMPLE == 0 {
            sum += state.energies(model).total();
        }
        if step % window == 0 {
            let energy = sum / (window / SAMPLE) as f64;
            let start = *start.get_or_insert(energy);
            if energy > BLOWN_UP * start {
                return format!("× {:.1e} after {step} steps", energy / start);
            }
            drift = drift.max((energy / start - 1.0).abs());
            sum = 0.0;
        }
    }
    format!("{:.2} %", 100.0 * drift)
}

/// Cuts a square somewhere.
fn square(
    mesh: &mut TetMesh,
    topology: &mut Topology,
    next: &mut impl FnMut() -> f64,
) -> Option<microsim_cutting::Cut> {
    let mut vector = || Vector3::new(next(), next(), next());
    let centre = vector() * (0.5e-3 * CELLS as f64);
    let (along, other) = (vector().normalize(), vector());
    let across = along.cross(&other).normalize();
    let half = 0.5e-3 * SQUARE;
    let (along, across) = (along * half, across * half);
    let sheet = Sheet::quad(
        [centre - along - across, centre + along - across],
        [centre - along + across, centre + along + across],
    );
    let positions = mesh.positions.clone();
    let blade = Blade::Sheet {
        sheet: &sheet,
        positions: &positions,
    };
    let cut = topology.cut(mesh, &mut Stroke::new(), &blade, &Settings::default());
    let cut = cut.ok()??;
    mesh.apply(&cut.edit).ok()?;
    Some(cut)
}

/// A fixed sequence of numbers in −1..1.
fn numbers() -> impl FnMut() -> f64 {
    let mut random = Congruential(7);
    move || random.number()
}
