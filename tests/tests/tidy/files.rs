//! Sizes, left-overs, and the documents that must lie beside what they describe.

use crate::sources::is_test;
use crate::{assert_none, files_below, text};
use microsim_tests::repository;
use std::fs;
use std::path::PathBuf;

/// Longest source file, in lines.
const LONGEST: usize = 800;

fn sources() -> Vec<PathBuf> {
    let folders = ["crates", "plugins", "modules", "tests", "xtask"];
    folders
        .iter()
        .flat_map(|folder| files_below(&repository().join(folder), ".rs"))
        .collect()
}

#[test]
fn no_source_is_too_long() {
    let long = sources().into_iter().filter_map(|path| {
        let lines = text(&path).lines().count();
        (lines > LONGEST).then(|| format!("{}: {lines} lines, at most {LONGEST}", path.display()))
    });
    assert_none(&long.collect::<Vec<_>>());
}

/// Every source says first what it is for; unit tests in a file of their own are said in the file that they test.
#[test]
fn every_source_begins_with_what_it_is_for() {
    let silent = sources()
        .into_iter()
        .filter(|path| !is_test(path) && !text(path).starts_with("//!"));
    let silent = silent.map(|path| format!("{}: does not begin with //!", path.display()));
    assert_none(&silent.collect::<Vec<_>>());
}

#[test]
fn nothing_is_left_over() {
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
    for path in sources() {
        for (n, line) in text(&path).lines().enumerate() {
            if let Some(marker) = markers
                .iter()
                .chain([&ignored])
                .find(|marker| line.contains(*marker))
            {
                complaints.push(format!("{}:{}: {marker}", path.display(), n + 1));
            }
        }
    }
    assert_none(&complaints);
}

/// Sub-folders of a folder of the repository.
fn folders(name: &str) -> Vec<PathBuf> {
    let listing = fs::read_dir(repository().join(name)).expect("a folder");
    let paths = listing.map(|entry| entry.expect("an entry").path());
    paths.filter(|path| path.is_dir()).collect()
}

#[test]
fn every_module_has_its_readme() {
    let modules = folders("modules");
    assert!(!modules.is_empty());
    for module in modules {
        let readme = text(&module.join("README.md"));
        assert!(
            readme.starts_with("# ") && readme.len() > 200,
            "{}",
            module.display()
        );
    }
}

/// Motion that others have recorded is shipped with who they are and what they allow.
#[test]
fn every_recording_has_its_notice_and_column_map() {
    let recordings = folders("assets/recordings");
    assert!(!recordings.is_empty());
    for recording in recordings {
        let notice = text(&recording.join("README.md"));
        for said in ["Origin:", "licensed under", "Changes:", "Limits:"] {
            assert!(
                notice.contains(said),
                "{}: no \"{said}\" in its notice",
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
