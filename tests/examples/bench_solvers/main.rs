//! `cargo xtask bench solvers`: what implicit methods cost. Prints tables and writes `tests/results/bench_solvers.md` and
//! `bench_solvers.csv`.
//!
//! One thread, the beam of `data/reference` on the meshes S, M and L, stable neo-Hookean. First the phases of one Newton
//! iteration; then the two measures of the reference: seconds per simulated second with which the first peak is within 3 % in
//! height and time, and seconds until the body rests within 1 % of its exact sag; then larger beams of the same shape, and a vessel
//! as levels have them. The fastest of the repetitions counts. Nothing is asserted about time.

mod vessel;

use microsim_mesh::{Block, CellSplit};
use microsim_sparse::Factor;
use microsim_tests::repository;
use microsim_tests::system::{System, analyse};
use microsim_tissue::elements::Tangent;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Forces, Material, Method, Newton,
    Serial, State, TissueModel, build_model,
};
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::time::Instant;

/// Cells of the meshes of the reference.
const MESHES: [(&str, [usize; 3]); 3] = [("S", [15, 3, 3]), ("M", [35, 7, 7]), ("L", [60, 12, 12])];

/// Cells of the beams of the scaling curve: 10,000 to 200,000 tetrahedra.
const LARGER: [[usize; 3]; 5] = [
    [35, 7, 7],
    [45, 9, 9],
    [60, 12, 12],
    [75, 15, 15],
    [95, 19, 19],
];

/// First peak of the sag on S, M and L \[mm\] (`data/reference`), and its time \[ms\]: on M and L of Störmer–Verlet at 50 and 30 µs,
/// whose heights are those of the reference.
const PEAKS: [[f64; 2]; 3] = [[47.916, 128.4], [59.398, 144.3], [61.700, 147.8]];

/// Steps of the dynamic runs \[s\].
const STEPS: [f64; 3] = [0.01, 0.02, 0.022];

/// Newton's method with one iteration.
fn once() -> Newton {
    Newton {
        iterations: 1,
        tolerance: 1e-2,
        must_converge: false,
    }
}

fn main() -> std::io::Result<()> {
    let mut text = String::from(
        "# Cost of implicit methods\n\nCommand: `cargo xtask bench solvers`. One thread; fastest repetition. Times are this \
         machine's.\n\n",
    );
    let mut csv = String::from("table,mesh,what,value\n");
    phases(&mut text, &mut csv);
    peaks(&mut text, &mut csv);
    rests(&mut text, &mut csv);
    scaling(&mut text, &mut csv);
    vessel::measure(&mut text, &mut csv);
    print!("{text}");
    let results = repository().join("tests/results");
    std::fs::write(results.join("bench_solvers.md"), text)?;
    std::fs::write(results.join("bench_solvers.csv"), csv)
}

fn beam(cells: [usize; 3], discretisation: Discretisation, poisson: f64) -> TissueModel {
    let block = Block {
        center: [0.05, 0.0, 0.0],
        size: [0.1, 0.02, 0.02],
        cells,
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("a block with positive sizes");
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::StableNeoHookean.into(),
            young: 1e5,
            poisson,
            discretisation,
            plasticity: None,
        }),
    };
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < 1e-6).collect();
    build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new())
        .expect("a material in range on a block")
}

fn weight() -> Control {
    Control {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        ..Control::default()
    }
}

/// The fastest of `repetitions` runs \[s\].
fn fastest(repetitions: usize, mut run: impl FnMut()) -> f64 {
    let timed = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..repetitions).map(timed).fold(f64::INFINITY, f64::min)
}

/// Columns of the table of phases.
const PHASES: [&str; 8] = [
    "analysis", "exact", "positive", "prepare", "solve", "factor", "solution", "update",
];

fn phases(text: &mut String, csv: &mut String) {
    let _ = write!(
        text,
        "## Phases of an iteration [ms]\n\nAnalysis, once per mesh; the matrix, exact and the nearest without negative eigenvalues; \
         preparing and solving in the way of the mesh, to 1e-3, bent as in the first peak, without inertia, ν = 0.45; beside it a factor in single numbers and one solution with \
         it; update: forces and energy.\n\n| mesh | discretisation | way | {} | bytes per tetrahedron |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        PHASES.join(" | ")
    );
    for (name, cells) in MESHES {
        for discretisation in [
            Discretisation::Tetrahedra,
            Discretisation::PatchPressure,
            Discretisation::NodalPressure,
            Discretisation::Selective,
        ] {
            let large = name == "L";
            if large && discretisation != Discretisation::Tetrahedra {
                continue;
            }
            let (way, times, bytes) = phases_of(&beam(cells, discretisation, 0.45), large);
            let _ = write!(text, "| {name} | {} | {way} |", discretisation.name());
            for (what, time) in PHASES.into_iter().zip(times) {
                let milliseconds = time * 1e3;
                let _ = write!(text, " {milliseconds:.3} |");
                let _ = writeln!(
                    csv,
                    "phases,{name} {},{what}_ms,{milliseconds:.4}",
                    discretisation.name()
                );
            }
            let _ = writeln!(text, " {bytes:.0} |");
        }
    }
}

/// The linear solver of a model, its phases \[s\], and bytes per tetrahedron.
fn phases_of(model: &TissueModel, large: bool) -> (&'static str, [f64; 8], f64) {
    let repetitions = if large { 5 } else { 20 };
    let state = bent(model);
    let mut system = System::new(model);
    let analysis = fastest(2, || system = System::new(model));
    let mut assemble = |tangent| fastest(repetitions, || system.assemble(model, &state, tangent));
    let [exact, positive] = [Tangent::Exact, Tangent::Positive].map(&mut assemble);
    let fixed: Vec<bool> = (0..model.node_count())
        .map(|n| model.is_clamped(n))
        .collect();
    let System { matrix, solver, .. } = &mut system;
    let prepare = fastest(repetitions, || {
        solver.factorise(matrix, &fixed).expect("a clamped beam");
    });
    let loads: Vec<Vector3<f64>> = model.masses().iter().map(|m| Vector3::z() * *m).collect();
    let mut x = loads.clone();
    let solve = fastest(repetitions, || {
        x.copy_from_slice(&loads);
        solver
            .solve(matrix, &mut x, 1e-3)
            .expect("a positive matrix");
    });
    let mut direct = Factor::<f32>::new(analyse(model, matrix.pattern()));
    let factor = fastest(repetitions, || {
        direct
            .factorise(matrix, Some(&fixed))
            .expect("a clamped beam");
    });
    let solution = fastest(repetitions, || {
        x.copy_from_slice(&loads);
        direct.solve(&mut x);
    });
    let mut forces = Forces::new(model);
    let control = weight();
    let mut energy = 0.0;
    let update = fastest(repetitions, || {
        forces.compute(model, &state, &control, &Serial);
        energy += state.energies(model).elastic();
    });
    let bytes = system.bytes(model) as f64 / model.tets().len() as f64;
    let times = [
        analysis, exact, positive, prepare, solve, factor, solution, update,
    ];
    (system.solver.method_name(), times, bytes)
}

/// The beam bent to a parabola, its end 50 mm down.
fn bent(model: &TissueModel) -> State {
    let mut state = State::at_rest(model);
    for x in &mut state.positions {
        x.z -= 5.0 * x.x * x.x;
    }
    state
}

/// Sag and its rate at the free end \[m, m/s\].
fn sag(model: &TissueModel, state: &State) -> [f64; 2] {
    let mut sums = [0.0; 3];
    for (node, rest) in model.rest_positions().iter().enumerate() {
        if rest.x > 0.1 - 1e-6 {
            sums[0] += rest.z - state.positions[node].z;
            sums[1] -= state.velocities[node].z;
            sums[2] += 1.0;
        }
    }
    [sums[0] / sums[2], sums[1] / sums[2]]
}

/// Height \[m\] and time \[s\] of the first peak of steps of `h`: that of the cubic through sags and rates.
fn first_peak(curve: &[[f64; 2]], h: f64) -> [f64; 2] {
    let mut best = [f64::NEG_INFINITY, 0.0];
    for (k, ends) in curve.windows(2).enumerate() {
        let [[a, va], [b, vb]] = [ends[0], ends[1]];
        for part in 0..=20 {
            let s = f64::from(part) / 20.0;
            let t = (k as f64 + s) * h;
            let (s2, s3) = (s * s, s * s * s);
            let value = (2.0 * s3 - 3.0 * s2 + 1.0) * a
                + (s3 - 2.0 * s2 + s) * h * va
                + (3.0 * s2 - 2.0 * s3) * b
                + (s3 - s2) * h * vb;
            if value > best[0] {
                best = [value, t];
            } else if t > best[1] + 0.05 {
                return best;
            }
        }
    }
    best
}

/// The first peak and the time of a run of `duration` \[s\].
fn released(model: &TissueModel, method: Method, h: f64, duration: f64) -> ([f64; 2], f64) {
    let control = weight();
    let mut peak = [0.0; 2];
    let time = fastest(2, || {
        let mut solver = method.solver(model).expect("a method for continua");
        let mut state = State::at_rest(model);
        let mut curve = vec![[0.0; 2]];
        for _ in 0..(duration / h).round() as usize {
            solver
                .step(model, &mut state, &control, &[], h, &Serial)
                .expect("a step of a method that cannot fail to converge");
            curve.push(sag(model, &state));
        }
        peak = first_peak(&curve, h);
    });
    (peak, time)
}

fn peaks(text: &mut String, csv: &mut String) {
    text.push_str(
        "\n## First peak\n\nOne iteration. The peak is that of the cubic through sags and rates.\n\n| method | mesh | step [ms] | seconds \
         per second | height [mm] | error | time [ms] | error |\n|---|---|---|---|---|---|---|---|\n",
    );
    for method in [
        Method::ImplicitMidpoint(once()),
        Method::GuardedMidpoint(once()),
    ] {
        for (index, (name, cells)) in MESHES.into_iter().enumerate() {
            let model = beam(cells, Discretisation::Tetrahedra, 0.3);
            let h = STEPS[index];
            let (peak, time) = released(&model, method, h, 0.3);
            let [height, late] = [0, 1].map(|k| peak[k] * 1e3 / PEAKS[index][k] - 1.0);
            let method = method.name();
            let _ = writeln!(
                text,
                "| {method} | {name} | {:.0} | {:.4} | {:.3} | {:+.2} % | {:.1} | {:+.2} % |",
                h * 1e3,
                time / 0.3,
                peak[0] * 1e3,
                100.0 * height,
                peak[1] * 1e3,
                100.0 * late
            );
            let _ = writeln!(csv, "peak,{method} {name},s_per_s,{:.5}", time / 0.3);
            let _ = writeln!(csv, "peak,{method} {name},height_error,{height:.5}");
            let _ = writeln!(csv, "peak,{method} {name},time_error,{late:.5}");
        }
    }
}

fn rests(text: &mut String, csv: &mut String) {
    text.push_str(
        "\n## To rest\n\nQuasi-static, from the undeformed shape until the sag is within 1 % of that of equilibrium to 1e-9 of the forces; with and without the analysis \
         of the mesh, which is made once.\n\n| mesh | iterations | ms | ms with analysis | sag [mm] | error |\n|---|---|---|---|---|---|\n",
    );
    for (name, cells) in MESHES {
        let model = beam(cells, Discretisation::Tetrahedra, 0.3);
        let control = weight();
        let solve = |iterations: u32, repetitions: usize| {
            let newton = Newton {
                iterations,
                tolerance: 1e-4,
                ..once()
            };
            let (mut alone, mut reached) = (f64::INFINITY, 0.0);
            let both = fastest(repetitions, || {
                let mut solver = Method::QuasiStatic(newton)
                    .solver(&model)
                    .expect("a method for continua");
                let mut state = State::at_rest(&model);
                let start = Instant::now();
                solver
                    .step(&model, &mut state, &control, &[], 1.0, &Serial)
                    .expect("a clamped beam");
                alone = alone.min(start.elapsed().as_secs_f64());
                reached = sag(&model, &state)[0];
            });
            ([alone, reached], both)
        };
        let end = settled(&model);
        let within = |iterations: &u32| (solve(*iterations, 1).0[1] / end - 1.0).abs() < 0.01;
        let iterations = (1..20).find(within).unwrap_or(20);
        let ([time, reached], both) = solve(iterations, 3);
        let _ = writeln!(
            text,
            "| {name} | {iterations} | {:.2} | {:.2} | {:.3} | {:+.3} % |",
            time * 1e3,
            both * 1e3,
            reached * 1e3,
            100.0 * (reached / end - 1.0)
        );
        let _ = writeln!(csv, "rest,{name},ms,{:.3}", time * 1e3);
    }
}

/// The sag in equilibrium \[m\], to 1e-9 of the forces.
fn settled(model: &TissueModel) -> f64 {
    let newton = Newton {
        iterations: 200,
        tolerance: 1e-9,
        must_converge: true,
    };
    let mut solver = Method::QuasiStatic(newton)
        .solver(model)
        .expect("a method for continua");
    let mut state = State::at_rest(model);
    solver
        .step(model, &mut state, &weight(), &[], 1.0, &Serial)
        .expect("equilibrium of a clamped beam");
    sag(model, &state)[0]
}

fn scaling(text: &mut String, csv: &mut String) {
    text.push_str(
        "\n## Larger beams\n\nImplicit midpoint, 20 ms, one iteration: the seven steps from the second on, in which the beam comes to its first peak; on \
         M such steps find it within 3 % (above), on the finer meshes that was not measured. The faster of two runs.\n\n| tetrahedra | seconds per second | exponent | \
         bytes per tetrahedron |\n|---|---|---|---|\n",
    );
    let mut measured: Vec<[f64; 2]> = Vec::new();
    let exponent = |[before, fewer]: [f64; 2], [time, tets]: [f64; 2]| {
        (time / before).ln() / (tets / fewer).ln()
    };
    for cells in LARGER {
        let model = beam(cells, Discretisation::Tetrahedra, 0.3);
        let control = weight();
        let h = 0.02;
        let mut time = f64::INFINITY;
        for _ in 0..2 {
            let mut solver = Method::ImplicitMidpoint(once())
                .solver(&model)
                .expect("a method for continua");
            let mut state = State::at_rest(&model);
            let mut steps = |count: u32| {
                for _ in 0..count {
                    solver
                        .step(&model, &mut state, &control, &[], h, &Serial)
                        .expect("a step of a method that cannot fail to converge");
                }
            };
            // Memory is touched first.
            steps(1);
            time = time.min(fastest(1, || steps(7)) / (7.0 * h));
        }
        let tets = model.tets().len() as f64;
        let here = [time, tets];
        let from_last = measured
            .last()
            .map_or("–".into(), |&last| format!("{:.2}", exponent(last, here)));
        let mut system = System::new(&model);
        system.assemble(&model, &bent(&model), Tangent::Positive);
        let clamped: Vec<bool> = (0..model.node_count())
            .map(|node| model.is_clamped(node))
            .collect();
        system
            .solver
            .factorise(&system.matrix, &clamped)
            .expect("a clamped beam");
        let bytes = system.bytes(&model) as f64 / tets;
        let _ = writeln!(text, "| {tets} | {time:.3} | {from_last} | {bytes:.0} |");
        let _ = writeln!(csv, "scaling,{tets},s_per_s,{time:.4}");
        measured.push(here);
    }
    if let [first, .., last] = measured[..] {
        let overall = exponent(first, last);
        let _ = writeln!(text, "\nFrom the first to the last: exponent {overall:.2}.");
        let _ = writeln!(csv, "scaling,overall,exponent,{overall:.3}");
    }
}
