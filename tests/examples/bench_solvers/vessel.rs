//! What levels are: a vessel of 1 mm with two layers, held at both ends, its wall pulled by a tool that lets go.

use crate::weight;
use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Discretisation, Material, Method, Newton, NodeTarget, Serial,
    State, TissueModel, build_model,
};
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::time::Instant;

/// Length of a picture \[s\], of the pull, the hold and the rest after it \[pictures\], and its path length \[m\]. The tool lets go between pictures:
/// it is read once in each.
const PICTURE: f64 = 0.016;
const PULL: usize = 19;
const HOLD: usize = 19;
const REST: usize = 22;
const WAY: f64 = 0.5e-3;

/// Runs of each method.
const RUNS: usize = 7;

type Positions = Vec<Vector3<f64>>;

/// The vessel of `config/scenes/vessel-pull.toml`, with `fineness` times its cells in every direction.
fn mesh(fineness: usize) -> TetMesh {
    let layer = |thickness, region| Layer {
        thickness,
        cells: fineness,
        region,
    };
    let tube = Tube {
        center: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        inner_radius: 0.5e-3,
        layers: vec![layer(80e-6, 0), layer(40e-6, 1)],
        length: 10e-3,
        around: 12 * fineness,
        along: 20 * fineness,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    tube.mesh().expect("a tube with positive sizes")
}

fn model(mesh: &TetMesh, discretisation: Discretisation) -> TissueModel {
    let material = |young| Material {
        density: 1060.0,
        relaxation_time: 2e-3,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young,
            poisson: 0.45,
            discretisation,
            plasticity: None,
        }),
    };
    let clamped: Vec<bool> = mesh
        .positions
        .iter()
        .map(|p| p.x.abs() > 5e-3 - 1e-9)
        .collect();
    let materials = [(0, material(300e3)), (1, material(60e3))];
    build_model(mesh, &materials, &clamped, 0.0, Vec::new()).expect("materials in range on a tube")
}

/// The nodes that the tool holds: the outer layer on top, in the middle.
fn gripped(model: &TissueModel) -> Vec<u32> {
    let inside = |p: &Vector3<f64>| p.x.abs() < 0.6e-3 && p.y.abs() < 0.1e-3 && p.z > 0.57e-3;
    let rest = model.rest_positions().iter().enumerate();
    rest.filter(|(_, p)| inside(p))
        .map(|(node, _)| node as u32)
        .collect()
}

/// Positions at the end of each picture, and its time \[s\]; `parts` steps in each.
fn run(model: &TissueModel, method: Method, parts: usize) -> Vec<(Positions, f64)> {
    let grip = gripped(model);
    let control = weight();
    let mut solver = method.solver(model).expect("a method for continua");
    let mut state = State::at_rest(model);
    let picture = |index: usize| {
        let start = Instant::now();
        for part in 1..=parts {
            let at = index as f64 + part as f64 / parts as f64;
            let lifted = Vector3::z() * (WAY * (at / PULL as f64).min(1.0));
            let held = if index < PULL + HOLD { &grip[..] } else { &[] };
            let targets = held.iter().map(|&node| NodeTarget {
                node,
                target: model.rest_positions()[node as usize] + lifted,
                overlap: Vector3::zeros(),
            });
            let targets: Vec<NodeTarget> = targets.collect();
            let step = PICTURE / parts as f64;
            solver
                .step(model, &mut state, &control, &targets, step, &Serial)
                .expect("a step that converges, or need not");
        }
        (state.positions.clone(), start.elapsed().as_secs_f64())
    };
    (0..PULL + HOLD + REST).map(picture).collect()
}

/// The largest distance of a node in any picture, relative to the largest displacement in `exact`; and the picture.
fn worst(
    model: &TissueModel,
    run: &[(Positions, f64)],
    exact: &[(Positions, f64)],
) -> (f64, usize) {
    let farthest = |a: &Positions, b: &[Vector3<f64>]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).norm())
            .fold(0.0, f64::max)
    };
    let largest = exact
        .iter()
        .map(|(positions, _)| farthest(positions, model.rest_positions()))
        .fold(0.0, f64::max);
    run.iter()
        .zip(exact)
        .enumerate()
        .map(|(picture, (here, exact))| (farthest(&here.0, &exact.0) / largest, picture))
        .fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a })
}

/// The time of pictures from..to, each the fastest of all runs: mean and largest \[s\].
fn times(runs: &[Vec<(Positions, f64)>; RUNS], pictures: std::ops::Range<usize>) -> [f64; 2] {
    let fastest: Vec<f64> = pictures
        .map(|index| {
            runs.iter()
                .map(|run| run[index].1)
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let mean = fastest.iter().sum::<f64>() / fastest.len() as f64;
    [mean, fastest.into_iter().fold(0.0, f64::max)]
}

pub fn measure(text: &mut String, csv: &mut String) {
    let coarse = mesh(1);
    let _ = write!(
        text,
        "\n## A vessel\n\n`config/scenes/vessel-pull.toml`: 1 mm, two layers, ν = 0.45, {} tetrahedra; {} pictures of 16 ms, the wall pulled by \
         0.5 mm in {PULL}, held for {HOLD}, let go. Error: the largest distance of a node from the solution of backward Euler with 1/16 of the \
         step to 1e-8, relative to the largest displacement (that solution itself: the same against 1/32). Times of a picture, each the \
         fastest of {RUNS} runs: mean and largest are those of these minima, not of a single run.\n\n| discretisation | method | iterations | error | in picture | mean [ms] | while pulled [ms] | largest [ms] \
         |\n|---|---|---|---|---|---|---|---|\n",
        coarse.tets.len(),
        PULL + HOLD + REST,
    );
    let tight = Method::ImplicitEuler(Newton {
        iterations: 30,
        tolerance: 1e-8,
        must_converge: true,
    });
    for discretisation in [Discretisation::PatchPressure, Discretisation::NodalPressure] {
        let model = model(&coarse, discretisation);
        let exact = run(&model, tight, 16);
        let name = discretisation.name();
        if discretisation == Discretisation::PatchPressure {
            let (error, picture) = worst(&model, &exact, &run(&model, tight, 32));
            let _ = writeln!(
                text,
                "| {name} | implicit-euler, 1 ms, to 1e-8 | – | {:.2} % | {picture} | | | |",
                100.0 * error
            );
        }
        for iterations in [1, 2] {
            let newton = Newton {
                iterations,
                tolerance: 1e-2,
                must_converge: false,
            };
            for method in [
                Method::QuasiStatic(newton),
                Method::ImplicitEuler(newton),
                Method::GuardedMidpoint(newton),
                Method::Sdirk2(newton),
            ] {
                let runs: [_; RUNS] = std::array::from_fn(|_| run(&model, method, 1));
                let (error, picture) = worst(&model, &runs[0], &exact);
                let [mean, largest] = times(&runs, 0..PULL + HOLD + REST);
                let [pulled, _] = times(&runs, 0..PULL);
                let method = method.name();
                let _ = writeln!(
                    text,
                    "| {name} | {method} | {iterations} | {:.2} % | {picture} | {:.2} | {:.2} | {:.2} |",
                    100.0 * error,
                    mean * 1e3,
                    pulled * 1e3,
                    largest * 1e3
                );
                let row = format!("vessel,{name} {method} {iterations}");
                let _ = writeln!(csv, "{row},error,{error:.5}");
                let _ = writeln!(csv, "{row},pulled_ms,{:.4}", pulled * 1e3);
                let _ = writeln!(csv, "{row},largest_ms,{:.4}", largest * 1e3);
            }
        }
    }
    locking(text, csv);
}

/// The sag of the middle under the weight, against a mesh of twice the cells in every direction.
fn locking(text: &mut String, csv: &mut String) {
    text.push_str(
        "\nLocking: the sag of its middle under its weight, as a share of that of a mesh with twice the cells in every direction and \
         nodal-pressure.\n\n| discretisation | sag |\n|---|---|\n",
    );
    let sag = |mesh: &TetMesh, discretisation| {
        let model = model(mesh, discretisation);
        let mut state = State::at_rest(&model);
        let mut solver = Method::QuasiStatic(Newton::default())
            .solver(&model)
            .expect("a method for continua");
        solver
            .step(&model, &mut state, &weight(), &[], 1.0, &Serial)
            .expect("a clamped vessel");
        let middle: Vec<f64> = (0..model.node_count())
            .filter(|&node| model.rest_positions()[node].x.abs() < 1e-9)
            .map(|node| model.rest_positions()[node].z - state.positions[node].z)
            .collect();
        middle.iter().sum::<f64>() / middle.len() as f64
    };
    let exact = sag(&mesh(2), Discretisation::NodalPressure);
    let coarse = mesh(1);
    for discretisation in [
        Discretisation::Tetrahedra,
        Discretisation::PatchPressure,
        Discretisation::NodalPressure,
    ] {
        let share = sag(&coarse, discretisation) / exact;
        let name = discretisation.name();
        let _ = writeln!(text, "| {name} | {:.1} % |", 100.0 * share);
        let _ = writeln!(csv, "locking,{name},share,{share:.4}");
    }
}
