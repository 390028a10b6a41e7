//! `cargo xtask build`: builds the program, plugins and modules and lays them out as a tree that runs as it lies.
//!
//! ```text
//! target/microsim/microsim
//!                 plugins/NAME/  plugin.toml, library, files of its own
//!                 modules/NAME/  module.toml, library, levels/, scripts/, pictures/, README.md
//!                 config/  assets/
//! ```
//!
//! Files are written only where their content differs, and by renaming: a running simulator keeps the library that it
//! has mapped. What no longer belongs to these folders is removed; anything else below the tree, such as `sessions/` and
//! plugins and modules that no build has brought, is left alone. `installed.b3` lists the libraries that the build brings,
//! with their digests: what is not in it is a guest.

use crate::child;
use crate::failure::Failure;
use crate::workspace::Workspace;
use std::collections::{BTreeMap, BTreeSet};
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX, EXE_SUFFIX};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folders of the tree that hold exactly what the repository has.
const FOLDERS: [&str; 4] = ["plugins", "modules", "config", "assets"];

/// What a plugin's or module's folder holds for cargo alone.
const FOR_CARGO: [&str; 7] = [
    "Cargo.toml",
    "build.rs",
    "src",
    "tests",
    "examples",
    "benches",
    "target",
];

/// Path in the tree → file that belongs there.
type Plan = BTreeMap<PathBuf, PathBuf>;

/// Builds everything and brings the tree up to date.
pub fn build(workspace: &Workspace) -> Result<(), Failure> {
    let what = [
        "-p",
        "microsim-app",
        "-p",
        "microsim-plugin-*",
        "-p",
        "microsim-module-*",
    ];
    build_with(workspace, &what)
}

/// The same, of crates whose dependencies have the features that they have in tests, which an example among what is selected brings about: tests then build nothing again that is in the
/// tree.
pub fn build_for_tests(workspace: &Workspace) -> Result<(), Failure> {
    build_with(
        workspace,
        &["--workspace", "--lib", "--bins", "--example", "beam"],
    )
}

fn build_with(workspace: &Workspace, what: &[&str]) -> Result<(), Failure> {
    let mut cargo = workspace.cargo();
    cargo.args(["build", "--release"]).args(what);
    if !child::run(&mut cargo)?.success() {
        return Err(Failure::Cannot("the build failed".into()));
    }
    let plan = plan(&workspace.root, &workspace.release())?;
    let tree = workspace.tree();
    let (written, removed) = apply(&plan, &tree)?;
    write_hashes(&plan, &tree)?;
    let (files, tree) = (plan.len(), tree.display());
    eprintln!("{tree}: {files} files, {written} of them written now; {removed} removed");
    Ok(())
}

/// What the tree has to hold, from the repository at `root` and cargo's output in `release`.
fn plan(root: &Path, release: &Path) -> Result<Plan, Failure> {
    let mut plan = Plan::new();
    let program = format!("microsim{EXE_SUFFIX}");
    plan.insert(program.clone().into(), release.join(program));
    for (kind, manifest) in [("plugins", "plugin.toml"), ("modules", "module.toml")] {
        for name in names(&root.join(kind))? {
            let folder = root.join(kind).join(&name);
            // As cargo does with the workspace's `plugins/*` and `modules/*`.
            if !folder.join("Cargo.toml").is_file() {
                continue;
            }
            let place = Path::new(kind).join(&name);
            add_files(&mut plan, &folder, &place, &FOR_CARGO)?;
            let library = library(&folder.join(manifest), release)?;
            plan.insert(place.join(library.file_name().unwrap_or_default()), library);
        }
    }
    add_files(&mut plan, &root.join("config"), Path::new("config"), &[])?;
    // Pictures of the documentation are for readers of the repository.
    add_files(
        &mut plan,
        &root.join("assets"),
        Path::new("assets"),
        &["docs"],
    )?;
    Ok(plan)
}

/// The library that a manifest names, as cargo has built it.
fn library(manifest: &Path, release: &Path) -> Result<PathBuf, Failure> {
    let text = fs::read_to_string(manifest).map_err(|e| cannot("read", manifest, &e))?;
    let base = top_level_text(&text, "library").ok_or_else(|| {
        let manifest = manifest.display();
        Failure::Cannot(format!(
            "{manifest}: no key `library` with the library's base name"
        ))
    })?;
    let library = release.join(format!("{DLL_PREFIX}{base}{DLL_SUFFIX}"));
    if library.is_file() {
        return Ok(library);
    }
    Err(Failure::Cannot(format!(
        "{}: `library = \"{base}\"`, but cargo has built no {}; expected: the package's name with underscores, and \
         a package whose name begins with microsim-plugin- or microsim-module-",
        manifest.display(),
        library.display()
    )))
}

/// A text from the part of a TOML file before its first table. The host checks manifests; here one key is looked up.
fn top_level_text<'a>(toml: &'a str, key: &str) -> Option<&'a str> {
    let top = toml
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with('['));
    let value = top
        .filter_map(|line| line.split_once('='))
        .find(|(k, _)| k.trim() == key)?
        .1;
    value
        .trim()
        .strip_prefix('"')?
        .split_once('"')
        .map(|(text, _)| text)
}

/// Adds all files below `from`, to lie below `to`; hidden ones and the entries in `without` stay out.
fn add_files(plan: &mut Plan, from: &Path, to: &Path, without: &[&str]) -> Result<(), Failure> {
    for name in names(from)? {
        let (from, to) = (from.join(&name), to.join(&name));
        if name.starts_with('.') || without.contains(&name.as_str()) {
            continue;
        }
        if from.is_dir() {
            add_files(plan, &from, &to, &[])?;
        } else {
            plan.insert(to, from);
        }
    }
    Ok(())
}

/// Names in a folder, sorted.
fn names(folder: &Path) -> Result<Vec<String>, Failure> {
    let listing = || -> io::Result<Vec<String>> {
        let names = fs::read_dir(folder)?.map(|entry| {
            let name = entry?.file_name().into_string();
            name.map_err(|_| io::Error::other("a file's name is not UTF-8"))
        });
        names.collect()
    };
    let mut names = listing().map_err(|e| cannot("read", folder, &e))?;
    names.sort();
    Ok(names)
}

/// Makes the tree hold what the plan lists; returns how many files were written and removed.
fn apply(plan: &Plan, tree: &Path) -> Result<(usize, usize), Failure> {
    let mut removed = 0;
    let brought = brought(tree);
    for folder in FOLDERS.map(PathBuf::from) {
        if tree.join(&folder).is_dir() {
            removed += remove_stale(plan, tree, &folder, &brought)?;
        }
    }
    let mut written = 0;
    for (place, file) in plan {
        written += usize::from(update(file, &tree.join(place))?);
    }
    Ok((written, removed))
}

/// The file with the digests of the libraries that the build brings, and of the files that decide what a level is.
const HASHES: &str = "installed.b3";

/// Whether a file is a library.
fn is_library(place: &Path) -> bool {
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with(DLL_PREFIX) && name.ends_with(DLL_SUFFIX)
}

/// Whether a file decides what a level is: manifests of modules, their levels, meshes, models and textures, shapes of tools, vessels.
fn decides_level(place: &Path) -> bool {
    let parts: Vec<_> = place.iter().filter_map(|part| part.to_str()).collect();
    matches!(
        parts[..],
        ["modules", _, "module.toml"]
            | ["modules", _, "levels" | "assets", _]
            | ["modules", _, "levels", "meshes", _]
            | ["assets", _]
            | ["config", "tools" | "vessels", _]
    )
}

/// Has the program that was built write the digests beside it.
fn write_hashes(plan: &Plan, tree: &Path) -> Result<(), Failure> {
    let files = plan
        .keys()
        .filter(|place| is_library(place) || decides_level(place));
    let mut program = Command::new(tree.join(format!("microsim{EXE_SUFFIX}")));
    program.arg("--root").arg(tree).arg("digests").args(files);
    let output = program.output();
    let output = output.map_err(|e| cannot("run", &tree.join("microsim"), &e))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(Failure::Cannot(text));
    }
    let path = tree.join(HASHES);
    let temporary = tree.join(format!(".{HASHES}.{}", std::process::id()));
    fs::write(&temporary, output.stdout)
        .and_then(|()| fs::rename(&temporary, &path))
        .map_err(|e| cannot("write", &path, &e))
}

/// The folders of plugins and modules that an earlier build brought.
fn brought(tree: &Path) -> BTreeSet<PathBuf> {
    let text = fs::read_to_string(tree.join(HASHES)).unwrap_or_default();
    let libraries = text.lines().filter_map(|line| line.split_once("  "));
    let folders = libraries.filter_map(|(_, library)| Path::new(library).parent());
    folders.map(Path::to_path_buf).collect()
}

/// Whether a folder is that of a plugin or module which neither this build nor an earlier one brings: a guest.
fn is_guest(plan: &Plan, place: &Path, brought: &BTreeSet<PathBuf>) -> bool {
    let parent = place.parent().unwrap_or(place);
    let holds_plugins = parent == Path::new("plugins") || parent == Path::new("modules");
    holds_plugins && !brought.contains(place) && !plan.keys().any(|file| file.starts_with(place))
}

/// Removes files that the plan does not name, and folders that are empty then; guests stay.
fn remove_stale(
    plan: &Plan,
    tree: &Path,
    folder: &Path,
    brought: &BTreeSet<PathBuf>,
) -> Result<usize, Failure> {
    let mut removed = 0;
    for name in names(&tree.join(folder))? {
        let place = folder.join(name);
        let path = tree.join(&place);
        if path.is_dir() && is_guest(plan, &place, brought) {
            eprintln!("{}: a guest, left as it is", path.display());
        } else if path.is_dir() {
            removed += remove_stale(plan, tree, &place, brought)?;
            if names(&path)?.is_empty() {
                fs::remove_dir(&path).map_err(|e| cannot("remove", &path, &e))?;
            }
        } else if !plan.contains_key(&place) {
            fs::remove_file(&path).map_err(|e| cannot("remove", &path, &e))?;
            removed += 1;
        }
    }
    Ok(removed)
}

/// Copies a file if the target's content differs; returns whether it did. Whoever has the old one open retains it.
fn update(from: &Path, to: &Path) -> Result<bool, Failure> {
    let new = fs::read(from).map_err(|e| cannot("read", from, &e))?;
    if fs::read(to).is_ok_and(|old| old == new) {
        return Ok(false);
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(|e| cannot("make", folder, &e))?;
    }
    let name = to.file_name().unwrap_or_default().to_string_lossy();
    let temporary = to.with_file_name(format!(".{name}.{}", std::process::id()));
    // `copy` keeps the permissions: the program stays executable.
    fs::copy(from, &temporary)
        .and_then(|_| fs::rename(&temporary, to))
        .map_err(|e| cannot("write", to, &e))?;
    Ok(true)
}

fn cannot(what: &str, path: &Path, error: &io::Error) -> Failure {
    Failure::Cannot(format!("cannot {what} {}: {error}", path.display()))
}

#[cfg(test)]
mod tests;
