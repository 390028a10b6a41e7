//! The tables as Markdown.

use crate::beam::{MESHES, TETRAHEDRA};
use crate::exact;
use crate::ours::ENGINE as OURS;
use crate::peers::ENGINES;
use crate::row::Row;
use std::fmt::Write as _;

/// Error of a peak that counts as right.
pub const RIGHT: f64 = 0.03;

/// One of the two measures: its title, which of [`Row::asks`] it is, and what a row costs if it counts.
struct Measure {
    title: String,
    asks: usize,
    cost: fn(&Row) -> Option<f64>,
    columns: &'static str,
    cells: fn(&Row) -> String,
}

/// What a row costs whose first peak is right.
pub fn cost_of_peak(row: &Row) -> Option<f64> {
    row.peak().filter(|error| *error <= RIGHT)?;
    row.cpu_s_per_s
}

/// The whole report.
pub fn markdown(rows: &[Row], missing: &[(&str, String)], cores: usize, minutes: f64) -> String {
    let [s, m, l] = exact::of_meshes().map(|error| format!("{:.0} %", 100.0 * error));
    let mut text = format!(
        "# The reference beam in other engines and in ours

Command: `cargo xtask bench peers`, on a Linux machine with {cores} processor cores; one thread, kept on one core, one run after
another; {minutes:.0} minutes. CPU time is that of the steps alone, the fastest of up to seven repetitions; building a model is not
counted. Times are this machine's and this run's; what carries over are the ratios. Errors are against the exact solution of the same
mesh, law and masses, so they are what a method adds; the meshes themselves sag {s} (S), {m} (M) and {l} (L) less than the exact beam.
Definitions, sources and what is unfair to whom: `tests/peers/README.md`. All runs: `peers.csv`.

![CPU time against error](peers.svg)

"
    );
    for (engine, reason) in missing {
        let _ = writeln!(text, "**{engine} is missing:** {}.\n", cell(reason));
    }
    let peak = Measure {
        title: format!(
            "First peak within {:.0} %, height and time: CPU seconds per simulated second",
            100.0 * RIGHT
        ),
        asks: 0,
        cost: cost_of_peak,
        columns: "CPU s per s | peak | its time | note |\n|---|---|---|---|---|---|---|\n",
        cells: |row| {
            let [height, time] = [row.peak_error, row.peak_time_error].map(percent);
            format!("{} | {height} | {time}", number(row.cpu_s_per_s))
        },
    };
    let rest = Measure {
        title: "Released, to rest and within 1 % of its exact sag from then on: CPU seconds in all"
            .into(),
        asks: 1,
        cost: |row| row.cpu_s_to_rest,
        columns: "CPU s to rest | sag in the end | note |\n|---|---|---|---|---|---|\n",
        cells: |row| {
            let sag = percent(row.rest_error);
            format!("{} | {sag}", number(row.cpu_s_to_rest))
        },
    };
    for measure in [&peak, &rest] {
        best_table(&mut text, rows, measure);
        for (mesh, tetrahedra) in MESHES.iter().zip(TETRAHEDRA) {
            let _ = write!(
                text,
                "\n### All runs on {mesh}, {tetrahedra} tetrahedra\n\n"
            );
            all_table(&mut text, rows, mesh, measure);
        }
    }
    text += "\n## The same beam in other elements, against the exact beam\n\n";
    text += "Elements of an engine's choice instead of the tetrahedra of S, M and L; errors contain those of the mesh.\n\n";
    for measure in [&peak, &rest] {
        all_table(&mut text, rows, exact::BEAM.1, measure);
        text.push('\n');
    }
    text += "## Settings\n\n| engine | version | method | settings |\n|---|---|---|---|\n";
    let mut told = Vec::new();
    // Rows that were left out know no version.
    for row in rows.iter().filter(|row| !row.version.is_empty()) {
        let line = [&row.engine, &row.version, &row.method, &row.settings].map(|t| cell(t));
        if !told.contains(&line) {
            let _ = writeln!(text, "| {} |", line.join(" | "));
            told.push(line);
        }
    }
    text
}

/// Per engine and mesh the row with the lowest cost.
fn best_table(text: &mut String, rows: &[Row], measure: &Measure) {
    let [s, m, l] = TETRAHEDRA;
    let _ = write!(
        text,
        "## {}\n\nThe cheapest run of each.\n\n| engine | S, {s} tetrahedra | M, {m} | L, {l} |\n|---|---|---|---|\n",
        measure.title
    );
    let mut line = |engine: &str| {
        let _ = write!(text, "| {engine} |");
        MESHES.map(|mesh| {
            let of = |row: &&Row| row.engine == engine && row.mesh == mesh;
            let costs = rows
                .iter()
                .filter(of)
                .filter_map(|row| Some(((measure.cost)(row)?, row)));
            let best = costs.min_by(|a, b| a.0.total_cmp(&b.0));
            let _ = match best {
                Some((cost, row)) => {
                    write!(
                        text,
                        " **{}** {}, {} |",
                        figure(cost),
                        row.method,
                        step(row)
                    )
                }
                None => write!(text, " – |"),
            };
            if mesh == MESHES[MESHES.len() - 1] {
                text.push('\n');
            }
            best.map_or(f64::INFINITY, |best| best.0)
        })
    };
    let mut lowest = [f64::INFINITY; 3];
    for engine in ENGINES {
        let costs = line(engine.title);
        lowest = std::array::from_fn(|i| lowest[i].min(costs[i]));
    }
    let ours = line(OURS);
    text.push_str("| cheapest other engine / ours |");
    for (other, ours) in lowest.into_iter().zip(ours) {
        let ratio = other / ours;
        let _ = match ratio.is_finite() && ratio > 0.0 {
            true => write!(text, " {ratio:.2} |"),
            false => write!(text, " – |"),
        };
    }
    text.push('\n');
}

fn all_table(text: &mut String, rows: &[Row], mesh: &str, measure: &Measure) {
    let of = |row: &&Row| row.mesh == mesh && row.asks[measure.asks];
    let _ = write!(text, "| engine | method | step | {}", measure.columns);
    for row in rows.iter().filter(of) {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} |",
            row.engine,
            row.method,
            step(row),
            (measure.cells)(row),
            cell(&row.note)
        );
    }
}

/// Text that keeps a table whole.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// The step with its unit.
pub fn step(row: &Row) -> String {
    // Steps at a share of the limit are not round.
    format!("{} ms", (row.step * 1e6).round() / 1e3)
}

/// A fraction in percent, or a dash.
pub fn percent(share: Option<f64>) -> String {
    share.map_or("–".into(), |v| format!("{:+.2} %", 100.0 * v))
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".into(), figure)
}

/// Three digits that count.
pub fn figure(value: f64) -> String {
    let digits = 2 - value.abs().log10().floor().clamp(-6.0, 2.0) as i32;
    format!("{value:.*}", digits.max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(engine: &str, cpu_s_per_s: f64, peak_error: f64) -> Row {
        Row {
            engine: engine.into(),
            method: "method".into(),
            mesh: "S".into(),
            step: 0.001,
            asks: [true, false],
            cpu_s_per_s: Some(cpu_s_per_s),
            peak_error: Some(peak_error),
            peak_time_error: Some(0.0),
            ..Row::default()
        }
    }

    #[test]
    fn the_cheapest_right_run_counts() {
        let rows = [
            row("MuJoCo", 0.1, -0.031),
            row("MuJoCo", 0.3, -0.029),
            row("MuJoCo", 0.4, 0.0),
            row("Drake", 0.6, 0.0),
            row(OURS, 0.15, 0.01),
        ];
        let text = markdown(&rows, &[("pyPBD", "a | b".into())], 2, 1.0);
        for line in [
            "**pyPBD is missing:** a \\| b.",
            "| MuJoCo | **0.300** method, 1 ms | – | – |",
            "| cheapest other engine / ours | 2.00 | – | – |",
        ] {
            assert!(text.lines().any(|other| other == line), "{line}\n{text}");
        }
    }

    #[test]
    fn figures_keep_three_digits() {
        let written = [0.00012345, 0.5, 12.345, 1234.5].map(figure);
        assert_eq!(written, ["0.000123", "0.500", "12.3", "1234"]);
    }
}
