//! The scripts that pass, played on other meshes.

use crate::level::{Mesh, Strip, refined};
use microsim_tests::changed_levels::ChangedLevels;
use microsim_tests::{finish, scratch, tree};
use std::fmt::Write as _;
use std::path::Path;

/// What the report of a run gives.
#[derive(Clone, Copy, Debug)]
pub struct Passed {
    /// Of the cut to its mark, the largest of the level's \[rad\].
    pub angle: f64,
    /// From its mark \[m\].
    pub distance: f64,
    /// Wall-clock time of the run on one thread \[s\].
    pub time: f64,
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

/// The script that passes a level, on each mesh; `None` where it cuts nothing or is not played.
pub fn play(level: u32, strip: &Strip, meshes: &[(&str, Mesh, bool)]) -> Vec<Option<Passed>> {
    let folder = scratch();
    let script = tree().join(format!(
        "modules/coordination/scripts/level{level}-pass.toml"
    ));
    let meshes = meshes.iter().enumerate();
    let played = meshes.map(|(index, (name, mesh, is_played))| {
        if !is_played {
            return None;
        }
        // Of other levels the marks lie elsewhere; they are not played.
        let changed = ChangedLevels::new("coordination", |text| changed(text, &strip.marks, *mesh));
        let session = folder.path().join(format!("{index}.session"));
        let played = run(&changed, level, &script, &session);
        eprintln!("level {level}: {name}: played");
        played
    });
    played.collect()
}

/// Runs a script to its end and reads the report of its session.
fn run(changed: &ChangedLevels, level: u32, script: &Path, session: &Path) -> Option<Passed> {
    let input = format!("script:{}", script.display());
    let begin = std::time::Instant::now();
    changed.run(
        session,
        &[
            "--no-pictures",
            "--level",
            &level.to_string(),
            "--input",
            &input,
        ],
    );
    let time = begin.elapsed().as_secs_f64();
    let session = session.to_string_lossy();
    let report = finish(&mut changed.command(&["report", &session, "--json"]))
        .expect(0)
        .json();
    let metrics = report["metrics"].as_array()?;
    let value = |id: &str| {
        let metric = metrics.iter().find(|metric| metric["id"] == id)?;
        metric["value"].as_f64()
    };
    Some(Passed {
        angle: value("cut-angle")?,
        distance: value("cut-distance")?,
        time,
        passed: report["verdict"] == "passed",
    })
}
