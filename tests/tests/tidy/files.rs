//! Sizes, left-overs, and the documents that must lie beside what they describe.

use crate::modules::roots;
use crate::sources::is_test;
use crate::{assert_none, files_below, folders, sources, text};
use microsim_tests::repository;
use std::path::PathBuf;

/// Longest source file, in lines.
const LONGEST: usize = 600;

pub fn too_long(sources: &[PathBuf]) -> Vec<String> {
    let long = sources.iter().filter_map(|path| {
        let lines = text(path).lines().count();
        (lines > LONGEST).then(|| format!("{}: {lines} lines, at most {LONGEST}", path.display()))
    });
    long.collect()
}

#[test]
fn no_source_is_too_long() {
    assert_none(&too_long(&sources()));
}

pub fn silent(sources: &[PathBuf]) -> Vec<String> {
    let silent = sources
        .iter()
        .filter(|path| !is_test(path) && !text(path).starts_with("//!"));
    silent
        .map(|path| format!("{}: does not begin with //!", path.display()))
        .collect()
}

/// Every source begins with what it is for; unit tests in a file of their own are described in the file that they test.
#[test]
fn every_source_begins_with_what_it_is_for() {
    assert_none(&silent(&sources()));
}

/// The compiler refuses unsafe code in all crates but those that allow it at their root with a reason; it requires all that the table
/// of lints holds.
#[test]
fn every_package_takes_the_lints_and_forbids_unsafe_code_or_says_why() {
    let mut complaints = Vec::new();
    for (name, root) in roots() {
        let source = text(&root);
        let says_why = source.contains("#![allow(\n    unsafe_code,\n    reason = \"")
            || source.contains("#![allow(unsafe_code, reason = \"");
        if says_why == source.contains("#![forbid(unsafe_code)]") {
            complaints.push(format!(
                "{name}: neither forbids unsafe code nor allows it with a reason, or both"
            ));
        }
        let manifest = root
            .ancestors()
            .nth(2)
            .expect("a package")
            .join("Cargo.toml");
        if !text(&manifest).contains("[lints]\nworkspace = true\n") {
            complaints.push(format!("{name}: does not take the lints of the workspace"));
        }
    }
    assert_none(&complaints);
}

pub fn left_over(sources: &[PathBuf]) -> Vec<String> {
    // Put together here, so that this file itself holds none of them.
    let markers = [
        ("todo", "!"),
        ("unimplemented", "!"),
        ("dbg", "!"),
        ("FIX", "ME"),
        ("XX", "X"),
        ("TO", "DO"),
    ]
    .map(|(a, b)| format!("{a}{b}"));
    let ignored = format!("#[{}", "ignore");
    let mut complaints = Vec::new();
    for path in sources {
        for (n, line) in text(path).lines().enumerate() {
            if let Some(marker) = markers
                .iter()
                .chain([&ignored])
                .find(|marker| line.contains(*marker))
            {
                complaints.push(format!("{}:{}: {marker}", path.display(), n + 1));
            }
        }
    }
    complaints
}

#[test]
fn nothing_is_left_over() {
    assert_none(&left_over(&sources()));
}

/// Files below config/, modules/ and assets/, and what is checked, in the commands of the READMEs: `my-mesh.msh` stood there, which nobody has.
#[test]
fn the_commands_of_the_readmes_name_files_that_are_there() {
    let mut named = 0;
    let mut complaints = Vec::new();
    for readme in files_below(&repository(), "README.md") {
        let text = text(&readme);
        for command in text
            .lines()
            .filter_map(|line| line.strip_prefix("./microsim "))
        {
            let command = command.split('#').next().unwrap_or_default();
            for word in command.split_whitespace().skip(1) {
                let path = word.rsplit(':').next().unwrap_or(word);
                let ours = ["config/", "modules/", "assets/"];
                let is_ours = ours.iter().any(|folder| path.starts_with(folder));
                if is_ours || command.starts_with("check ") {
                    named += 1;
                    if !repository().join(path).exists() {
                        complaints.push(format!("{}: {path} is not there", readme.display()));
                    }
                }
            }
        }
    }
    assert!(named >= 3, "{named}");
    assert_none(&complaints);
}

/// Motion that others have recorded is shipped with who they are and what they allow.
#[test]
fn every_recording_has_its_notice_and_column_map() {
    let recordings = folders("assets/recordings");
    assert!(!recordings.is_empty());
    for recording in recordings {
        let notice = text(&recording.join("README.md"));
        for printed in ["Origin:", "licensed under", "Changes:", "Limits:"] {
            assert!(
                notice.contains(printed),
                "{}: no \"{printed}\" in its notice",
                recording.display()
            );
        }
        for motion in files_below(&recording, ".csv") {
            assert!(
                motion.with_extension("toml").is_file(),
                "{}",
                motion.display()
            );
        }
    }
}
