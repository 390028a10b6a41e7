//! `cargo xtask bench kernels`: what the forces of each kind of element and an explicit step cost per tetrahedron. Prints tables
//! and writes `tests/results/bench_kernels.md`, `bench_kernels.csv` and `bench_kernels_cache.csv`.
//!
//! First every material on mesh M of the reference beam (35 × 7 × 7 cells, 10,290 tetrahedra), one thread; then springs and the
//! neo-Hookean laws on M and on a beam that no cache holds, with one thread and two. Bodies are bent and stretched a little
//! so that no branch is that of the rest shape.
//!
//! All rows are taken in turn, round after round, so that all see the same machine; the fastest round counts, and the page states
//! how far the median lies above it. That is what a library would add here: criterion and divan measure one row after the
//! other, which leaves a machine that slows down in the ratios. Nothing is asserted about time.

#![allow(unsafe_code, reason = "an allocator that counts")]

use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_tests::repository;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Executor, Forces, Material, Method,
    Serial, Solver, SpringConstants, State, TissueModel, build_model, stability,
};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Rounds over all rows on M, and on both meshes with one and two threads.
const ROUNDS: usize = 40;
const CACHE_ROUNDS: usize = 15;

/// Cells of mesh M, and of a beam of the same shape that no cache holds.
const M: [usize; 3] = [35, 7, 7];
const LARGE: [usize; 3] = [110, 22, 22];

/// Most that an explicit step may cost \[ns\] per tetrahedron.
const GOAL: f64 = 30.0;

/// The system's allocator, with a count of the bytes in use.
struct Counted;

static IN_USE: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on as it came.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        IN_USE.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counted = Counted;

/// Two threads.
struct Pool(rayon::ThreadPool);

impl Executor for Pool {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        self.0.install(|| (0..parts).into_par_iter().for_each(body));
    }
}

/// Times of one row in all rounds \[s\].
#[derive(Default)]
struct Times(Vec<f64>);

impl Times {
    fn fastest(&self) -> f64 {
        self.0.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The median over the fastest, less one.
    fn spread(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2] / sorted[0] - 1.0
    }
}

struct Body {
    model: TissueModel,
    state: State,
    forces: Forces,
    solver: Box<dyn Solver>,
    step: f64,
    /// Of all the above.
    bytes: usize,
}

fn main() -> std::io::Result<()> {
    let results = repository().join("tests/results");
    let (every_table, every_csv) = every_material();
    let (cache_table, cache_csv) = in_and_out_of_cache();
    let text = format!(
        "# Cost of forces and of an explicit step, per tetrahedron

Command: `cargo xtask bench kernels`. Positions, forces and all between are f64; there are no kernels in f32. A step is
Störmer–Verlet with one evaluation of the forces. The rows of a table are measured in turn, round after round, and the fastest
round counts; criterion and divan would measure one after the other and put the machine's slow minutes into the ratios. Times
are this machine's; what carries over are the ratios, all of one run.

## Every material

Mesh M ({} tetrahedra), one thread, {ROUNDS} rounds. Ratios are to springs and volumes.

{every_table}
## In cache and out of it

Without viscosity, {CACHE_ROUNDS} rounds. Bytes are those of model, state and solver, counted by the allocator. Forces are
computed in parts whose sums have the same bits on any number of threads; the rest of a step is one thread's. Goal: at most
{GOAL} ns a step on one thread. What neo-hookean costs over neo-hookean-polynomial is its logarithm, which the crate libm computes
with the same bits everywhere.

{cache_table}",
        tetrahedra(M)
    );
    print!("{text}");
    std::fs::write(results.join("bench_kernels.md"), text)?;
    std::fs::write(results.join("bench_kernels.csv"), every_csv)?;
    std::fs::write(results.join("bench_kernels_cache.csv"), cache_csv)
}

fn tetrahedra(cells: [usize; 3]) -> usize {
    6 * cells.into_iter().product::<usize>()
}

fn beam(cells: [usize; 3]) -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: [0.1, 0.02, 0.02],
        cells,
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block with positive sizes");
    // Fibres along the beam, a second family across it, for the laws that have some.
    mesh.directions = vec![[Vector3::x(), Vector3::y()]; mesh.tets.len()];
    mesh
}

fn springs() -> (String, Behaviour) {
    (
        "springs and volumes".into(),
        Behaviour::Springs(SpringConstants::scaled(1e5, 1e5)),
    )
}

fn continuum(law: LawName, discretisation: Discretisation) -> (String, Behaviour) {
    let constants = ContinuumConstants {
        law: law.into(),
        young: 1e5,
        poisson: 0.45,
        discretisation,
        plasticity: None,
    };
    let name = format!("{}, {}", law.name(), discretisation.name());
    (name, Behaviour::Continuum(constants))
}

impl Body {
    fn new(mesh: &TetMesh, behaviour: Behaviour, relaxation_time: f64) -> Self {
        let before = IN_USE.load(Ordering::Relaxed);
        let material = Material {
            density: 1000.0,
            relaxation_time,
            behaviour,
        };
        let refined = material.is_quadratic().then(|| mesh.refined().mesh);
        let mesh = refined.as_ref().unwrap_or(mesh);
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < -0.0499).collect();
        let model = build_model(mesh, &[(0, material)], &clamped, 0.0, Vec::new())
            .expect("a material in range on a block");
        drop((clamped, refined));
        let mut state = State::at_rest(&model);
        for (position, velocity) in state.positions.iter_mut().zip(&mut state.velocities) {
            let rest = *position;
            *position += Vector3::new(0.1 * rest.x, -0.02 * rest.y, -4.0 * rest.x * rest.x);
            *velocity = Vector3::new(0.0, 0.1 * rest.z, rest.x);
        }
        let solver = Method::StoermerVerlet
            .solver(&model)
            .expect("every set has forces");
        Self {
            bytes: IN_USE.load(Ordering::Relaxed) - before,
            forces: Forces::new(&model),
            step: stability::stable_step(&model, 0.3),
            solver,
            model,
            state,
        }
    }

    /// Times of the forces and of a whole step \[s\].
    fn time(&mut self, exec: &dyn Executor) -> [f64; 2] {
        let control = Control::default();
        let start = Instant::now();
        self.forces
            .compute(&self.model, &self.state, &control, exec);
        let forces = start.elapsed().as_secs_f64();
        let mut state = self.state.clone();
        let start = Instant::now();
        self.solver
            .step(&self.model, &mut state, &control, &[], self.step, exec)
            .expect("a step within the limit");
        [forces, start.elapsed().as_secs_f64()]
    }

    /// Times a round.
    fn measure(&mut self, exec: &dyn Executor, times: &mut [Times; 2]) {
        let round = self.time(exec);
        for (times, time) in times.iter_mut().zip(round) {
            times.0.push(time);
        }
    }
}

/// How far medians lie above the fastest, in the middle of all rows and at most.
fn spread<'a>(times: impl Iterator<Item = &'a Times>) -> String {
    let mut all: Vec<f64> = times.map(Times::spread).collect();
    all.sort_by(f64::total_cmp);
    format!(
        "\nThe median round lies {:.0} % above the fastest in the middle of these figures, {:.0} % at most.\n",
        100.0 * all[all.len() / 2],
        100.0 * all[all.len() - 1]
    )
}

fn every_material() -> (String, String) {
    let mesh = beam(M);
    let laws = LawName::ALL.into_iter();
    let pairs = laws.flat_map(|law| Discretisation::ALL.map(|one| continuum(law, one)));
    // Without and with Kelvin–Voigt viscosity.
    let mut rows: Vec<_> = std::iter::once(springs())
        .chain(pairs)
        .map(|(name, behaviour)| {
            let bodies = [0.0, 1e-4].map(|time| Body::new(&mesh, behaviour, time));
            (name, bodies, <[[Times; 2]; 2]>::default())
        })
        .collect();
    for _ in 0..ROUNDS {
        for (_, bodies, times) in &mut rows {
            for (body, times) in bodies.iter_mut().zip(times) {
                body.measure(&Serial, times);
            }
        }
    }
    let per_tet = |times: &Times| times.fastest() * 1e9 / mesh.tets.len() as f64;
    let base = per_tet(&rows[0].2[0][0]);
    let mut csv = String::from(
        "body,forces_ns_per_tet,step_ns_per_tet,viscous_forces_ns_per_tet,viscous_step_ns_per_tet\n",
    );
    let mut table = String::from(
        "| body | forces [ns] | ratio | step [ns] | viscous forces [ns] | viscous step [ns] |\n|---|---|---|---|---|---|\n",
    );
    for (name, _, [elastic, viscous]) in &rows {
        let [forces, step] = [&elastic[0], &elastic[1]].map(per_tet);
        let [viscous_forces, viscous_step] = [&viscous[0], &viscous[1]].map(per_tet);
        let _ = writeln!(
            table,
            "| {name} | {forces:.1} | {:.2} | {step:.1} | {viscous_forces:.1} | {viscous_step:.1} |",
            forces / base
        );
        let _ = writeln!(
            csv,
            "\"{name}\",{forces:.2},{step:.2},{viscous_forces:.2},{viscous_step:.2}"
        );
    }
    table += &spread(rows.iter().flat_map(|row| row.2.as_flattened()));
    (table, csv)
}

fn in_and_out_of_cache() -> (String, String) {
    let laws = [
        LawName::NeoHookean,
        LawName::StableNeoHookean,
        LawName::NeoHookeanPolynomial,
    ];
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let two = Pool(two.expect("two threads"));
    let threads: [(usize, &dyn Executor); 2] = [(1, &Serial), (2, &two)];
    let mut rows = Vec::new();
    for cells in [M, LARGE] {
        let mesh = beam(cells);
        let continua = laws.map(|law| continuum(law, Discretisation::Tetrahedra));
        for (name, behaviour) in std::iter::once(springs()).chain(continua) {
            let body = Body::new(&mesh, behaviour, 0.0);
            rows.push((name, body, <[[Times; 2]; 2]>::default()));
        }
    }
    for _ in 0..CACHE_ROUNDS {
        for (_, body, times) in &mut rows {
            for ((_, exec), times) in threads.iter().zip(times) {
                body.measure(*exec, times);
            }
        }
    }
    let mut csv = String::from(
        "body,tetrahedra,bytes_per_tet,threads,forces_ns_per_tet,step_ns_per_tet,step_over_m\n",
    );
    let mut table = String::from(
        "| body | tetrahedra | MB | bytes per tetrahedron | forces [ns] | step [ns] | of that on M | goal | step, 2 threads [ns] | speed-up |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    let of_mesh = rows.len() / 2;
    for (index, (name, body, times)) in rows.iter().enumerate() {
        let tets = body.model.tets().len() as f64;
        let per_tet = |times: &Times| times.fastest() * 1e9 / tets;
        let (_, on_m, times_m) = &rows[index % of_mesh];
        let bytes = body.bytes as f64 / tets;
        let [one, more] = [0, 1].map(|k| per_tet(&times[k][1]));
        for ((threads, _), times) in threads.iter().zip(times) {
            let [forces, step] = [&times[0], &times[1]].map(per_tet);
            let base = times_m[threads - 1][1].fastest() * 1e9 / on_m.model.tets().len() as f64;
            let _ = writeln!(
                csv,
                "\"{name}\",{tets},{bytes:.0},{threads},{forces:.2},{step:.2},{:.3}",
                step / base
            );
        }
        let base = times_m[0][1].fastest() * 1e9 / on_m.model.tets().len() as f64;
        let _ = writeln!(
            table,
            "| {name} | {tets} | {:.1} | {bytes:.0} | {:.1} | {one:.1} | {:.2} | {} | {more:.1} | {:.2} |",
            body.bytes as f64 * 1e-6,
            per_tet(&times[0][0]),
            one / base,
            if one <= GOAL { "met" } else { "missed" },
            one / more
        );
    }
    table += &spread(rows.iter().flat_map(|row| row.2.as_flattened()));
    (table, csv)
}
