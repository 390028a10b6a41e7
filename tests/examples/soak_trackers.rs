//! `cargo xtask soak trackers`: the tests against pyigtl and the C++ library of OpenIGTLink, which fail here where these are missing instead of being skipped.

use microsim_tests::peers::{examples, python};
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    let python = python().map(drop).map_err(|why| format!("pyigtl: {why}"));
    let library = examples()
        .map(drop)
        .map_err(|why| format!("the C++ library: {why}"));
    for found in [python, library] {
        if let Err(why) = found {
            eprintln!("{why}");
            return ExitCode::from(1);
        }
    }
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args([
        "test",
        "--release",
        "--workspace",
        "--test",
        "instruments",
        "--",
        "--nocapture",
    ]);
    cargo.env("MICROSIM_PEERS", "required");
    match cargo.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        _ => ExitCode::from(1),
    }
}
