//! What every training module holds, those of the repository and one that `cargo xtask new module` has just made: its author begins with
//! nothing to mend.

use crate::{assert_none, files, files_below, folders, graph, sources, text, vocabulary};
use microsim_tests::repository;
use std::path::Path;
use std::process::Command;

fn toml(path: &Path) -> toml::Table {
    toml::from_str(&text(path)).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Texts of a manifest or level that are not there in both languages, or in both the same.
fn not_translated(path: &Path) -> Vec<String> {
    let table = toml(path);
    let complaints = ["title", "summary"].into_iter().filter_map(|key| {
        let text = |language: &str| table.get(key)?.get(language)?.as_str();
        let (de, en) = (
            text("de").unwrap_or_default(),
            text("en").unwrap_or_default(),
        );
        let missing = de.trim().is_empty() || en.trim().is_empty();
        (missing || de == en).then(|| format!("{}: `{key}` is not translated", path.display()))
    });
    complaints.collect()
}

/// What is wrong with the scripts of a level: one has to pass, two to fail, and three to fail or to miss reference values; each names what it was made for.
fn without_scripts(module: &Path, level: u64) -> Vec<String> {
    let name = toml(&module.join("module.toml"))["name"].clone();
    let of_level = format!("level{level}-");
    let (mut passing, mut failing, mut missing) = (0, 0, 0);
    let mut complaints = Vec::new();
    for path in files_below(&module.join("scripts"), ".toml") {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let Some(kind) = file.strip_prefix(&of_level) else {
            continue;
        };
        match kind.split(['-', '.']).next() {
            Some("pass") => passing += 1,
            Some("fail") => failing += 1,
            Some("miss") => missing += 1,
            _ => complaints.push(format!("{}: neither pass, fail nor miss", path.display())),
        }
        let script = toml(&path);
        let made_for = (script.get("module"), script.get("level"));
        if made_for != (Some(&name), Some(&toml::Value::Integer(level as i64))) {
            complaints.push(format!("{}: does not name its level", path.display()));
        }
    }
    if passing < 1 || failing < 2 || failing + missing < 3 {
        let place = module.display();
        complaints.push(format!(
            "{place}: level {level} has {passing} scripts that pass, {failing} that fail and {missing} that miss reference values"
        ));
    }
    complaints
}

/// What is wrong with the files of a module.
fn complaints(module: &Path) -> Vec<String> {
    let mut complaints = not_translated(&module.join("module.toml"));
    let mut levels = files_below(&module.join("levels"), ".toml");
    levels.retain(|level| !microsim_tests::is_variant(level));
    for (number, level) in (1..).zip(&levels) {
        complaints.extend(not_translated(level));
        complaints.extend(without_scripts(module, number));
    }
    let readme = text(&module.join("README.md"));
    if levels.is_empty() || !readme.starts_with("# ") || readme.len() <= 200 {
        complaints.push(format!("{}: no level or no README", module.display()));
    }
    complaints
}

#[test]
fn every_module_has_its_readme_texts_and_scripts() {
    let modules = folders("modules");
    assert!(!modules.is_empty());
    assert_none(
        &modules
            .iter()
            .flat_map(|m| complaints(m))
            .collect::<Vec<_>>(),
    );
}

/// An untouched scaffold broke rules of the project: its title was the same in both languages, and its scripts named no level.
#[test]
fn a_new_module_keeps_every_rule() {
    let folder = microsim_tests::scratch();
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut xtask = Command::new(cargo);
    xtask
        .current_dir(repository())
        .args(["xtask", "new", "module", "demo", "--dir"])
        .arg(folder.path());
    let made = xtask.output().expect("cargo starts");
    assert!(made.status.success(), "{made:?}");

    let module = folder.path().join("demo");
    let written = files_below(&module, ".rs");
    assert_eq!(written.len(), 1, "{written:?}");
    let mut found = complaints(&module);
    for rule in [
        files::too_long,
        files::silent,
        files::left_over,
        sources::of_the_systems_library,
        sources::left_to_chance,
        sources::clocks,
        vocabulary::words_not_used,
    ] {
        found.extend(rule(&written));
    }
    found.extend(graph::modules_off_the_sdk(folder.path()));
    assert_none(&found);
    assert!(text(&written[0]).contains("#![forbid(unsafe_code)]"));

    // What its author then writes is held to rules that the SDK's page names.
    let page = text(&repository().join("crates/sdk/README.md"));
    for rule in [
        "libm",
        "atan2",
        "HashMap",
        "Instant",
        "600 lines",
        "GLOSSARY.md",
    ] {
        assert!(page.contains(rule), "the SDK's README does not name {rule}");
    }
}

/// The checks above find what they look for.
#[test]
fn the_checks_of_modules_can_fail() {
    let folder = microsim_tests::scratch();
    let module = folder.path();
    let write = |file: &str, text: &str| {
        let path = module.join(file);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder is made");
        std::fs::write(path, text).expect("a file is written");
    };
    let texts = "[title]\nde = \"Demo\"\nen = \"Demo\"\n[summary]\nde = \"a\"\nen = \"b\"\n";
    write("module.toml", &format!("name = \"demo\"\n{texts}"));
    write("levels/level1.toml", &texts.replacen("Demo", "Übung", 1));
    write("scripts/level1-pass.toml", "module = \"demo\"\nlevel = 1\n");
    write(
        "scripts/level1-fail-x.toml",
        "module = \"demo\"\nlevel = 2\n",
    );
    write("README.md", "# Demo");
    let found = complaints(module).join("\n");
    for complaint in [
        "module.toml: `title` is not translated",
        "level1-fail-x.toml: does not name its level",
        "level 1 has 1 scripts that pass, 1 that fail and 0 that miss reference values",
        "no level or no README",
    ] {
        assert!(found.contains(complaint), "no {complaint:?} in {found}");
    }
    assert_eq!(found.lines().count(), 4, "{found}");
}
