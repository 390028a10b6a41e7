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

/// The meshes, and whether the scripts that pass play on each.
const MESHES: [(&str, Mesh, bool); 8] = [
    ("as shipped, 20 × 2 × 1", Mesh::Cells([20, 2, 1]), true),
    ("uniform, 30 × 3 × 2", Mesh::Cells([30, 3, 2]), true),
    ("uniform, 40 × 4 × 2", Mesh::Cells([40, 4, 2]), false),
    ("uniform, 60 × 6 × 3", Mesh::Cells([60, 6, 3]), false),
    ("graded, ½ within 0.5 mm", Mesh::Graded(0.5, 0.5e-3), true),
    ("graded, ¼ within 0.5 mm", Mesh::Graded(0.25, 0.5e-3), false),
    ("graded, ¼ within 0.2 mm", Mesh::Graded(0.25, 0.2e-3), false),
    (
        "graded, ⅙ within 0.2 mm",
        Mesh::Graded(1.0 / 6.0, 0.2e-3),
        false,
    ),
];

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
fn measure(level: u32, strip: &Strip) -> Result<Vec<Row>, String> {
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
fn table(rows: &[Row], played: &[Option<scripts::Passed>]) -> String {
    let mut text = String::from(
        "| mesh | tetrahedra | tick at rest, forceps on it [ms] | shortest height | in two | lips: angle [°] | lips: place [µm] | lips: scatter [µm] | metric: angle [°] | metric: place [µm] | script that passes: angle [°] | place [µm] | time [s] |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (row, script) in rows.iter().zip(played) {
        let degrees = 1f64.to_degrees();
        let within = row.lips.iter().all(|l| l.angle < AIM.0 && l.place < AIM.1);
        let name = if within {
            format!("**{}**", row.mesh)
        } else {
            row.mesh.to_owned()
        };
        let script = match script {
            Some(script) => format!(
                "{:.1} | {:.0} | {:.1}{}",
                script.angle * degrees,
                script.distance * 1e6,
                script.time,
                if script.passed { "" } else { " (not passed)" }
            ),
            None => "– | – | –".to_owned(),
        };
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
    let words: Vec<String> = std::env::args().skip(1).collect();
    let some: Vec<u32> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let levels = if some.is_empty() {
        LEVELS.to_vec()
    } else {
        some
    };
    let mut tables = String::new();
    for level in levels {
        let strip = Strip::open(level)?;
        let played = scripts::play(level, &strip, &MESHES);
        let table = table(&measure(level, &strip)?, &played);
        let _ = write!(tables, "\n## Level {level}\n\n{table}");
    }
    println!("{tables}");
    if !words.is_empty() {
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
