//! The scripts that pass, played on other meshes.

use crate::level::{Mesh, Strip, refined};
use microsim_tests::changed_levels::ChangedLevels;
use microsim_tests::{command, finish, scratch, tree};
use serde_json::Value;
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

/// Synthetic trainees that play besides the script that passes: profile and seed, which are those of the first trainees of `sensitivity.md`.
const TRAINEES: [(&str, &str); 2] = [("expert", "4001"), ("novice", "4001")];

/// What the script that passes and, where they play, the synthetic trainees come to on a mesh; `None` where a run gives no cut.
pub type Played = Vec<Option<Passed>>;

/// Each level on each mesh with so many players, of which the first is the script that passes.
pub fn play(levels: &[u32], meshes: &[(&str, Mesh, usize)]) -> Result<Vec<Vec<Played>>, String> {
    let mut all = Vec::new();
    for level in levels {
        let strip = Strip::open(*level)?;
        let folder = scratch();
        let script = tree().join(format!(
            "modules/coordination/scripts/level{level}-pass.toml"
        ));
        let mut players = vec![script.clone()];
        for (profile, seed) in TRAINEES {
            let path = folder.path().join(format!("{profile}-{seed}.toml"));
            let mut made = command(["trainee".as_ref(), script.as_os_str()]);
            made.args(["--profile", profile, "--seed", seed, "--out"])
                .arg(&path);
            finish(&mut made).expect(0);
            players.push(path);
        }
        let mut of_level = Vec::new();
        for (name, mesh, count) in meshes {
            // Of other levels the marks lie elsewhere; they are not played.
            let changed =
                ChangedLevels::new("coordination", |text| changed(text, &strip.marks, *mesh));
            let played = players.iter().take(*count).enumerate();
            let played = played.map(|(player, script)| {
                let session = folder
                    .path()
                    .join(format!("{}-{player}.session", of_level.len()));
                run(&changed, *level, script, &session)
            });
            of_level.push(played.collect());
            eprintln!("level {level}: {name}: played");
        }
        all.push(of_level);
    }
    Ok(all)
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
        passed: report["verdict"] == Value::from("passed"),
    })
}
