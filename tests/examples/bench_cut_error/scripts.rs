//! The scripts that pass, played on other meshes.

use crate::level::{Mesh, Strip, refined};
use microsim_tests::changed_levels::ChangedLevels;
use microsim_tests::{scratch, tree};
use serde_json::Value;
use std::fmt::Write as _;

/// What the report of a run gives.
#[derive(Clone, Copy, Debug)]
pub struct Passed {
    /// Of the cut to its mark, the largest of the level's \[rad\].
    pub angle: f64,
    /// From its mark \[m\].
    pub distance: f64,
    /// Wall-clock time of the run on one thread \[s\].
    pub cpu: f64,
    /// Whether the level was passed.
    pub passed: bool,
}

/// A level on another mesh, as text.
fn changed(level: &str, marks: &[nalgebra::Vector3<f64>], mesh: Mesh) -> String {
    match mesh {
        Mesh::Cells(cells) => level.replace("cells = [20, 2, 1]", &format!("cells = {cells:?}")),
        Mesh::Graded(part, radius) => {
            let mut text = level.to_owned();
            for refine in refined(marks, part, radius) {
                let (point, to) = (
                    refine.point.unwrap_or_default(),
                    refine.to.unwrap_or_default(),
                );
                let _ = write!(
                    text,
                    "\n[[body.refine]]\npoint = {point:?}\nto = {to:?}\nradius = {radius:?}\nsize = {:?}\n",
                    refine.size
                );
            }
            text
        }
    }
}

/// Each level on each mesh; `None` where a run gives no cut.
pub fn play(levels: &[u32], meshes: &[(&str, Mesh)]) -> Result<Vec<Vec<Option<Passed>>>, String> {
    let mut all = Vec::new();
    for level in levels {
        let strip = Strip::open(*level)?;
        let mut of_level = Vec::new();
        for (name, mesh) in meshes {
            let changed = ChangedLevels::new("coordination", |text| {
                // Of other levels the marks lie elsewhere; they are not played.
                changed(text, &strip.marks, *mesh)
            });
            let folder = scratch();
            let script = tree().join(format!(
                "modules/coordination/scripts/level{level}-pass.toml"
            ));
            let input = format!("script:{}", script.display());
            let begin = std::time::Instant::now();
            let report = changed.run(
                &folder.path().join("run.session"),
                &[
                    "--no-pictures",
                    "--level",
                    &level.to_string(),
                    "--input",
                    &input,
                ],
            );
            let cpu = begin.elapsed().as_secs_f64();
            let metrics = report["metrics"].as_array().cloned().unwrap_or_default();
            let value = |id: &str| {
                let metric = metrics.iter().find(|metric| metric["id"] == id);
                metric.and_then(|metric| metric["value"].as_f64())
            };
            let found = value("cut-angle").zip(value("cut-distance"));
            of_level.push(found.map(|(angle, distance)| Passed {
                angle,
                distance,
                cpu,
                passed: report["verdict"] == Value::from("passed"),
            }));
            eprintln!("level {level}: {name}: script");
        }
        all.push(of_level);
    }
    Ok(all)
}
