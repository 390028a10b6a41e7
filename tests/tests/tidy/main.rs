//! The sources themselves: what the workspace promises of its crates, and what no source may contain.
//!
//! Expected values are rules of the project: the table in `crates/README.md`, and the lists here.

mod figures;
mod files;
mod graph;
mod limits;
mod modules;
mod pictures;
mod rust;
mod sources;
mod training_modules;
mod vocabulary;

use std::fs;
use std::path::{Path, PathBuf};

/// All files below a folder of the repository whose names end so, sorted; build output and hidden folders are left out.
fn files_below(folder: &Path, suffix: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        let listing = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        for path in listing.map(|entry| entry.expect("an entry").path()) {
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            if path.is_dir() && name != "target" && !name.starts_with('.') {
                open.push(path);
            } else if path.is_file() && name.ends_with(suffix) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// All of our Rust sources.
fn sources() -> Vec<PathBuf> {
    let folders = ["crates", "plugins", "modules", "tests", "xtask"];
    folders
        .iter()
        .flat_map(|folder| files_below(&microsim_tests::repository().join(folder), ".rs"))
        .collect()
}

/// Sub-folders of a folder of the repository, sorted.
fn folders(name: &str) -> Vec<PathBuf> {
    let listing = fs::read_dir(microsim_tests::repository().join(name)).expect("a folder");
    let paths = listing.map(|entry| entry.expect("an entry").path());
    let mut folders: Vec<PathBuf> = paths.filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Fails the test with all complaints at once.
#[track_caller]
fn assert_none(complaints: &[String]) {
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
