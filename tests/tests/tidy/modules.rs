//! The modules of each crate and who uses whom: no cycles, and the map in `crates/MODULES.md`.
//!
//! A module is a source file. A path leads to the module that defines what it names: re-exports and imports in between are
//! followed, so that a crate root, or a parent, that only re-exports is in no cycle.

use crate::rust::{code, declarations};
use crate::sources::is_test;
use crate::{assert_none, folders, text};
use microsim_tests::repository;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// What the root of a crate is called in graphs.
const ROOT: &str = "(root)";

/// Names from the root of a crate, which itself has none.
type ModulePath = Vec<String>;

/// One source file.
#[derive(Debug, Default)]
struct Module {
    /// First sentence of its documentation.
    what: String,
    /// What its names stand for: those of its `use` declarations.
    imports: BTreeMap<String, Vec<String>>,
    /// All paths in its code.
    paths: BTreeSet<Vec<String>>,
    /// The modules that define what it uses.
    uses: BTreeSet<ModulePath>,
}

/// The modules of a crate below their root file, without those of tests; and where its macros are defined.
#[derive(Debug, Default)]
struct Crate(BTreeMap<ModulePath, Module>, BTreeMap<String, ModulePath>);

impl Crate {
    fn read(root: &Path) -> Self {
        let mut modules = Self::default();
        modules.add(Vec::new(), root.to_owned());
        let resolved: Vec<(ModulePath, BTreeSet<ModulePath>)> = modules
            .0
            .iter()
            .map(|(path, module)| {
                let found = module
                    .paths
                    .iter()
                    .filter_map(|names| modules.definer(path, names, 0));
                let uses = found.filter(|other| other != path).collect();
                (path.clone(), uses)
            })
            .collect();
        for (path, uses) in resolved {
            modules.0.get_mut(&path).expect("the same modules").uses = uses;
        }
        modules
    }

    fn add(&mut self, path: ModulePath, file: PathBuf) {
        let source = text(&file);
        let what = first_sentence(&source);
        let found = declarations(&code(&source));
        let folder = match file.file_stem().and_then(|stem| stem.to_str()) {
            Some("lib" | "main" | "mod") => file.parent().expect("a folder").to_owned(),
            _ => file.with_extension(""),
        };
        for name in &found.modules {
            let files = [
                folder.join(format!("{name}.rs")),
                folder.join(name).join("mod.rs"),
            ];
            if let Some(file) = files.into_iter().find(|file| file.is_file())
                && !is_test(&file)
            {
                let child = [&path[..], std::slice::from_ref(name)].concat();
                self.add(child, file);
            }
        }
        let macros = found.macros.into_iter();
        self.1.extend(macros.map(|name| (name, path.clone())));
        let module = Module {
            what,
            imports: found.imports,
            paths: found.paths,
            uses: BTreeSet::new(),
        };
        self.0.insert(path, module);
    }

    /// The module that defines what `names` lead to from the module at `from`; none if that is of another crate.
    fn definer(&self, from: &[String], names: &[String], depth: usize) -> Option<ModulePath> {
        // Imports of imports end somewhere, if the crate compiles.
        assert!(depth < 64, "{from:?}: {names:?}");
        let mut at = from.to_vec();
        for (i, name) in names.iter().enumerate() {
            match name.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => {
                    at.pop()?;
                }
                _ => {
                    let child = [&at[..], std::slice::from_ref(name)].concat();
                    if self.0.contains_key(&child) {
                        at = child;
                        continue;
                    }
                    let import = self.0[&at].imports.get(name);
                    // An import of the module itself is followed where it is written; here only a path needs it.
                    return match import {
                        Some(import) if i > 0 => {
                            let whole = [import, &names[i + 1..]].concat();
                            self.definer(&at, &whole, depth + 1)
                        }
                        _ if at.is_empty() && self.1.contains_key(name) => {
                            Some(self.1[name].clone())
                        }
                        _ if i > 0 => Some(at),
                        _ => None,
                    };
                }
            }
        }
        Some(at)
    }

    /// Who uses whom among the children of a module, each with all that is below it; among those of the root also the root.
    fn siblings(&self, parent: &[String]) -> BTreeMap<String, BTreeSet<String>> {
        let child = |path: &ModulePath| match path.strip_prefix(parent)? {
            [] => parent.is_empty().then(|| ROOT.to_owned()),
            [name, ..] => Some(name.clone()),
        };
        let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (path, module) in &self.0 {
            let Some(own) = child(path) else { continue };
            let others = module.uses.iter().filter_map(child);
            let others = others.filter(|other| *other != own);
            graph.entry(own.clone()).or_default().extend(others);
        }
        graph
    }
}

/// The first sentence of a source's documentation, without links.
fn first_sentence(source: &str) -> String {
    let lines = source.lines().map_while(|line| line.strip_prefix("//!"));
    let lines = lines.map(str::trim).take_while(|line| !line.is_empty());
    let paragraph = lines.collect::<Vec<_>>().join(" ");
    let sentence = match paragraph.split_once(". ") {
        Some((sentence, _)) => sentence,
        None => paragraph.trim_end_matches(['.', ':']),
    };
    sentence
        .replace("[`", "`")
        .replace("`]", "`")
        .replace('|', "\\|")
}

/// What is left of a graph when all that stands in no cycle has been taken away; each with those that it uses there.
fn cycles(mut graph: BTreeMap<String, BTreeSet<String>>) -> BTreeMap<String, BTreeSet<String>> {
    loop {
        let before = graph.len();
        let used: BTreeSet<String> = graph.values().flatten().cloned().collect();
        let names: BTreeSet<String> = graph.keys().cloned().collect();
        graph.retain(|name, uses| {
            uses.retain(|other| names.contains(other));
            !uses.is_empty() && used.contains(name)
        });
        if graph.len() == before {
            return graph;
        }
    }
}

/// Root files of all packages, by the names of their folders.
pub fn roots() -> Vec<(String, PathBuf)> {
    let mut found = Vec::new();
    for group in ["crates", "plugins", "modules", "tests/fixtures"] {
        for folder in folders(group) {
            let name = folder.file_name().expect("a name").to_string_lossy();
            let files = ["src/lib.rs", "src/main.rs"].map(|file| folder.join(file));
            let roots = files.into_iter().filter(|file| file.is_file());
            found.extend(roots.map(|file| (format!("{group}/{name}"), file)));
        }
    }
    for single in ["tests/src/lib.rs", "xtask/src/main.rs"] {
        let name = single.split('/').next().expect("a folder");
        found.push((name.to_owned(), repository().join(single)));
    }
    found.sort();
    found
}

#[test]
fn no_crate_has_a_cycle_among_its_modules() {
    let mut complaints = Vec::new();
    for (name, root) in roots() {
        let modules = Crate::read(&root);
        for parent in modules.0.keys() {
            for (module, uses) in cycles(modules.siblings(parent)) {
                let module = [&parent[..], &[module]].concat().join("::");
                let uses: Vec<_> = uses.into_iter().collect();
                complaints.push(format!("{name}: {module} uses {}", uses.join(", ")));
            }
        }
    }
    assert_none(&complaints);
}

/// A module stands below those that it uses.
fn layers(mut graph: BTreeMap<String, BTreeSet<String>>) -> Vec<(String, BTreeSet<String>)> {
    let mut done = BTreeSet::new();
    let mut sorted = Vec::new();
    while !graph.is_empty() {
        let free = |uses: &BTreeSet<String>| uses.iter().all(|other| done.contains(other));
        let next: Vec<String> = graph
            .iter()
            .filter(|(_, uses)| free(uses))
            .map(|(name, _)| name.clone())
            .collect();
        // In a cycle, which another test complains about: by name.
        let next = match next.is_empty() {
            true => graph.keys().cloned().collect(),
            false => next,
        };
        for name in next {
            let uses = graph.remove(&name).unwrap_or_default();
            done.insert(name.clone());
            sorted.push((name, uses));
        }
    }
    sorted
}

/// The map of modules of the crates as a page.
fn map() -> String {
    let mut page = format!(
        "\
# The modules of the crates

Made from the sources: the first sentence of each module's documentation, and the modules of the same crate that it uses. Each stands
below those that it uses; what lies below a module is part of it. A test compares this page with the sources; to write it again:
`{RECORD}=1 {COMMAND}`.
"
    );
    for (name, root) in roots() {
        let Some(name) = name.strip_prefix("crates/") else {
            continue;
        };
        let modules = Crate::read(&root);
        let mut graph = modules.siblings(&[]);
        graph.remove(ROOT);
        graph.values_mut().for_each(|uses| {
            uses.remove(ROOT);
        });
        let _ = writeln!(page, "\n## {name}\n\n{}.", modules.0[&Vec::new()].what);
        if graph.is_empty() {
            continue;
        }
        page += "\n| module | what | uses |\n|---|---|---|\n";
        for (module, uses) in layers(graph) {
            let what = &modules.0[std::slice::from_ref(&module)].what;
            let uses = match uses.is_empty() {
                true => "–".to_owned(),
                false => uses.into_iter().collect::<Vec<_>>().join(", "),
            };
            let _ = writeln!(page, "| `{module}` | {what} | {uses} |");
        }
    }
    page
}

/// Set to write the map instead of comparing it.
const RECORD: &str = "MICROSIM_RECORD";
const COMMAND: &str = "cargo test --release -p microsim-tests --test tidy map";

#[test]
fn the_map_of_modules_is_true() {
    let path = repository().join("crates/MODULES.md");
    let map = map();
    if std::env::var_os(RECORD).is_some() {
        std::fs::write(&path, map).expect("the map can be written");
        return;
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    let mut lines = (1..).zip(
        map.lines()
            .zip(written.lines().chain(std::iter::repeat(""))),
    );
    let first = lines.find(|(_, (new, old))| new != old);
    assert!(
        map == written,
        "crates/MODULES.md is not what the sources say, first at {first:?}; write it: {RECORD}=1 {COMMAND}"
    );
}

#[test]
fn cycles_are_found_where_they_are() {
    let folder = microsim_tests::scratch();
    let write = |name: &str, source: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, source).expect("a file");
    };
    write(
        "lib.rs",
        "mod a;\nmod b;\nmod c;\n#[cfg(test)]\nmod tests;\npub use a::{A, inner::Deep};\npub use b::B as Bee;\n",
    );
    // By a re-export of the root; not by a comment, a string or a test.
    write(
        "a.rs",
        "pub mod inner;\npub struct A(crate::Bee);\n// crate::c::C\nconst S: &str = \"crate::c::C\";\n\
         #[cfg(test)]\nmod more {\n    use crate::c::C;\n}\n",
    );
    write("a/inner.rs", "use super::A;\npub struct Deep<'a>(&'a A);\n");
    write(
        "b.rs",
        "use crate::{Deep, c::{self, C}, make};\nmake!();\npub struct B(C, Deep<'static>);\n",
    );
    // A module within a file is part of it.
    write(
        "c.rs",
        "#[macro_export]\nmacro_rules! make {\n    () => {};\n}\npub struct C;\nmod sealed {\n    use super::C;\n    fn f(_: super::C) {}\n}\n",
    );
    write("tests.rs", "use crate::c::C;\n");
    let modules = Crate::read(&folder.path().join("lib.rs"));
    let graph = modules.siblings(&[]);
    let uses = |name: &str| graph[name].iter().map(String::as_str).collect::<Vec<_>>();
    assert_eq!(graph.len(), 4, "{graph:?}");
    assert_eq!(uses("a"), ["b"]);
    assert_eq!(uses("b"), ["a", "c"]);
    assert!(uses("c").is_empty());
    let found: Vec<String> = cycles(graph).into_keys().collect();
    assert_eq!(found, ["a", "b"]);

    // An item of the root's own makes the root part of a cycle.
    write("lib.rs", "mod c;\npub struct Own(c::C);\n");
    write("c.rs", "pub struct C;\nfn f(_: crate::Own) {}\n");
    let modules = Crate::read(&folder.path().join("lib.rs"));
    let found: Vec<String> = cycles(modules.siblings(&[])).into_keys().collect();
    assert_eq!(found, [ROOT, "c"]);
}
