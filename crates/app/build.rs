//! States the commit that the program is built of. It stands in this crate alone, so that a new commit compiles nothing else again.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Environment variable with the commit, for builds that have sources without their repository, and of the program that is built.
const VARIABLE: &str = "MICROSIM_COMMIT";

/// What all programs of the repository are made of, seen from its root, and what of each crate.
const SHARED: [&str; 3] = ["Cargo.toml", "Cargo.lock", ".cargo"];
const OF_CRATE: [&str; 3] = ["Cargo.toml", "build.rs", "src"];

fn main() {
    println!("cargo:rerun-if-env-changed={VARIABLE}");
    let package = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let root = package.ancestors().nth(2).unwrap_or(&package).to_path_buf();
    let given = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty());
    let commit = given.or_else(|| commit(&root));
    println!(
        "cargo:rustc-env={VARIABLE}={}",
        commit.as_deref().unwrap_or("unknown")
    );
}

/// The commit of the repository at `root`, with `-dirty` if the sources are not as it has them; none without git or where sources lie
/// in the repository of something else.
fn commit(root: &Path) -> Option<String> {
    let top = PathBuf::from(git(root, &["rev-parse", "--show-toplevel"])?);
    if top.canonicalize().ok()? != root.canonicalize().ok()? {
        return None;
    }
    // What changes with a commit or the branch. A file that is not there would have cargo run this every time.
    let head = git(root, &["symbolic-ref", "-q", "HEAD"]);
    let names = ["HEAD", "logs/HEAD", "packed-refs"];
    for name in names.into_iter().chain(head.as_deref()) {
        let path = git(root, &["rev-parse", "--git-path", name]).map(|path| root.join(path));
        watch(path.as_deref());
    }
    let sources = sources(root);
    for source in &sources {
        watch(Some(&root.join(source)));
    }
    let hash = git(root, &["rev-parse", "--short=12", "HEAD"])?;
    let mut status = vec!["status", "--porcelain", "--"];
    status.extend(sources.iter().map(String::as_str));
    let dirty = match git(root, &status)?.is_empty() {
        true => "",
        false => "-dirty",
    };
    Some(format!("{hash}{dirty}"))
}

/// What the program is made of, as far as it is there.
fn sources(root: &Path) -> Vec<String> {
    let crates = std::fs::read_dir(root.join("crates")).into_iter().flatten();
    let names = crates.flatten().map(|entry| entry.file_name());
    let mut names: Vec<String> = names.filter_map(|name| name.into_string().ok()).collect();
    names.sort();
    let of_crates = names
        .iter()
        .flat_map(|name| OF_CRATE.map(|part| format!("crates/{name}/{part}")));
    let all = SHARED.map(str::to_owned).into_iter().chain(of_crates);
    all.filter(|source| root.join(source).exists()).collect()
}

fn watch(path: Option<&Path>) {
    if let Some(path) = path.filter(|path| path.exists()) {
        println!("cargo:rerun-if-changed={}", path.display());
    }
}

/// What git prints, without the line end; none if it fails.
fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let mut git = Command::new("git");
    // The index is not to be written by a build.
    git.env("GIT_OPTIONAL_LOCKS", "0");
    let output = git.arg("-C").arg(root).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim_end().to_owned())
}
