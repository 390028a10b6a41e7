//! `cargo xtask run`: the simulator, or without arguments a headless demonstration: the recorded hand works on the first
//! level of touch-spheres, then a fresh process recomputes the session and compares.

use crate::child;
use crate::failure::Failure;
use crate::setup;
use crate::workspace::Workspace;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// Motion of a real hand, below the repository and below the tree alike.
const RECORDING: &str = "recording:assets/recordings/cataract-stylus/stylus.csv";

/// `microsim run` with the operator's arguments, in the operator's folder.
pub fn run_simulator(workspace: &Workspace, arguments: &[OsString]) -> Failure {
    child::become_program(workspace.simulator().arg("run").args(arguments))
}

/// The demonstration.
pub fn demonstrate(workspace: &Workspace) -> Result<(), Failure> {
    let places = Places::new(&workspace.data().join("sessions"));
    places.prepare()?;
    let mut run = workspace.simulator();
    run.current_dir(&workspace.root);
    run.args([
        "run",
        "touch-spheres",
        "--level",
        "1",
        "--input",
        RECORDING,
        "--headless",
    ]);
    let pictures = setup::has_vulkan();
    if pictures {
        run.arg("--frames").arg(&places.frames);
    }
    child::must(run.arg("--session").arg(&places.session))?;

    let mut replay = workspace.simulator();
    replay.current_dir(&workspace.root).arg("replay");
    child::must(replay.arg(&places.session).arg("--verify"))?;

    println!();
    for (what, path) in places.results() {
        println!("{what:<9} {}", path.display());
    }
    if !pictures {
        println!("pictures  none: there is no Vulkan driver");
    }
    Ok(())
}

/// Where the demonstration leaves what it makes: beside its session the simulator writes page, scores and tables.
struct Places {
    folder: PathBuf,
    session: PathBuf,
    frames: PathBuf,
}

impl Places {
    fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_path_buf(),
            session: folder.join("demo.session"),
            frames: folder.join("demo-frames"),
        }
    }

    /// Makes the folder, which a new tree does not have, and removes what an earlier demonstration left: the simulator never
    /// writes over a session.
    fn prepare(&self) -> Result<(), Failure> {
        fs::create_dir_all(&self.folder)
            .map_err(|e| Failure::Cannot(format!("cannot make {}: {e}", self.folder.display())))?;
        let listing = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        for path in listing.map(|entry| entry.path()) {
            let removed = if path == self.frames {
                fs::remove_dir_all(&path)
            } else if path.file_prefix() == self.session.file_prefix() {
                fs::remove_file(&path)
            } else {
                continue;
            };
            removed
                .map_err(|e| Failure::Cannot(format!("cannot remove {}: {e}", path.display())))?;
        }
        Ok(())
    }

    /// What is there now, the most telling first.
    fn results(&self) -> Vec<(&'static str, PathBuf)> {
        let mut results = vec![
            ("score", self.session.with_extension("json")),
            ("report", self.session.with_extension("html")),
            ("pictures", self.frames.clone()),
            ("session", self.session.clone()),
        ];
        results.retain(|(_, path)| path.exists());
        results
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_demonstration_is_cleared_and_nothing_else() {
        let tree = tempfile::tempdir().unwrap();
        let folder = tree.path().join("sessions");
        let places = Places::new(&folder);
        assert_eq!(places.prepare(), Ok(()));
        assert!(folder.is_dir());
        for file in [
            "demo.session",
            "demo.html",
            "demo.json",
            "demo.metrics.csv",
            "mine.session",
            "demo-2.json",
        ] {
            fs::write(folder.join(file), "").unwrap();
        }
        fs::create_dir(&places.frames).unwrap();
        fs::write(places.frames.join("000000.png"), "").unwrap();
        let found: Vec<_> = places.results().iter().map(|(what, _)| *what).collect();
        assert_eq!(found, ["score", "report", "pictures", "session"]);

        assert_eq!(places.prepare(), Ok(()));
        assert!(places.results().is_empty());
        let mut left: Vec<_> = fs::read_dir(&folder)
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        left.sort();
        assert_eq!(left, ["demo-2.json", "mine.session"]);
    }
}
