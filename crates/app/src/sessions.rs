//! Session files in folders, and what lies beside them.

use std::path::{Path, PathBuf};

/// The session files in a folder and those below it, by path, without links in it; links to folders are not followed.
pub fn sessions_below(folder: &Path) -> Vec<PathBuf> {
    let folder = folder
        .canonicalize()
        .unwrap_or_else(|_| folder.to_path_buf());
    let mut found = Vec::new();
    let mut open = vec![folder];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let Ok(kind) = entry.file_type() else {
                continue;
            };
            let path = entry.path();
            if kind.is_dir() {
                open.push(path);
            } else if kind.is_file() && path.extension().is_some_and(|e| e == "session") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The files that a run writes beside its session: page, JSON, metrics and series as CSV. `NAME.session` gives
/// `NAME.html` and so on; a session of another name keeps its whole name, so that nothing can fall on it.
pub fn files_beside(session: &Path) -> [PathBuf; 4] {
    let stem = match session.extension() {
        Some(extension) if extension == "session" => session.with_extension(""),
        _ => session.to_path_buf(),
    };
    ["html", "json", "metrics.csv", "series.csv"].map(|extension| {
        let mut name = stem.clone().into_os_string();
        name.push(".");
        name.push(extension);
        PathBuf::from(name)
    })
}
