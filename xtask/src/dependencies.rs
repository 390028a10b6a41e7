//! Licences, sources and advisories of the dependencies, by cargo-deny and `deny.toml`.
//!
//! The program is installed from crates.io where it is missing: 4.5 minutes of CPU time, once per target folder.

use crate::child;
use crate::failure::Failure;
use crate::outcome::{Outcome, outcome};
use crate::workspace::Workspace;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The version that is installed; one of the same name on the PATH will do as well.
const VERSION: &str = "0.20.2";

/// Where advisories are published: a git repository, the only source of the checks that does not come from crates.io.
const ADVISORIES: &str = "https://github.com/RustSec/advisory-db";

/// Fails where a dependency has a licence or comes from a place that `deny.toml` does not list.
pub fn licences(workspace: &Workspace) -> Result<Outcome, Failure> {
    let Some(program) = installed(workspace)? else {
        eprintln!(
            "error: licences were not checked: cargo-deny {VERSION} is not there and cannot be installed; is crates.io out of reach?"
        );
        return Ok(Outcome::Failed);
    };
    outcome(deny(workspace, &program).args(["check", "licenses", "sources", "bans"]))
}

/// Warns of dependencies with an advisory against them, and where the advisories are out of reach.
pub fn advisories(workspace: &Workspace) -> Result<Outcome, Failure> {
    // Without the program the check of licences has failed.
    let Some(program) = installed(workspace)? else {
        return Ok(Outcome::Failed);
    };
    let mut fetch = deny(workspace, &program);
    fetch
        .args(["fetch", "db"])
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if !fetch.status().is_ok_and(|status| status.success()) {
        return Ok(Outcome::Warned(format!(
            "not checked: {ADVISORIES} is out of reach"
        )));
    }
    let mut check = deny(workspace, &program);
    Ok(
        match outcome(check.args(["check", "--disable-fetch", "advisories"]))? {
            Outcome::Passed => Outcome::Passed,
            _ => Outcome::Warned("there are advisories against dependencies, see above".into()),
        },
    )
}

/// The program: on the PATH or in the target folder, installed there if need be; none if that failed.
fn installed(workspace: &Workspace) -> Result<Option<PathBuf>, Failure> {
    let folder = workspace.target.join("tools");
    let own = folder
        .join("bin")
        .join(format!("cargo-deny{}", std::env::consts::EXE_SUFFIX));
    let places = [PathBuf::from("cargo-deny"), own.clone()];
    if let Some(found) = places.into_iter().find(|program| is_wanted(program)) {
        return Ok(Some(found));
    }
    let mut cargo = workspace.cargo();
    cargo.args(["install", "--locked", "cargo-deny", "--version", VERSION]);
    // It runs for seconds: its compilation is what takes time.
    cargo.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1");
    cargo.env("CARGO_PROFILE_RELEASE_LTO", "off");
    cargo.env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16");
    let installed = child::run(cargo.arg("--root").arg(&folder))?.success();
    Ok((installed && is_wanted(&own)).then_some(own))
}

fn is_wanted(program: &Path) -> bool {
    let output = Command::new(program).arg("--version").output();
    output.is_ok_and(|output| is_version(&String::from_utf8_lossy(&output.stdout)))
}

/// Whether this is the first line of the wanted version.
fn is_version(line: &str) -> bool {
    line.split_whitespace().eq(["cargo-deny", VERSION])
}

/// The program, in the repository.
fn deny(workspace: &Workspace, program: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(&workspace.root);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pinned_version_alone_will_do() {
        assert!(is_version(&format!("cargo-deny {VERSION}\n")));
        assert!(!is_version(&format!("cargo-deny {VERSION}1\n")));
        assert!(!is_version(&format!("cargo {VERSION}\n")));
        assert!(!is_version(""));
        assert!(!is_wanted(Path::new("there-is-no-such-program")));
    }
}
