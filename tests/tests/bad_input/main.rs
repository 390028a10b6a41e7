//! Bad input through the command line: each is one clear sentence with its place, and nothing is lost.
//!
//! - `settings`: unknown keys, wrong units and missing files, in every kind of TOML file;
//! - `recordings`: CSV files without a column map, and with rows that cannot be;
//! - `models`: models and textures of objects;
//! - `sessions`: session files that are cut, damaged, or none;
//! - `command_line`: what is asked for is not there; what standard output gets.

mod command_line;
mod models;
mod recordings;
mod sessions;
mod settings;
#[path = "../plugins/tree.rs"]
mod tree;

use microsim_tests::Finished;
use tree::Tree;

/// A tool that sinks by 2 mm in 48 ms: six ticks of 8 ms, and one in which the module handles the end of the input.
const SHORT: &str = r#"
rate = "62.5 Hz"

[[tool]]
name = "right"

[[tool.key]]
t = 0
position = [0, 0, "12 mm"]
direction = [0, 0, 1]

[[tool.key]]
t = "48 ms"
position = [0, 0, "10 mm"]
direction = [0, 0, 1]
"#;

/// An installation with the short script.
fn tree() -> Tree {
    let tree = Tree::new();
    tree.write("short.toml", SHORT);
    tree
}

/// Runs touch-spheres on the installation; the session is `x.session` in it.
fn run(tree: &Tree, input: &str, more: &[&str]) -> Finished {
    let args = [
        "run",
        "touch-spheres",
        "--input",
        input,
        "--session",
        "x.session",
    ];
    tree.microsim(&[&args, more].concat())
}

/// The run did not begin: exit status 2, nothing on standard output, one complaint, no session.
#[track_caller]
fn assert_refused(tree: &Tree, input: &str, complaint: &str) {
    let printed = run(tree, input, &[]);
    assert_eq!(
        (printed.code, printed.out.as_str()),
        (Some(2), ""),
        "{printed:?}"
    );
    let text = printed
        .err
        .strip_prefix("microsim: ")
        .unwrap_or_else(|| panic!("{printed:?}"));
    assert!(
        text.contains(complaint),
        "expected {complaint:?} in {printed:?}"
    );
    assert!(!tree.path("x.session").exists(), "{printed:?}");
}
