//! `cargo xtask bench vessels`: what walls with fibres cost beside rubber. Prints and writes `tests/results/bench_vessels.md`.
//!
//! First forces and a step of implicit Euler on the same tube with each law, in turn, round after round; then the scene `carotid-grip`,
//! picture by picture, with its own law and with that of its matrix alone. One thread; nothing is asserted about time.

use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use microsim_scene::{Runner, Scene, Serial, scene_spec};
use microsim_settings::{Override, load_scene};
use microsim_tests::measured::thread_time as now;
use microsim_tests::repository;
use microsim_tests::statistics::percentile;
use microsim_tissue::law::{HolzapfelParameters, LawName, MaterialLaw};
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Forces, Material, Method, Newton,
    Solver, State, TissueModel, build_model,
};
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::process::ExitCode;

/// Rounds over all laws.
const ROUNDS: usize = 200;

/// Runs of the scene with each wall.
const REPETITIONS: usize = 4;

/// A wall of two layers: 2,880 tetrahedra, each with fibres at ±29° to the circles.
fn wall() -> TetMesh {
    let tube = Tube {
        center: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        inner_radius: 0.71e-3,
        layers: vec![Layer {
            thickness: 0.39e-3,
            cells: 2,
            region: 0,
        }],
        length: 6e-3,
        around: 16,
        along: 15,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    let mut mesh = tube.mesh().expect("a tube");
    let (sine, cosine) = libm::sincos(29_f64.to_radians());
    let fibres = |element: usize| {
        let centre = mesh.corners(element).iter().sum::<Vector3<f64>>() / 4.0;
        let around = Vector3::x().cross(&centre).normalize();
        [sine, -sine].map(|sine| around * cosine + Vector3::x() * sine)
    };
    mesh.directions = (0..mesh.tets.len()).map(fibres).collect();
    mesh
}

/// A wall of one law, its solver and its times.
struct Row {
    name: &'static str,
    model: TissueModel,
    state: State,
    forces: Forces,
    solver: Box<dyn Solver>,
    /// Of forces and of a step \[s\].
    times: [Vec<f64>; 2],
}

impl Row {
    fn new(mesh: &TetMesh, name: &'static str, law: MaterialLaw) -> Self {
        let material = Material {
            density: 1060.0,
            relaxation_time: 0.0,
            behaviour: Behaviour::Continuum(ContinuumConstants {
                law,
                young: 8.7e3,
                poisson: 0.45,
                discretisation: Discretisation::PatchPressure,
                plasticity: None,
            }),
        };
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < -2.9e-3).collect();
        let model = build_model(mesh, &[(0, material)], &clamped, 0.0, Vec::new());
        let model = model.expect("a wall");
        let mut state = State::at_rest(&model);
        // Stretched along and around, so that fibres pull.
        for place in &mut state.positions {
            *place = Vector3::new(
                place.x + 0.2 * (place.x + 3e-3),
                1.2 * place.y,
                1.2 * place.z,
            );
        }
        // As levels take it: one iteration, whatever it leaves.
        let newton = Newton {
            iterations: 1,
            tolerance: 1e-2,
            must_converge: false,
        };
        let solver = Method::ImplicitEuler(newton).solver(&model);
        Self {
            name,
            forces: Forces::new(&model),
            solver: solver.expect("a method for every law"),
            model,
            state,
            times: Default::default(),
        }
    }

    fn measure(&mut self) {
        let control = Control::default();
        let start = now();
        self.forces
            .compute(&self.model, &self.state, &control, &Serial);
        self.times[0].push(now() - start);
        let mut state = self.state.clone();
        let start = now();
        let step = self
            .solver
            .step(&self.model, &mut state, &control, &[], 16e-3, &Serial);
        self.times[1].push(now() - start);
        step.expect("a step");
    }
}

/// Appends the section of the laws.
fn laws(text: &mut String) {
    let mesh = wall();
    let fibres = |fibre_dispersion| HolzapfelParameters {
        fibre_stiffness: 2.3632e3,
        fibre_exponent: 0.8393,
        fibre_dispersion,
    };
    let mut rows = [
        ("stable-neo-hookean", LawName::StableNeoHookean.into()),
        ("neo-hookean", LawName::NeoHookean.into()),
        (
            "transversely-isotropic",
            LawName::TransverselyIsotropic.into(),
        ),
        (
            "holzapfel-gasser-ogden",
            MaterialLaw::HolzapfelGasserOgden(fibres(0.0)),
        ),
        (
            "holzapfel-gasser-ogden, dispersion 0.1",
            MaterialLaw::HolzapfelGasserOgden(fibres(0.1)),
        ),
        (
            "holzapfel-gasser-ogden-isochoric",
            MaterialLaw::HolzapfelGasserOgdenIsochoric(fibres(0.0)),
        ),
    ]
    .map(|(name, law)| Row::new(&mesh, name, law));
    for _ in 0..ROUNDS {
        rows.iter_mut().for_each(Row::measure);
    }
    let count = mesh.tets.len() as f64;
    let at =
        |row: &Row, kind: usize, fraction| percentile(&row.times[kind], fraction) * 1e9 / count;
    let base = [0, 1].map(|kind| at(&rows[0], kind, 0.5));
    let _ = writeln!(
        text,
        "\n## Cost per element\n\nA tube of {count} tetrahedra, ν = 0.45, `patch-pressure`, stretched by a fifth along and around, so that all fibres pull. Forces, and a step of 16 ms of implicit \
         Euler with one iteration; {ROUNDS} rounds over all rows, median and 99th percentile of the CPU time. Ratios are to stable neo-Hookean; aim: at most 1.6.\n\n\
         | law | forces [ns], p50, p99 | ratio | implicit step [ns], p50, p99 | ratio |\n|---|---|---|---|---|",
    );
    for row in &rows {
        let [forces, step] = [0, 1].map(|kind| at(row, kind, 0.5));
        let _ = writeln!(
            text,
            "| {} | {forces:.0}, {:.0} | {:.2} | {step:.0}, {:.0} | {:.2} |",
            row.name,
            at(row, 0, 0.99),
            forces / base[0],
            at(row, 1, 0.99),
            step / base[1]
        );
    }
}

/// A run of the scene.
struct Run {
    /// Per picture \[ms\].
    times: Vec<f64>,
    elements: usize,
    /// Error of the pull at the end, against that of converged steps with fibres, which the scene states.
    off: f64,
}

/// Runs the scene with these overrides.
fn pictures(set: &[String]) -> Result<Run, String> {
    let path = repository().join("config/scenes/carotid-grip.toml");
    let set: Result<Vec<Override>, String> = set.iter().map(|one| Override::parse(one)).collect();
    let loaded = load_scene(&path, &set?).map_err(|error| error.to_string())?;
    let folder = path.parent().unwrap_or(&path).to_path_buf();
    let described = scene_spec(&loaded.settings, &mut |file| {
        std::fs::read(folder.join(file))
    });
    let spec = described.map_err(|error| error.to_string())?.spec;
    let scene = Scene::new(&spec).map_err(|error| error.to_string())?;
    let elements = scene.body(0).element_count();
    let mut runner = Runner::new(&loaded.settings, scene).map_err(|error| error.to_string())?;
    let mut times = Vec::new();
    loop {
        let start = now();
        let goes_on = runner.compute(&Serial);
        times.push(1e3 * (now() - start));
        if !goes_on || !runner.observe() {
            break;
        }
    }
    let is_pull = |index: usize| loaded.settings.expect[index].probe.as_str() == "pull";
    let verdicts = runner.verdicts();
    let pull = verdicts.iter().find(|verdict| is_pull(verdict.expect));
    let pull = pull.ok_or("carotid-grip has no expectation of the pull")?;
    Ok(Run {
        times,
        elements,
        off: pull.error.ok_or("no pull was measured")?,
    })
}

/// Appends the section of the scene.
fn grip(text: &mut String) -> Result<(), String> {
    let _ = writeln!(
        text,
        "\n## A carotid's end, gripped and pulled\n\n`carotid-grip`: two layers, `patch-pressure`, ν = 0.45, implicit Euler with two iterations per picture of 16 ms; forceps close on the \
         wall, draw it out and lift it. CPU time of the one thread per picture, without probes and drawing, over {REPETITIONS} runs that alternate with those of the other rows; error of the pull at the end against converged steps on the same mesh.\n\n\
         | wall | elements | mean [ms] | p50 | p99 | largest | pull |\n|---|---|---|---|---|---|---|",
    );
    let rubber = [
        "law=stable-neo-hookean",
        "fibre_stiffness=",
        "fibre_exponent=",
        "fibre_dispersion=",
        "fibres=",
    ];
    let rubber = [0, 1].map(|m| rubber.map(|key| format!("body.0.material.{m}.{key}")));
    let mut walls = [
        ("two families of fibres in each layer", Vec::new()),
        (
            "the same, one iteration",
            vec!["method.iterations=1".to_owned()],
        ),
        ("the matrix of the fibres alone", rubber.concat()),
    ]
    .map(|(name, set)| (name, set, Vec::new()));
    for _ in 0..REPETITIONS {
        for (_, set, runs) in &mut walls {
            runs.push(pictures(set)?);
        }
    }
    for (name, set, runs) in &walls {
        let times: Vec<f64> = runs.iter().flat_map(|run| &run.times).copied().collect();
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        let p = |fraction| percentile(&times, fraction);
        let has_fibres = set.len() < 2;
        let off = match has_fibres {
            true => format!("{:+.2} %", 100.0 * runs[0].off),
            false => "–".to_owned(),
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {mean:.2} | {:.2} | {:.2} | {:.2} | {off} |",
            runs[0].elements,
            p(0.5),
            p(0.99),
            p(1.0)
        );
    }
    Ok(())
}

fn main() -> ExitCode {
    let mut text = String::from(
        "# Walls of vessels\n\n`cargo xtask bench vessels`; what fibres cost. One core.\n",
    );
    laws(&mut text);
    if let Err(message) = grip(&mut text) {
        eprintln!("bench vessels: {message}");
        return ExitCode::FAILURE;
    }
    print!("{text}");
    let page = repository().join("tests/results/bench_vessels.md");
    match std::fs::write(&page, text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bench vessels: {}: {error}", page.display());
            ExitCode::FAILURE
        }
    }
}
