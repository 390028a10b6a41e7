//! `cargo xtask bench kernels`: what the forces of each kind of element and an explicit step cost per tetrahedron. Prints a
//! table and writes `tests/results/bench_kernels.md` and `bench_kernels.csv`.
//!
//! One thread, block of 35 × 7 × 7 cells (10,290 tetrahedra: mesh M of the reference beam), bent and stretched a little so that
//! no branch is that of the rest shape. The fastest of many repetitions counts, the rows taken in turn so that all see the same
//! machine. Nothing is asserted about time.

use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_tests::repository;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, Contacts, ContinuumConstants, Control, Discretisation, Forces, Material, Method,
    Serial, Solver, SpringConstants, State, TissueModel, build_model, stability,
};
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::time::Instant;

/// Rounds over all rows.
const ROUNDS: usize = 40;

/// One kind of body and what was measured of it.
struct Row {
    name: String,
    /// Without and with Kelvin–Voigt viscosity.
    bodies: [Body; 2],
}

struct Body {
    model: TissueModel,
    state: State,
    forces: Forces,
    solver: Box<dyn Solver>,
    step: f64,
    /// Fastest times of forces and of a whole step [s].
    fastest: [f64; 2],
}

fn main() -> std::io::Result<()> {
    let block = Block {
        center: [0.0; 3],
        size: [0.1, 0.02, 0.02],
        cells: [35, 7, 7],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("a block with positive sizes");
    let mut rows = vec![Row::new(
        "springs and volumes".into(),
        &mesh,
        Behaviour::Springs(SpringConstants::scaled(1e5, 1e5)),
    )];
    for law in LawName::ALL {
        for discretisation in Discretisation::ALL {
            let constants = ContinuumConstants {
                law,
                young: 1e5,
                poisson: 0.45,
                discretisation,
            };
            let name = format!("{}, {}", law.name(), discretisation.name());
            rows.push(Row::new(name, &mesh, Behaviour::Continuum(constants)));
        }
    }
    for _ in 0..ROUNDS {
        for body in rows.iter_mut().flat_map(|row| &mut row.bodies) {
            body.measure();
        }
    }
    write_tables(&rows, mesh.tets.len())
}

impl Row {
    fn new(name: String, mesh: &TetMesh, behaviour: Behaviour) -> Self {
        Self {
            name,
            bodies: [0.0, 1e-4].map(|time| Body::new(mesh, behaviour, time)),
        }
    }
}

impl Body {
    fn new(mesh: &TetMesh, behaviour: Behaviour, relaxation_time: f64) -> Self {
        let material = Material {
            density: 1000.0,
            relaxation_time,
            behaviour,
        };
        let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < -0.0499).collect();
        let model = build_model(mesh, &[(0, material)], &clamped, 0.0, Vec::new())
            .expect("a material in range on a block");
        let mut state = State::at_rest(&model);
        for (position, velocity) in state.positions.iter_mut().zip(&mut state.velocities) {
            let rest = *position;
            *position += Vector3::new(0.1 * rest.x, -0.02 * rest.y, -4.0 * rest.x * rest.x);
            *velocity = Vector3::new(0.0, 0.1 * rest.z, rest.x);
        }
        Self {
            forces: Forces::new(&model),
            solver: Method::StoermerVerlet
                .solver(&model)
                .expect("every set has forces"),
            step: stability::stable_step(&model, 0.3),
            model,
            state,
            fastest: [f64::INFINITY; 2],
        }
    }

    fn measure(&mut self) {
        let control = Control::default();
        let start = Instant::now();
        self.forces
            .compute(&self.model, &self.state, &control, &Serial);
        self.fastest[0] = self.fastest[0].min(start.elapsed().as_secs_f64());
        let mut state = self.state.clone();
        let contacts = Contacts::default();
        let start = Instant::now();
        self.solver
            .step(
                &self.model,
                &mut state,
                &control,
                &contacts,
                self.step,
                &Serial,
            )
            .expect("a step within the limit");
        self.fastest[1] = self.fastest[1].min(start.elapsed().as_secs_f64());
    }
}

fn write_tables(rows: &[Row], tets: usize) -> std::io::Result<()> {
    let per_tet = |time: f64| time * 1e9 / tets as f64;
    let base = per_tet(rows[0].bodies[0].fastest[0]);
    let mut csv = String::from(
        "body,forces_ns_per_tet,step_ns_per_tet,viscous_forces_ns_per_tet,viscous_step_ns_per_tet\n",
    );
    let mut table = String::from(
        "| body | forces [ns] | ratio | step [ns] | viscous forces [ns] | viscous step [ns] |\n|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let [elastic, viscous] = &row.bodies;
        let [forces, step, viscous_forces, viscous_step] = [
            elastic.fastest[0],
            elastic.fastest[1],
            viscous.fastest[0],
            viscous.fastest[1],
        ]
        .map(per_tet);
        let _ = writeln!(
            table,
            "| {} | {forces:.1} | {:.2} | {step:.1} | {viscous_forces:.1} | {viscous_step:.1} |",
            row.name,
            forces / base
        );
        let _ = writeln!(
            csv,
            "\"{}\",{forces:.2},{step:.2},{viscous_forces:.2},{viscous_step:.2}",
            row.name
        );
    }
    let text = format!(
        "# Cost of forces and of an explicit step, per tetrahedron

Command: `cargo xtask bench kernels`. One thread, f64, mesh M ({tets} tetrahedra), fastest of {ROUNDS} rounds over all rows; a
step is Störmer–Verlet with one evaluation of the forces. The times are this machine's; what carries over are the ratios to
springs and volumes, all of one run. Not shown: meshes that do not fit the cache, more threads.

{table}"
    );
    print!("{text}");
    let results = repository().join("tests/results");
    std::fs::write(results.join("bench_kernels.md"), text)?;
    std::fs::write(results.join("bench_kernels.csv"), csv)
}
