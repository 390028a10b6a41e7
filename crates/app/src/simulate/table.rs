//! What `simulate` prints for people.

use crate::scene_file::SceneFile;
use microsim_scene::{Divergence, End, Runner, Verdict};
use microsim_settings as settings;
use nalgebra::Vector3;
use serde_json::Value;
use settings::{Override, Unit};
use std::path::Path;

/// What is going to be simulated.
pub fn heading(file: &SceneFile, path: &Path) -> String {
    let (scene, runner) = (&file.loaded.settings, &file.runner);
    let mut lines = vec![
        format!("{}: {}", scene.title.en, scene.summary.en),
        format!("  scene     {}", path.display()),
    ];
    for (index, body) in scene.body.iter().enumerate() {
        let built = runner.scene();
        lines.push(format!(
            "  body      {}: {} tetrahedra, {} nodes, {}",
            body.name,
            built.body(index).element_count(),
            built.body(index).rest_positions().len(),
            extent(built.body(index).rest_positions())
        ));
        let values = &file.loaded.document.value()["body"][index]["material"];
        for (material, value) in body
            .material
            .iter()
            .zip(values.as_array().into_iter().flatten())
        {
            lines.push(format!("  material  {}", material_line(material, value)));
        }
    }
    let end = match scene.run.end {
        settings::End::Time => Unit::Time.describe(scene.run.duration),
        settings::End::Rest => format!(
            "until it rests, {} at most",
            Unit::Time.describe(scene.run.duration)
        ),
        settings::End::Divergence => format!(
            "which is to diverge within {}",
            Unit::Time.describe(scene.run.duration)
        ),
    };
    lines.push(format!(
        "  method    {}, step {}, {end}",
        runner.scene().method().name(),
        Unit::Time.describe(round(runner.step())),
    ));
    lines.join("\n")
}

/// Size of a body along the axes of the world, which shows a mesh whose unit is not what was meant.
fn extent(positions: &[Vector3<f64>]) -> String {
    let sides = [0, 1, 2].map(|axis| {
        let along = || positions.iter().map(|x| x[axis]);
        let (low, high) = (
            along().fold(f64::INFINITY, f64::min),
            along().fold(f64::NEG_INFINITY, f64::max),
        );
        format!("{}", round((high - low) * 1e3))
    });
    format!("{} mm", sides.join(" × "))
}

/// Law and constants of a material, as the file names them.
fn material_line(material: &settings::Material, value: &Value) -> String {
    let text = |key: &str| value[key].as_str().map(str::to_owned);
    let quantity = |key: &str, symbol: &str, unit: Unit| {
        let si = value[key].as_f64()?;
        Some(format!("{symbol} {}", unit.describe(round(si))))
    };
    let parts = [
        material.region.map(|region| format!("region {region}")),
        text("law"),
        text("form"),
        text("discretisation"),
        quantity("youngs_modulus", "E", Unit::Pressure),
        quantity("poisson_ratio", "nu", Unit::Ratio),
        quantity("stretch_modulus", "stretch", Unit::Pressure),
        quantity("volume_modulus", "volume", Unit::Pressure),
        quantity("density", "density", Unit::Density),
        quantity("viscosity", "viscosity", Unit::Viscosity),
        quantity("relaxation_time", "relaxation", Unit::Time),
    ];
    let parameters = match material.law {
        settings::Law::Springs => &[][..],
        settings::Law::Continuum(law) => law.parameters(),
    };
    let of_law = parameters.iter();
    let of_law = of_law.filter_map(|(key, unit)| quantity(key, key, *unit));
    let parts = parts.into_iter().flatten().chain(of_law);
    parts.collect::<Vec<_>>().join(", ")
}

/// How it ended, what it cost, and what came out.
pub fn result(file: &SceneFile, cpu_s: f64) -> String {
    let (scene, runner) = (&file.loaded.settings, &file.runner);
    let time = runner.scene().time();
    let ended = match runner.end() {
        Some(End::Diverged(diverged)) => format!(
            "Diverged at {:.6} s, after {} steps: body '{}' {}; {}",
            diverged.time,
            file.step_of(diverged),
            diverged.body_name,
            diverged.what,
            advice(runner, &diverged.what)
        ),
        Some(End::Rest) => format!("Rests after {}", Unit::Time.describe(round(time))),
        _ if file.stable_unexpectedly() => format!(
            "Did not diverge within {}, which was expected",
            Unit::Time.describe(scene.run.duration)
        ),
        _ if file.restless() => file.restless_sentence(),
        _ => format!("Simulated {}", Unit::Time.describe(round(time))),
    };
    // A run that diverged in its first step has simulated nothing.
    let per_second = match time > 0.0 {
        true => format!(", {:.3} per simulated second", cpu_s / time),
        false => String::new(),
    };
    let mut lines = vec![format!(
        "{ended}: {} steps, {cpu_s:.3} CPU seconds{per_second}",
        runner.steps(),
    )];
    if !runner.recoveries().is_empty() {
        lines.push(format!(
            "{} samples were computed again with shorter steps",
            runner.recoveries().len()
        ));
    }
    match runner.remarks().unconverged {
        0 => {}
        1 => lines.push("1 step ended above the tolerance of the method".to_owned()),
        count => lines.push(format!(
            "{count} steps ended above the tolerance of the method"
        )),
    }
    lines.extend(file.run_sentences());
    let mut rows = Vec::new();
    for (probe, values) in scene.probe.iter().zip(&runner.series().probes) {
        let watched = !scene.expect.iter().any(|e| e.probe == probe.name);
        if let (true, Some(last)) = (watched, values.last()) {
            let found = number(probe.quantity.unit(), *last);
            rows.push([probe.name.clone(), "at-end".into(), String::new(), found].to_vec());
        }
    }
    let verdicts = runner.verdicts();
    rows.extend(verdicts.iter().map(|verdict| row(scene, verdict)));
    if !rows.is_empty() {
        let heading = [
            "probe",
            "what",
            "expected",
            "found",
            "error",
            "tolerance",
            "",
        ];
        rows.insert(0, heading.map(str::to_owned).to_vec());
        lines.push(columns(&rows));
    }
    for expect in &scene.expect {
        let regression = match expect.regression {
            true => "regression, our own output: ",
            false => "",
        };
        lines.push(format!(
            "{} {}: {regression}{}",
            expect.probe,
            expect.what.name(),
            expect.source
        ));
    }
    lines.join("\n")
}

/// That what is expected is expected of the file as it is, where the command line changes that and something was missed.
pub fn of_another_scene(runner: &Runner, set: &[Override], without: &[String]) -> Option<String> {
    let missed = runner.verdicts().iter().any(|verdict| !verdict.met);
    missed.then(|| changed(set, without)).flatten()
}

fn changed(set: &[Override], without: &[String]) -> Option<String> {
    let set = set.iter().map(|value| format!("--set {}", value.text()));
    let without = without.iter().map(|what| format!("--without {what}"));
    let options: Vec<String> = set.chain(without).collect();
    (!options.is_empty()).then(|| {
        format!(
            "what is expected is expected of the file as it is; this run has {}",
            options.join(" ")
        )
    })
}

/// What helps against a divergence with the method of a run.
fn advice(runner: &Runner, what: &Divergence) -> &'static str {
    if what.is_unconverged() {
        "use a shorter step (--set run.step=...), or let steps end with what is left (--set method.must_converge=false)"
    } else if runner.scene().method().is_explicit() {
        "use a shorter step (--set run.step=...), an implicit method, or containment (--set run.containment=true)"
    } else {
        "use a shorter step (--set run.step=...), or containment (--set run.containment=true)"
    }
}

fn row(scene: &settings::Scene, verdict: &Verdict) -> Vec<String> {
    let expect = &scene.expect[verdict.expect];
    let probe = scene.probe.iter().find(|probe| probe.name == expect.probe);
    let unit = probe.map_or(Unit::Ratio, |probe| expect.what.unit(probe.quantity));
    let number = |value: f64| number(unit, value);
    vec![
        expect.probe.clone(),
        expect.what.name().to_owned(),
        number(expect.value),
        verdict.found.map_or("not found".to_owned(), number),
        verdict.error.map_or(String::new(), percent),
        percent(expect.tolerance).replace('+', ""),
        match (verdict.met, expect.regression) {
            (true, false) => "met",
            (false, false) => "MISSED",
            (true, true) => "as before",
            (false, true) => "CHANGED",
        }
        .to_owned(),
    ]
}

/// Rows in columns as wide as they need.
fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or_default();
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells
            .map(|cell| cell.chars().count())
            .max()
            .unwrap_or_default()
    };
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell:<width$}"));
        format!("  {}", cells.collect::<Vec<_>>().join("  "))
            .trim_end()
            .to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// A value with five digits in a unit that suits its size; lengths below a metre in millimetres.
fn number(unit: Unit, value: f64) -> String {
    let millimetres = unit == Unit::Length && (1e-4..1.0).contains(&value.abs());
    if let (true, Some(shown)) = (millimetres, unit.from_si(value, "mm")) {
        return format!("{} mm", round(shown));
    }
    let text = unit.describe(round(value));
    // Smaller than the smallest symbol: zeros show nothing.
    if text.contains("0.000") {
        let symbol = if unit == Unit::Ratio {
            ""
        } else {
            unit.symbol()
        };
        return format!("{value:.4e} {symbol}").trim_end().to_owned();
    }
    text
}

/// A ratio with its sign: 0.0312 as "+3.12 %", 2e-7 as "+2.0e-7".
fn percent(ratio: f64) -> String {
    if ratio != 0.0 && ratio.abs() < 5e-5 {
        return format!("{ratio:+.1e}");
    }
    format!("{:+.2} %", ratio * 100.0)
}

/// Five digits are enough for people.
fn round(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `--set body.0.brittleness=0` is to hold, and then was only MISSED.
    #[test]
    fn what_is_missed_of_a_changed_scene_is_said_to_be_of_the_file() {
        assert_eq!(changed(&[], &[]), None);
        let set = [Override::parse("body.0.brittleness=0").expect("an override")];
        let without = ["friction".to_owned()];
        let said = "what is expected is expected of the file as it is; this run has --set body.0.brittleness=0 --without friction";
        assert_eq!(changed(&set, &without).as_deref(), Some(said));
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let rows = [
            vec!["a".to_owned(), "bc".to_owned()],
            vec!["def".to_owned()],
        ];
        assert_eq!(columns(&rows), "  a    bc\n  def");
        let corners = [Vector3::zeros(), Vector3::new(0.06, -0.006, 4.0)];
        assert_eq!(extent(&corners), "60 × 6 × 4000 mm");
        assert_eq!(round(0.000123456), 0.00012346);
        assert_eq!(number(Unit::Length, 0.0321084), "32.108 mm");
        assert_eq!(number(Unit::Force, 7.614e-12), "7.6140e-12 N");
        assert_eq!(number(Unit::Ratio, 0.5), "0.5");
        assert_eq!(
            (percent(0.0312), percent(-2e-7)),
            ("+3.12 %".into(), "-2.0e-7".into())
        );
    }
}
