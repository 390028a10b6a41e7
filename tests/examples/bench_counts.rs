//! `cargo xtask bench counts`: instructions per tetrahedron of the kernels that solvers spend their time in, counted by
//! `valgrind --tool=callgrind` and compared with `tests/results/counts.csv`. `-- --record` writes that file again.
//!
//! The program runs itself under callgrind, each kernel with no repetition and with some: the difference is the kernel alone.
//! Mesh S of the reference beam (810 tetrahedra), one thread, bent so that no branch is that of the rest shape.
//!
//! Exit status: 0 within the margin (`microsim_tests::counts`), or recorded by another compiler, which the program then reports;
//! 1 beyond it; 2 could not count.

use microsim_mesh::{Block, CellSplit};
use microsim_sparse::{Factor, Lattice, TwoLevel};
use microsim_tests::counts::{Counts, MARGIN, PLAIN_COPIES, collected};
use microsim_tests::repository;
use microsim_tests::system::{System, analyse};
use microsim_tissue::elements::Tangent;
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Forces, Material, Serial,
    SpringConstants, State, TissueModel, build_model,
};
use nalgebra::Vector3;
use std::env;
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode};

/// How often a kernel is repeated.
const REPETITIONS: u32 = 20;

/// Kernels in the order of the table.
const KERNELS: [&str; 10] = [
    "forces, springs and volumes",
    "forces, neo-hookean",
    "forces, stable-neo-hookean",
    "forces, neo-hookean-polynomial",
    "assembly, exact",
    "assembly, positive",
    "factor, single numbers",
    "solution, single numbers",
    "preparation, two levels",
    "application, two levels",
];

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let result = match words[..] {
        ["--kernel", kernel, repetitions] => match repetitions.parse() {
            Ok(repetitions) => {
                run(kernel, repetitions);
                return ExitCode::SUCCESS;
            }
            Err(_) => Err(format!("{repetitions} is no number of repetitions")),
        },
        [] => compare(),
        ["--record"] => record(),
        _ => Err("the only option is --record".into()),
    };
    result.unwrap_or_else(|error| {
        eprintln!("bench counts: {error}");
        ExitCode::from(2)
    })
}

fn table() -> std::path::PathBuf {
    repository().join("tests/results/counts.csv")
}

fn record() -> Result<ExitCode, String> {
    let counts = count()?;
    let csv = counts.to_csv();
    fs::write(table(), &csv).map_err(|e| format!("{}: {e}", table().display()))?;
    print!("{csv}");
    Ok(ExitCode::SUCCESS)
}

fn compare() -> Result<ExitCode, String> {
    let path = table();
    let text = fs::read_to_string(&path);
    let text = text.map_err(|e| format!("{}: {e}; `-- --record` writes it", path.display()))?;
    let recorded = Counts::from_csv(&text)
        .map_err(|line| format!("{}:{line}: no row of this table", path.display()))?;
    let counts = count()?;
    let comparison = counts.compare(&recorded);
    println!("{}", comparison.table);
    if !comparison.same_build {
        println!(
            "Recorded by {}, now {}: the differences are those of compilers, and nothing is checked. `-- --record` writes the table anew.",
            recorded.build, counts.build
        );
        return Ok(ExitCode::SUCCESS);
    }
    if comparison.beyond.is_empty() {
        println!(
            "All within {:.1} % of what was recorded by the same compiler.",
            100.0 * MARGIN
        );
        return Ok(ExitCode::SUCCESS);
    }
    println!(
        "Beyond {:.1} % of what was recorded by the same compiler:",
        100.0 * MARGIN
    );
    for kernel in &comparison.beyond {
        println!("- {kernel}");
    }
    println!("Where that is meant, `cargo xtask bench counts -- --record` writes the table anew.");
    Ok(ExitCode::FAILURE)
}

/// The counts of this build.
fn count() -> Result<Counts, String> {
    let program = env::current_exe().map_err(|e| format!("this program has no file: {e}"))?;
    let tets = model(springs()).tets().len() as f64;
    let kernels = KERNELS.iter().map(|kernel| {
        let [without, with] = [0, REPETITIONS].map(|n| instructions(&program, kernel, n));
        let difference = with?.saturating_sub(without?) as f64;
        Ok((
            (*kernel).to_owned(),
            difference / f64::from(REPETITIONS) / tets,
        ))
    });
    Ok(Counts {
        kernels: kernels.collect::<Result<_, String>>()?,
        build: build()?,
    })
}

/// Compiler and instruction set.
fn build() -> Result<String, String> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let printed = Command::new(&rustc).arg("--version").output();
    let printed = printed.map_err(|e| format!("{} cannot be asked: {e}", rustc.display()))?;
    let set = match cfg!(all(target_feature = "avx2", target_feature = "fma")) {
        true => "AVX2 and FMA",
        false => "without AVX2 and FMA",
    };
    Ok(format!(
        "{}, {set}",
        String::from_utf8_lossy(&printed.stdout).trim()
    ))
}

/// Instructions of this program with one kernel.
fn instructions(program: &Path, kernel: &str, repetitions: u32) -> Result<u64, String> {
    let mut valgrind = Command::new("valgrind");
    valgrind
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(["--kernel", kernel, &repetitions.to_string()])
        .env(PLAIN_COPIES.0, PLAIN_COPIES.1);
    let output = valgrind.output().map_err(|error| {
        format!(
            "valgrind cannot be started ({error}): install it, on Debian and Ubuntu with `apt-get install valgrind`"
        )
    })?;
    let printed = String::from_utf8_lossy(&output.stderr);
    match collected(&printed) {
        Some(count) if output.status.success() => Ok(count),
        _ => Err(format!("{kernel}: callgrind did not count: {printed}")),
    }
}

fn springs() -> Behaviour {
    Behaviour::Springs(SpringConstants::scaled(1e5, 1e5))
}

fn continuum(law: LawName) -> Behaviour {
    Behaviour::Continuum(ContinuumConstants {
        law: law.into(),
        young: 1e5,
        poisson: 0.45,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    })
}

fn model(behaviour: Behaviour) -> TissueModel {
    let block = Block {
        center: [0.05, 0.0, 0.0],
        size: [0.1, 0.02, 0.02],
        cells: [15, 3, 3],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("a block with positive sizes");
    let material = Material {
        density: 1000.0,
        relaxation_time: 0.0,
        behaviour,
    };
    let clamped: Vec<bool> = mesh.positions.iter().map(|p| p.x < 1e-6).collect();
    build_model(&mesh, &[(0, material)], &clamped, 0.0, Vec::new())
        .expect("a material in range on a block")
}

/// Bent and stretched.
fn state(model: &TissueModel) -> State {
    let mut state = State::at_rest(model);
    for position in &mut state.positions {
        let rest = *position;
        *position += Vector3::new(0.1 * rest.x, -0.02 * rest.y, -4.0 * rest.x * rest.x);
    }
    state
}

/// Prepares all of a kernel, then runs it so often.
fn run(kernel: &str, repetitions: u32) {
    let behaviour = match kernel {
        "forces, springs and volumes" => springs(),
        "forces, neo-hookean" => continuum(LawName::NeoHookean),
        "forces, neo-hookean-polynomial" => continuum(LawName::NeoHookeanPolynomial),
        _ => continuum(LawName::StableNeoHookean),
    };
    let model = model(behaviour);
    let state = state(&model);
    if kernel.starts_with("forces") {
        let (mut forces, control) = (Forces::new(&model), Control::default());
        for _ in 0..repetitions {
            forces.compute(&model, &state, &control, &Serial);
        }
        return;
    }
    let fixed: Vec<bool> = (0..model.node_count())
        .map(|node| model.is_clamped(node))
        .collect();
    let mut system = System::new(&model);
    system.assemble(&model, &state, Tangent::Positive);
    let mut factor = Factor::<f32>::new(analyse(&model, system.matrix.pattern()));
    let mut factorise = |system: &System| {
        factor
            .factorise(&system.matrix, Some(&fixed))
            .expect("a clamped beam");
    };
    match kernel {
        "assembly, exact" | "assembly, positive" => {
            let tangent = match kernel {
                "assembly, exact" => Tangent::Exact,
                _ => Tangent::Positive,
            };
            for _ in 0..repetitions {
                system.assemble(&model, &state, tangent);
            }
        }
        "factor, single numbers" => {
            for _ in 0..repetitions {
                factorise(&system);
            }
        }
        "preparation, two levels" => {
            let mut two_level = two_level(&model, &system);
            for _ in 0..repetitions {
                two_level
                    .refresh(&system.matrix, &fixed)
                    .expect("a clamped beam");
            }
        }
        "application, two levels" => {
            let mut two_level = two_level(&model, &system);
            two_level
                .refresh(&system.matrix, &fixed)
                .expect("a clamped beam");
            let x = vec![Vector3::z(); model.node_count()];
            let mut z = x.clone();
            for _ in 0..repetitions {
                two_level.apply(&x, &mut z);
            }
        }
        "solution, single numbers" => {
            factorise(&system);
            let mut x = vec![Vector3::z(); model.node_count()];
            for _ in 0..repetitions {
                factor.solve(&mut x);
            }
        }
        _ => panic!("there is no kernel {kernel:?}"),
    }
}

/// Cells of 3.5 edges, as solvers have them.
fn two_level(model: &TissueModel, system: &System) -> TwoLevel {
    let lattice = Lattice::new(model.rest_positions(), 3.5 * 0.1 / 15.0);
    TwoLevel::new(system.matrix.pattern(), lattice)
}
