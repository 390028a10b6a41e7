//! What it takes a model to follow a cut of about 60 elements, against the size of the body, part by part; and what it takes an implicit
//! method to begin again, stage by stage.
//!
//! `cargo run --release -p microsim-tissue --example edit_time [MATERIAL]` prints two tables of CPU times of one core \[µs\].

use microsim_cutting::{Blade, Settings, Sheet, Stroke, Topology};
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_random::Congruential;
use microsim_sparse::{LinearSolver, Ordering, Pattern, Symbolic};
use microsim_tissue::law::LawName;
use microsim_tissue::stability::{Part, floor_nodes, gershgorin_bound};
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Material, Method, ModelEdit, Newton,
    Serial, SpringConstants, State, TissueModel, build_model,
};
use nalgebra::Vector3;
use rustix::time::{ClockId, clock_gettime};
use std::sync::Arc;

/// Cells along each edge of the cube, with six tetrahedra each: 1,296 to 105,456 tetrahedra.
const CELLS: [usize; 4] = [6, 12, 18, 26];

/// Most cuts of a body that count.
const CUTS: usize = 100;

/// So much a body grows by cuts: the small ones are not to be cut to pieces.
const MOST_GROWTH: f64 = 2.5;

/// Edge of the square that is cut, in cells.
const SQUARE: f64 = 2.3;

/// Cuts that divide as many elements count.
const DIVIDED: std::ops::RangeInclusive<usize> = 40..=60;

/// Repeats of which the fastest is reported, in the second table.
const REPEATS: usize = 7;

/// What is timed.
const SHARES: [&str; 7] = [
    "edit",
    "state",
    "floor",
    "Verlet",
    "sum",
    "union of 2",
    "implicit",
];

fn main() {
    println!(
        "Median and 99th of a hundred [µs]; `sum` is that of edit, state, floor and Verlet.\n"
    );
    println!(
        "| material | tetrahedra | cuts | divided | touched nodes | first | {} |",
        SHARES.join(" | ")
    );
    println!("|{}", "---|".repeat(6 + SHARES.len()));
    // One material alone, if it is named.
    let wanted = std::env::args().nth(1);
    for (name, material) in materials() {
        for cells in CELLS {
            if wanted.as_ref().is_none_or(|wanted| wanted == name) {
                row(name, &material, cells);
            }
        }
    }
    println!(
        "\nAn implicit solver, fastest of {REPEATS} [µs]: stages of its linear system, all of it, one that follows a cut, and a step with one iteration.\n"
    );
    println!(
        "| material | tetrahedra | blocks | pattern | order | analysis | all | after a cut | way | step |"
    );
    println!("|{}", "---|".repeat(10));
    for (name, material) in materials() {
        for cells in [8, 12] {
            if wanted.as_ref().is_none_or(|wanted| wanted == name) {
                begin_anew(name, &material, cells);
            }
        }
    }
}

/// One row of the second table.
fn begin_anew(name: &str, material: &Material, cells: usize) {
    let (mut mesh, mut model) = body(material, cells);
    let mut topology = Topology::new(&mesh);
    let mut next = numbers();
    let Some(edit) = square(&mut mesh, &mut topology, cells as f64, &mut next) else {
        return;
    };
    let edit = ModelEdit::new(&mesh, &edit, model.clamped());
    let change = model.edit(&edit).expect("cuts are sound");
    drop(change);
    let (mut pattern, mut order, mut linear, mut solver) = (None, None, None, None);
    let cliques = || {
        let sets = model.sets().iter();
        sets.flat_map(|set| (0..set.count()).map(|element| set.nodes(element)))
    };
    let nodes = model.node_count();
    let patterned = fastest(|| pattern = Some(Arc::new(Pattern::from_cliques(nodes, cliques()))));
    let pattern = pattern.expect("just made");
    let positions = model.rest_positions();
    let ordered = fastest(|| order = Some(Ordering::nested_dissection(&pattern, Some(positions))));
    let order = order.expect("just made");
    let analysed = fastest(|| drop(Symbolic::analyse(&pattern, &order)));
    micros(|| linear = Some(LinearSolver::new(&pattern, positions)));
    let method = Method::GuardedMidpoint(Newton {
        iterations: 1,
        must_converge: false,
        ..Newton::default()
    });
    let all = fastest(|| solver = method.solver(&model).ok());
    let mut solver = solver.expect("any model has it");
    let followed = fastest(|| solver.follow(&model));
    let mut state = State::at_rest(&model);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -1e-3),
        ..Control::default()
    };
    let mut step = || {
        micros(|| {
            let made = solver.step(&model, &mut state, &control, &[], 4e-3, &Serial);
            made.expect("a small load");
        })
    };
    // The first one makes room.
    step();
    let step = (0..REPEATS).map(|_| step()).fold(f64::INFINITY, f64::min);
    println!(
        "| {name} | {} | {} | {patterned:.0} | {ordered:.0} | {analysed:.0} | {all:.0} | {followed:.0} | {} | {step:.0} |",
        mesh.tets.len(),
        pattern.blocks(),
        linear.expect("just made").method_name()
    );
}

fn materials() -> Vec<(&'static str, Material)> {
    let springs = Behaviour::Springs(SpringConstants::fitted(2e4, 0.4));
    let continuum = |discretisation| {
        Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young: 2e4,
            poisson: 0.45,
            discretisation,
            plasticity: None,
        })
    };
    let cut = Discretisation::ALL
        .into_iter()
        .filter(|one| !one.is_quadratic());
    let named = cut.map(|one| (one.name(), continuum(one)));
    let all = [("springs", springs)].into_iter().chain(named);
    let material = |(name, behaviour)| {
        let material = Material {
            density: 1060.0,
            relaxation_time: 0.0,
            behaviour,
        };
        (name, material)
    };
    all.map(material).collect()
}

/// A cube of so many cells of size one along each edge, clamped on one side.
fn body(material: &Material, cells: usize) -> (TetMesh, TissueModel) {
    let size = cells as f64;
    let block = Block {
        center: [0.0; 3],
        size: [size; 3],
        cells: [cells; 3],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("cells of size one");
    let clamped = mesh.positions.iter().map(|p| p.x < 0.1 - 0.5 * size);
    let clamped: Vec<bool> = clamped.collect();
    let model = build_model(&mesh, &[(0, *material)], &clamped, 0.0, Vec::new());
    (mesh, model.expect("a block can be a body"))
}

/// One row of the first table.
fn row(name: &str, material: &Material, cells: usize) {
    let (mut mesh, mut model) = body(material, cells);
    let size = cells as f64;
    let h = 1.8 / gershgorin_bound(&model, Part::Stiffness).sqrt();
    let (mut state, mut topology) = (State::at_rest(&model), Topology::new(&mesh));
    let mut verlet = Method::StoermerVerlet
        .solver(&model)
        .expect("any model has it");
    let mut implicit = Method::ImplicitEuler(Newton::default())
        .solver(&model)
        .expect("any model has it");
    let first = micros(|| model.prepare_edits());
    let mut times = SHARES.map(|_| Vec::with_capacity(CUTS));
    let (mut divided, mut touched, mut cut) = (0, 0, 0);
    let mut next = numbers();
    let most = MOST_GROWTH * mesh.tets.len() as f64;
    while times[0].len() < CUTS && (mesh.tets.len() as f64) < most {
        let Some(edit) = square(&mut mesh, &mut topology, size, &mut next) else {
            continue;
        };
        let count = edit.elements.len();
        let edit = ModelEdit::new(&mesh, &edit, model.clamped());
        let mut change = None;
        let edited = micros(|| change = model.edit(&edit).ok());
        let change = change.expect("cuts are sound");
        let carried = micros(|| state.edit(&change));
        let floored = micros(|| {
            floor_nodes(&mut model, &change.touched, &Method::StoermerVerlet, h, 0.9);
        });
        let followed = micros(|| verlet.follow(&model));
        if !DIVIDED.contains(&count) {
            continue;
        }
        divided += count;
        touched += change.touched.len();
        let sum = edited + carried + floored + followed;
        for (times, time) in times
            .iter_mut()
            .zip([edited, carried, floored, followed, sum])
        {
            times.push(time);
        }
        if cut < 3 {
            times[5].push(micros(|| drop(TissueModel::union(&[&model, &model]))));
            times[6].push(micros(|| implicit.follow(&model)));
        }
        cut += 1;
    }
    let count = times[0].len();
    print!(
        "| {name} | {} | {count} | {} | {} | {first:.0} |",
        mesh.tets.len(),
        divided / count.max(1),
        touched / count.max(1)
    );
    for times in &mut times {
        times.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = (share * times.len() as f64) as usize;
            times
                .get(place.min(times.len().max(1) - 1))
                .copied()
                .unwrap_or(0.0)
        };
        print!(" {:.0} / {:.0} |", at(0.5), at(0.99));
    }
    println!();
}

/// Cuts a square somewhere inside.
fn square(
    mesh: &mut TetMesh,
    topology: &mut Topology,
    size: f64,
    next: &mut impl FnMut() -> f64,
) -> Option<microsim_mesh::TopologyEdit> {
    let mut vector = || Vector3::new(next(), next(), next());
    let centre = vector() * (0.5 * size - SQUARE);
    let (along, other) = (vector().normalize(), vector());
    let across = along.cross(&other).normalize();
    let (along, across) = (along * (0.5 * SQUARE), across * (0.5 * SQUARE));
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
    let edit = cut.ok()??.edit;
    mesh.apply(&edit).ok()?;
    Some(edit)
}

/// The fastest of some repeats.
fn fastest(mut work: impl FnMut()) -> f64 {
    (0..REPEATS)
        .map(|_| micros(&mut work))
        .fold(f64::INFINITY, f64::min)
}

/// CPU time of this thread in a piece of work \[µs\].
fn micros(work: impl FnOnce()) -> f64 {
    let now = || {
        let time = clock_gettime(ClockId::ThreadCPUTime);
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    };
    let start = now();
    work();
    (now() - start) * 1e6
}

/// A fixed sequence of numbers in −1..1.
fn numbers() -> impl FnMut() -> f64 {
    let mut random = Congruential(7);
    move || random.number()
}
