//! `cargo xtask test`: every check, the same here and on a server.

use crate::dependencies;
use crate::failure::Failure;
use crate::outcome::{Outcome, outcome};
use crate::results;
use crate::setup::{self, Mode};
use crate::tree;
use crate::workspace::Workspace;
use std::ffi::OsString;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Runs all checks; a check that fails does not keep the next from running. `harness` goes to every test program.
pub fn check(workspace: &Workspace, short: bool, harness: &[OsString]) -> Result<(), Failure> {
    let mut phases = Phases::default();
    phases.run("set-up", || {
        setup::setup(Mode::Install).map(|()| Outcome::Passed)
    })?;
    phases.run("build", || {
        tree::build_for_tests(workspace).map(|()| Outcome::Passed)
    })?;
    phases.run("format", || format(workspace))?;
    phases.run("clippy", || clippy(workspace))?;
    phases.run("documentation", || documentation(workspace))?;
    phases.run("licences", || dependencies::licences(workspace))?;
    phases.run("advisories", || dependencies::advisories(workspace))?;
    phases.run("results", || results::check(workspace))?;
    phases.run("tests", || tests(workspace, short, harness))?;
    phases.report();
    let failed = phases.failed();
    if failed.is_empty() {
        return Ok(());
    }
    Err(Failure::Check(format!("failed: {}", failed.join(", "))))
}

fn format(workspace: &Workspace) -> Result<Outcome, Failure> {
    if !has_component(workspace, "fmt", "rustfmt") {
        return Ok(Outcome::Failed);
    }
    outcome(workspace.cargo().args(["fmt", "--all", "--", "--check"]))
}

/// The table of lints in Cargo.toml, in all targets. The optimised profile shares procedural macros and build scripts with the build.
fn clippy(workspace: &Workspace) -> Result<Outcome, Failure> {
    if !has_component(workspace, "clippy", "clippy") {
        return Ok(Outcome::Failed);
    }
    let mut cargo = workspace.cargo();
    cargo.args(["clippy", "--release", "--workspace", "--all-targets"]);
    outcome(cargo.args(["--", "-D", "warnings"]))
}

fn documentation(workspace: &Workspace) -> Result<Outcome, Failure> {
    let mut cargo = workspace.cargo();
    cargo.args(["doc", "--release", "--workspace", "--no-deps"]);
    outcome(cargo.env("RUSTDOCFLAGS", "-D warnings"))
}

/// Whether cargo has a component, asked by its subcommand; prints how to get it if not.
fn has_component(workspace: &Workspace, subcommand: &str, component: &str) -> bool {
    let mut version = workspace.cargo();
    version
        .args([subcommand, "--version"])
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let has = version.status().is_ok_and(|status| status.success());
    if !has {
        eprintln!("error: {component} is not installed; rustup component add {component}");
    }
    has
}

fn tests(workspace: &Workspace, short: bool, harness: &[OsString]) -> Result<Outcome, Failure> {
    // What earlier tests have entered into their store.
    let data = workspace.tree().with_extension("data");
    if data.exists() {
        std::fs::remove_dir_all(&data)
            .map_err(|e| Failure::Cannot(format!("{}: {e}", data.display())))?;
    }
    // Examples that are no tests are left alone: clippy has checked that they compile, and linking fifty of them takes minutes.
    let tests = run_tests(workspace, "--tests", short, harness)?;
    let documentation = run_tests(workspace, "--doc", short, harness)?;
    Ok(match (tests, documentation) {
        (Outcome::Passed, documentation) => documentation,
        (tests, _) => tests,
    })
}

/// Runs the tests of such targets.
fn run_tests(
    workspace: &Workspace,
    targets: &str,
    short: bool,
    harness: &[OsString],
) -> Result<Outcome, Failure> {
    let mut cargo = workspace.cargo_with_tree();
    // One failing crate does not hide the others' results.
    cargo.args(["test", "--release", "--workspace", "--no-fail-fast"]);
    cargo.arg(targets);
    if short {
        cargo.args(["--exclude", "microsim-tests"]);
    }
    if !harness.is_empty() {
        cargo.arg("--").args(harness);
    }
    outcome(&mut cargo)
}

/// The phases so far, with their times.
#[derive(Default)]
struct Phases(Vec<(&'static str, Duration, Outcome)>);

impl Phases {
    /// Runs a phase. Without it nothing can follow if it ends in an error: then the times so far are reported.
    fn run(
        &mut self,
        name: &'static str,
        phase: impl FnOnce() -> Result<Outcome, Failure>,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let outcome = phase();
        let taken = start.elapsed();
        match outcome {
            Ok(outcome) => {
                self.0.push((name, taken, outcome));
                Ok(())
            }
            Err(failure) => {
                self.0.push((name, taken, Outcome::Failed));
                self.report();
                Err(failure)
            }
        }
    }

    fn failed(&self) -> Vec<&'static str> {
        let failed = self
            .0
            .iter()
            .filter(|(_, _, outcome)| matches!(outcome, Outcome::Failed));
        failed.map(|(name, _, _)| *name).collect()
    }

    fn report(&self) {
        eprintln!();
        for (name, taken, outcome) in &self.0 {
            let outcome = match outcome {
                Outcome::Passed => "passed".to_owned(),
                Outcome::Failed => "FAILED".to_owned(),
                Outcome::Warned(what) => format!("passed, but {what}"),
            };
            eprintln!("{name:<13} {:>8.1} s  {outcome}", taken.as_secs_f64());
        }
        let all: Duration = self.0.iter().map(|(_, taken, _)| *taken).sum();
        eprintln!("{:<13} {:>8.1} s", "all", all.as_secs_f64());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_phase_is_named_and_an_error_ends_the_checks() {
        let mut phases = Phases::default();
        assert_eq!(phases.run("format", || Ok(Outcome::Failed)), Ok(()));
        assert_eq!(phases.run("tests", || Ok(Outcome::Passed)), Ok(()));
        assert_eq!(
            phases.run("advisories", || Ok(Outcome::Warned("why".into()))),
            Ok(())
        );
        assert_eq!(phases.failed(), ["format"]);
        let broken = || Failure::Cannot("the build failed".into());
        assert_eq!(phases.run("build", || Err(broken())), Err(broken()));
        assert_eq!(phases.failed(), ["format", "build"]);
    }
}
