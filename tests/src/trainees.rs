//! Synthetic trainees: made by the program from the passing script of a level, run, and their reports.

use crate::{microsim, tree};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Writes the script of one trainee into `folder`; gives its path.
#[track_caller]
pub fn make(module: &str, level: u32, profile: &str, seed: u64, folder: &Path) -> PathBuf {
    let plan = tree().join(format!("modules/{module}/scripts/level{level}-pass.toml"));
    let out = folder.join(format!("{profile}-{seed}.toml"));
    let seed = seed.to_string();
    let args = [
        "trainee",
        text(&plan),
        "--profile",
        profile,
        "--seed",
        &seed,
        "--out",
        text(&out),
    ];
    microsim(args).expect(0);
    out
}

/// Runs a script beside which the session and its report are written; gives the session and the report.
#[track_caller]
pub fn run(module: &str, level: u32, script: &Path) -> (PathBuf, Value) {
    let session = script.with_extension("session");
    let input = format!("script:{}", script.display());
    let level = level.to_string();
    let args = [
        "run",
        module,
        "--level",
        &level,
        "--input",
        &input,
        "--session",
        text(&session),
        "--json",
    ];
    microsim(args).expect(0);
    let report = std::fs::read_to_string(script.with_extension("json"))
        .expect("a report beside the session");
    (session, serde_json::from_str(&report).expect("JSON"))
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}
