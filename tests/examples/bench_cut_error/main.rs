//! `cargo xtask bench cut-error`: what the mesh adds to angle and place of a cut in the levels of coordination that cut, on the mesh as shipped, on uniform
//! finer ones and on graded ones; and what a tick costs on each. Writes `tests/results/bench_cut_error.md`.
//!
//! Exact straight blades go through the body of each level at random places around its marks, once at rest, where the plane is known, and once as the clamps have
//! stretched it, where a fine mesh stands for the truth; then the scripts that pass play on the same meshes. `-- LEVEL...` measures single levels and writes nothing.

mod blade;
mod level;
mod scripts;

use blade::{Lips, Plane};
use level::{Mesh, Strip};
use microsim_tests::repository;
use microsim_tests::statistics::percentile;
use std::fmt::Write as _;
use std::process::ExitCode;

/// Levels that cut.
const LEVELS: [u32; 5] = [2, 3, 4, 5, 6];

/// Cuts of each level.
const CUTS: usize = 20;

/// Of the random places.
const SEED: u64 = 2026;

/// The meshes, each with the number of players of [`scripts::play`].
const MESHES: [(&str, Mesh, usize); 8] = [
    ("as shipped, 20 × 2 × 1", Mesh::Cells([20, 2, 1]), 3),
    ("uniform, 30 × 3 × 2", Mesh::Cells([30, 3, 2]), 1),
    ("uniform, 40 × 4 × 2", Mesh::Cells([40, 4, 2]), 3),
    ("uniform, 60 × 6 × 3", Mesh::Cells([60, 6, 3]), 0),
    ("graded, ½ within 0.5 mm", Mesh::Graded(0.5, 0.5e-3), 3),
    ("graded, ¼ within 0.5 mm", Mesh::Graded(0.25, 0.5e-3), 0),
    ("graded, ¼ within 0.2 mm", Mesh::Graded(0.25, 0.2e-3), 1),
    (
        "graded, ⅙ within 0.2 mm",
        Mesh::Graded(1.0 / 6.0, 0.2e-3),
        0,
    ),
];

/// The place among them of the mesh with which players on others are compared.
const FINE: usize = 2;

/// The mesh that stands for the truth where no plane is known.
const TRUTH: Mesh = Mesh::Cells([80, 8, 4]);

/// What is aimed at: angle \[rad\] and place \[m\].
const AIM: (f64, f64) = (3.0 * std::f64::consts::PI / 180.0, 20e-6);

/// What a mesh adds to each cut of a level.
struct Row {
    mesh: &'static str,
    elements: usize,
    /// CPU time of a tick at rest, with the forceps on the tissue \[ms\].
    tick: f64,
    /// The shortest height of an element over that of the mesh as shipped.
    height: f64,
    /// Cuts that came apart in two.
    parted: usize,
    /// Lips of the cut against the plane of the blade, at rest.
    lips: Vec<Lips>,
    /// The plane of the metric against that on the finest mesh, in stretched tissue: angle \[rad\], place \[m\].
    metric: Vec<(f64, f64)>,
}

/// Median and largest.
fn spread(values: impl Iterator<Item = f64>, scale: f64, digits: usize) -> String {
    let values: Vec<f64> = values.map(|value| value * scale).collect();
    let [half, most] = [0.5, 1.0].map(|share| percentile(&values, share));
    format!("{half:.digits$} / {most:.digits$}")
}

/// All meshes of a level.
fn measure(level: u32) -> Result<Vec<Row>, String> {
    let strip = Strip::open(level)?;
    let planes = blade::planes(&strip.marks, CUTS, SEED + u64::from(level));
    let truth = strip.with(TRUTH)?.stretched()?;
    let truth: Vec<Plane> = planes
        .iter()
        .map(|plane| truth.path(plane))
        .collect::<Result<_, _>>()?;
    let marks = strip.cut_marks(&planes);
    let mut shortest = None;
    let mut rows = Vec::new();
    for (name, mesh, _) in MESHES {
        let body = strip.with(mesh)?;
        let height = body.mesh().shortest_height();
        let lips: Vec<Lips> = planes
            .iter()
            .map(|plane| blade::lips(body.mesh(), plane))
            .collect::<Result<_, _>>()?;
        let stretched = body.stretched()?;
        let metric = planes.iter().zip(&truth).zip(&marks);
        let metric: Vec<(f64, f64)> = metric
            .map(|((plane, truth), mark)| Ok(stretched.path(plane)?.differs(truth, mark)))
            .collect::<Result<_, String>>()?;
        rows.push(Row {
            mesh: name,
            elements: body.mesh().tets.len(),
            tick: body.tick_under_forceps()?,
            height: height / *shortest.get_or_insert(height),
            parted: lips.iter().filter(|lips| lips.parted).count(),
            lips,
            metric,
        });
        eprintln!("level {level}: {name}");
    }
    Ok(rows)
}

/// The rows of a level as a table.
fn table(rows: &[Row], played: &[scripts::Played]) -> String {
    let mut text = String::from(
        "| mesh | tetrahedra | tick at rest, forceps on it [ms] | shortest height | in two | lips: angle [°] | lips: place [µm] | lips: scatter [µm] | metric: angle [°] | metric: place [µm] | script that passes: angle [°] | place [µm] | time [s] | trainees, against 40 × 4 × 2: angle [°] | place [µm] |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (row, players) in rows.iter().zip(played) {
        let degrees = 1f64.to_degrees();
        let within = row.lips.iter().all(|l| l.angle < AIM.0 && l.place < AIM.1);
        let name = if within {
            format!("**{}**", row.mesh)
        } else {
            row.mesh.to_owned()
        };
        let script = match players.first() {
            Some(Some(script)) => format!(
                "{:.1} | {:.0} | {:.1}{}",
                script.angle * degrees,
                script.distance * 1e6,
                script.time,
                if script.passed { "" } else { " (not passed)" }
            ),
            Some(None) => "no cut | – | –".to_owned(),
            None => "– | – | –".to_owned(),
        };
        let pairs = players.iter().zip(&played[FINE]).skip(1);
        let pairs = pairs.filter_map(|(here, fine)| Some(((*here)?, (*fine)?)));
        let (angles, places): (Vec<String>, Vec<String>) = pairs
            .map(|(here, fine)| {
                let angle = format!("{:+.1}", (here.angle - fine.angle) * degrees);
                (
                    angle,
                    format!("{:+.0}", (here.distance - fine.distance) * 1e6),
                )
            })
            .unzip();
        let script = format!("{script} | {} | {}", angles.join(", "), places.join(", "));
        let _ = writeln!(
            text,
            "| {name} | {} | {:.2} | {:.2} | {} of {} | {} | {} | {} | {} | {} | {script} |",
            row.elements,
            row.tick,
            row.height,
            row.parted,
            row.lips.len(),
            spread(row.lips.iter().map(|l| l.angle), degrees, 1),
            spread(row.lips.iter().map(|l| l.place), 1e6, 0),
            spread(row.lips.iter().map(|l| l.scatter), 1e6, 0),
            spread(row.metric.iter().map(|m| m.0), degrees, 2),
            spread(row.metric.iter().map(|m| m.1), 1e6, 1),
        );
    }
    text
}

fn run() -> Result<(), String> {
    let some: Vec<u32> = std::env::args()
        .skip(1)
        .filter_map(|word| word.parse().ok())
        .collect();
    let levels = if some.is_empty() {
        LEVELS.to_vec()
    } else {
        some.clone()
    };
    let played = scripts::play(&levels, &MESHES)?;
    let mut tables = String::new();
    for (level, played) in levels.iter().zip(&played) {
        let rows = measure(*level)?;
        let _ = write!(tables, "\n## Level {level}\n\n{}", table(&rows, played));
    }
    println!("{tables}");
    if !some.is_empty() {
        return Ok(());
    }
    let text = format!("{}{tables}", include_str!("page.md"));
    let page = repository().join("tests/results/bench_cut_error.md");
    std::fs::write(&page, text).map_err(|error| format!("{}: {error}", page.display()))
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("bench cut-error: {message}");
            ExitCode::FAILURE
        }
    }
}
