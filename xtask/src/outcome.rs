//! What a check came to.

use crate::child;
use crate::failure::Failure;
use std::process::Command;

/// What one phase came to.
#[derive(Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing to complain about.
    Passed,
    /// Something to know, in a sentence, that fails nothing.
    Warned(String),
    /// It has printed why.
    Failed,
}

/// Runs a check that prints its own complaints.
pub fn outcome(command: &mut Command) -> Result<Outcome, Failure> {
    let passed = child::run(command)?.success();
    Ok(if passed {
        Outcome::Passed
    } else {
        Outcome::Failed
    })
}
