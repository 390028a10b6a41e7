//! The crates and who uses whom: the table in `crates/README.md`, `Cargo.toml` by `Cargo.toml`.

use crate::{assert_none, text};
use microsim_tests::repository;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Our own packages are named so.
const OWN: &str = "microsim-";

/// Dependencies of a package, without those of its tests.
fn dependencies(folder: &Path) -> BTreeSet<String> {
    let manifest: toml::Table = toml::from_str(&text(&folder.join("Cargo.toml"))).expect("TOML");
    let list = manifest.get("dependencies").and_then(toml::Value::as_table);
    list.into_iter()
        .flat_map(toml::Table::keys)
        .cloned()
        .collect()
}

fn own(dependencies: &BTreeSet<String>) -> BTreeSet<String> {
    dependencies
        .iter()
        .filter_map(|name| name.strip_prefix(OWN))
        .map(String::from)
        .collect()
}

/// Folders in a folder of the repository, by name, with their dependencies.
fn packages(folder: &str) -> BTreeMap<String, BTreeSet<String>> {
    packages_in(&repository().join(folder))
}

fn packages_in(folder: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let listing = fs::read_dir(folder).expect("a folder");
    let folders = listing.map(|entry| entry.expect("an entry").path());
    let packages = folders.filter(|path| path.join("Cargo.toml").is_file());
    packages
        .map(|path| {
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let dependencies = dependencies(&path);
            (name, dependencies)
        })
        .collect()
}

/// The rows `| crate | what | invariant | uses |` of the README.
fn table() -> Vec<[String; 4]> {
    let readme = text(&repository().join("crates/README.md"));
    // All but heading and rule.
    let rows = readme.lines().filter(|line| line.starts_with("| `"));
    let rows = rows.map(|line| {
        let cells = line
            .trim_matches('|')
            .split(" | ")
            .map(|c| c.trim().trim_matches('`'));
        let cells: Vec<String> = cells.map(String::from).collect();
        cells
            .try_into()
            .unwrap_or_else(|_| panic!("not four cells: {line}"))
    });
    rows.collect()
}

#[test]
fn the_readme_lists_every_crate_once_with_its_invariant_and_dependencies() {
    let packages = packages("crates");
    let readme = text(&repository().join("crates/README.md"));
    assert!(readme.contains("| crate | what | invariant | uses |\n|---|---|---|---|\n"));
    let mut complaints = Vec::new();
    let mut listed = BTreeSet::new();
    for [name, what, invariant, uses] in table() {
        if !listed.insert(name.clone()) {
            complaints.push(format!("{name}: listed twice"));
        }
        if what.is_empty() || invariant.is_empty() {
            complaints.push(format!(
                "{name}: says nothing of itself, or of its invariant"
            ));
        }
        let Some(dependencies) = packages.get(&name) else {
            complaints.push(format!("{name}: there is no such crate"));
            continue;
        };
        let uses = uses
            .split(',')
            .map(|n| n.trim().trim_matches('`').to_owned());
        let uses: BTreeSet<String> = uses.filter(|n| n != "–").collect();
        if uses != own(dependencies) {
            let real = own(dependencies);
            complaints.push(format!("{name}: uses {real:?}, the README says {uses:?}"));
        }
    }
    for name in packages.keys().filter(|name| !listed.contains(*name)) {
        complaints.push(format!("{name}: not in crates/README.md"));
    }
    assert_none(&complaints);
}

#[test]
fn dependencies_point_one_way() {
    let packages = packages("crates");
    // Again and again take away what depends on nothing that is left: a circle stays.
    let mut left: BTreeMap<_, _> = packages
        .iter()
        .map(|(name, d)| (name.clone(), own(d)))
        .collect();
    loop {
        let names: BTreeSet<String> = left.keys().cloned().collect();
        let before = left.len();
        left.retain(|_, uses| !uses.is_disjoint(&names));
        if left.len() == before {
            break;
        }
    }
    assert!(left.is_empty(), "in a circle, or above one: {left:?}");
}

/// All that a crate uses, directly or through others.
fn reach(packages: &BTreeMap<String, BTreeSet<String>>, name: &str) -> BTreeSet<String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![name.to_owned()];
    while let Some(name) = open.pop() {
        for uses in packages.get(&name).map(own).unwrap_or_default() {
            if reached.insert(uses.clone()) {
                open.push(uses);
            }
        }
    }
    reached
}

#[test]
fn pure_crates_know_nothing_of_the_platform() {
    let packages = packages("crates");
    let platform = ["app", "host", "sdk", "settings", "abi", "render", "gpu"];
    let pure = [
        "random",
        "geometry",
        "mesh",
        "cutting",
        "tissue",
        "contact",
        "contact-solver",
        "scene",
        "tracking",
        "igtl",
        "training",
        "session",
        "bus",
        "message",
    ];
    let mut complaints = Vec::new();
    for name in pure {
        assert!(packages.contains_key(name), "no crate {name}");
        let reach = reach(&packages, name);
        // A scene is built from settings: their types, never their files.
        let allowed = |other: &str| name == "scene" && other == "settings";
        let others = platform.iter().filter(|other| reach.contains(**other));
        for other in others.filter(|other| !allowed(other)) {
            complaints.push(format!("{name} uses {other}, directly or through others"));
        }
    }
    // Tissue and contact meet in the scene alone; the host knows neither of them, nor a GPU. The geometry of tools comes with the settings.
    for (name, never) in [
        ("tissue", &["contact"][..]),
        ("contact", &["tissue", "contact-solver"]),
        ("contact-solver", &["tissue", "contact", "mesh"]),
        (
            "host",
            &["mesh", "tissue", "contact", "scene", "gpu", "render", "sdk"],
        ),
        ("report", &["training", "host", "settings"]),
        // Pictures are made of what a tick publishes, never of what computes it.
        ("render", &["scene", "host", "tissue"]),
        ("window", &["scene", "tissue", "store", "sdk"]),
    ] {
        let reach = reach(&packages, name);
        for other in never.iter().filter(|other| reach.contains(**other)) {
            complaints.push(format!("{name} uses {other}, directly or through others"));
        }
    }
    assert_none(&complaints);
}

/// Whoever reads TOML reads configuration; whoever has wgpu draws; whoever has clap is the program.
#[test]
fn some_libraries_belong_to_some_crates() {
    let owners = [
        ("toml", &["settings"][..]),
        ("wgpu", &["gpu", "render"]),
        ("clap", &["app"]),
        ("indicatif", &["app"]),
        // What ends a run, and the names of signals that end guests.
        ("signal-hook", &["app", "host"]),
        // The threads of a session, and those of `simulate`.
        ("rayon", &["host", "app"]),
        ("abi_stable", &["abi", "host", "sdk"]),
    ];
    let mut complaints = Vec::new();
    for folder in ["crates", "plugins", "modules"] {
        for (package, dependencies) in packages(folder) {
            for (library, owners) in owners {
                let allowed = folder == "crates" && owners.contains(&package.as_str());
                if dependencies.contains(library) && !allowed {
                    complaints.push(format!(
                        "{folder}/{package} uses {library}; only {owners:?} may"
                    ));
                }
            }
        }
    }
    assert_none(&complaints);
}

/// What a training module never uses.
const NEVER_IN_MODULES: [&str; 10] = [
    "abi", "bus", "host", "app", "message", "scene", "tissue", "contact", "mesh", "settings",
];

fn off_the_sdk(folder: &Path, never: &[&str]) -> Vec<String> {
    let mut complaints = Vec::new();
    for (package, dependencies) in packages_in(folder) {
        let package = folder.join(package).display().to_string();
        let uses = own(&dependencies);
        if !uses.contains("sdk") {
            complaints.push(format!("{package} does not use the SDK"));
        }
        for other in never.iter().filter(|other| uses.contains(**other)) {
            complaints.push(format!("{package} uses {other}"));
        }
    }
    complaints
}

/// The same of the modules in a folder.
pub fn modules_off_the_sdk(folder: &Path) -> Vec<String> {
    off_the_sdk(folder, &NEVER_IN_MODULES)
}

/// A plugin sees the SDK, never what lies behind it; a module besides that only the mathematics of training.
#[test]
fn plugins_and_modules_stand_on_the_sdk() {
    let plugins = repository().join("plugins");
    let mut complaints = off_the_sdk(&plugins, &["abi", "bus", "host", "app", "message"]);
    complaints.extend(modules_off_the_sdk(&repository().join("modules")));
    assert_none(&complaints);
}
