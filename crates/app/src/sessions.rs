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
    ["html", "json", "metrics.csv", "series.csv"].map(|extension| beside(session, extension))
}

/// What has the name of a session with another extension.
fn beside(session: &Path, extension: &str) -> PathBuf {
    let mut name = match session.extension() {
        Some(extension) if extension == "session" => session.with_extension(""),
        _ => session.to_path_buf(),
    }
    .into_os_string();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}

/// Name of the one file that is made of the pictures of a film, in their folder.
pub const VIDEO: &str = "film.mp4";

/// The folder of a film of a session, by its number.
pub fn film_beside(session: &Path, number: u32) -> PathBuf {
    beside(session, &format!("film-{number}"))
}

/// The folders of films of a session that are there.
pub fn films_beside(session: &Path) -> Vec<PathBuf> {
    let beginning = beside(session, "film-");
    let name = beginning.file_name().unwrap_or_default();
    let name = name.to_string_lossy().into_owned();
    let folder = session.parent().unwrap_or(Path::new(""));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_film = |path: &PathBuf| {
        let of = path.file_name().unwrap_or_default().to_string_lossy();
        let number = of.strip_prefix(&name);
        number.is_some_and(|number| number.parse::<u32>().is_ok()) && path.is_dir()
    };
    entries.map(|entry| entry.path()).filter(is_film).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Films of a session are its own: those of one whose name begins alike are not, nor is a file.
    #[test]
    fn films_are_found_by_the_name_of_their_session() {
        let folder = tempfile::tempdir().expect("a folder");
        let session = folder.path().join("run.session");
        let expected = [film_beside(&session, 1), film_beside(&session, 12)];
        assert_eq!(expected[0], folder.path().join("run.film-1"));
        let others = ["run-2.film-1", "run.film-x", "other.film-1"];
        let others = others.map(|name| folder.path().join(name));
        for made in expected.iter().chain(&others) {
            std::fs::create_dir(made).expect("a folder");
        }
        std::fs::write(folder.path().join("run.film-3"), "").expect("a file");
        let mut found = films_beside(&session);
        found.sort();
        assert_eq!(found, expected);
    }
}
