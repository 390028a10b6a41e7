//! Finds the plugins, modules and levels below a root folder, in an order that does not depend on the file system.

use crate::document::Loaded;
use crate::error::{ConfigError, KeyPath};
use crate::manifest::Manifest;
use crate::manifest_check::load_manifest;
use crate::regular_file::in_words;
use microsim_vocabulary::PluginKind;
use std::fs;
use std::path::{Path, PathBuf};

/// What lies below a root folder.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// From `plugins/*/plugin.toml`, by folder.
    pub plugins: Vec<Loaded<Manifest>>,
    /// From `modules/*/module.toml`, by folder.
    pub modules: Vec<ModuleFolder>,
}

/// A training module with its levels.
#[derive(Clone, Debug)]
pub struct ModuleFolder {
    /// What the module declares of itself.
    pub manifest: Loaded<Manifest>,
    /// `levels/level1.toml`, `levels/level2.toml` …: level N is element N − 1.
    pub levels: Vec<PathBuf>,
    /// Variants of these, by level and name.
    pub variants: Vec<Variant>,
}

impl ModuleFolder {
    /// The folder of the levels, from which they name their meshes; variants that lie elsewhere, too.
    pub fn level_folder(&self) -> PathBuf {
        let manifest = self.manifest.document.path();
        manifest.with_file_name("levels")
    }
}

/// A variant of a level: the same task with other methods, in a file of its own, `levels/level<N>.NAME.toml`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Variant {
    /// Number of the level.
    pub level: u32,
    /// Its name.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
}

/// Finds plugins and modules below `root`; what is wrong with one of them is a complaint and hides only that one.
pub fn discover(root: &Path) -> (Tree, Vec<ConfigError>) {
    discover_with(root, &[], &[])
}

/// Finds plugins and modules below `root` and in other folders, each with a folder per plugin or module, or that of one.
pub fn discover_with(
    root: &Path,
    more_plugins: &[PathBuf],
    more_modules: &[PathBuf],
) -> (Tree, Vec<ConfigError>) {
    let mut errors = Vec::new();
    let mut plugins = manifests(&root.join("plugins"), "plugin.toml", &mut errors);
    let mut modules = manifests(&root.join("modules"), "module.toml", &mut errors);
    for (found, places, file) in [
        (&mut plugins, more_plugins, "plugin.toml"),
        (&mut modules, more_modules, "module.toml"),
    ] {
        for place in places {
            found.extend(manifests(place, file, &mut errors));
        }
    }
    for loaded in plugins.iter().chain(&modules) {
        check_kind(loaded, &mut errors);
    }
    check_names(&plugins, &modules, &mut errors);
    check_used_plugins(&plugins, &modules, &mut errors);
    let modules = modules
        .into_iter()
        .map(|manifest| {
            let mut module = ModuleFolder {
                manifest,
                levels: Vec::new(),
                variants: Vec::new(),
            };
            let folder = module.level_folder();
            (module.levels, module.variants) = levels(&folder, &mut errors);
            module
        })
        .collect();
    (Tree { plugins, modules }, errors)
}

/// The manifests `name` in the folders of `folder`.
fn manifests(folder: &Path, name: &str, errors: &mut Vec<ConfigError>) -> Vec<Loaded<Manifest>> {
    let mut found = Vec::new();
    // The folder of one alone.
    let one = folder.join(name);
    let folders = match one.is_file() {
        true => vec![folder.to_path_buf()],
        false => entries(folder, errors),
    };
    for path in folders.iter().filter(|path| path.is_dir()) {
        match load_manifest(&path.join(name)) {
            Ok(manifest) => found.push(manifest),
            Err(complaints) => errors.extend(complaints.0),
        }
    }
    found
}

/// What lies in a folder, sorted by name, without hidden entries.
fn entries(folder: &Path, errors: &mut Vec<ConfigError>) -> Vec<PathBuf> {
    let listing = match fs::read_dir(folder) {
        Ok(listing) => listing,
        Err(error) => {
            let found = match error.kind() {
                std::io::ErrorKind::NotFound => "no such folder".to_owned(),
                _ => format!("a folder that cannot be read ({})", in_words(error)),
            };
            errors.push(whole_file(folder, &found, "a folder"));
            return Vec::new();
        }
    };
    let mut paths: Vec<PathBuf> = listing
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| !file_name(path).starts_with('.'))
        .collect();
    paths.sort();
    paths
}

/// `plugin.toml` is for plugins, `module.toml` for modules.
fn check_kind(loaded: &Loaded<Manifest>, errors: &mut Vec<ConfigError>) {
    let file = file_name(&loaded.document.path());
    let is_module = loaded.settings.kind == PluginKind::Module;
    if is_module != (file == "module.toml") {
        let key = KeyPath::root().key("kind");
        let (found, expected) = if is_module {
            (
                "`module`",
                "another kind, as a module has its manifest in module.toml",
            )
        } else {
            (
                "the kind of a plugin",
                "`module`, as a plugin has its manifest in plugin.toml",
            )
        };
        errors.push(loaded.document.error_at(&key, found, expected));
    }
}

/// A name means one plugin or module.
fn check_names(
    plugins: &[Loaded<Manifest>],
    modules: &[Loaded<Manifest>],
    errors: &mut Vec<ConfigError>,
) {
    let all: Vec<&Loaded<Manifest>> = plugins.iter().chain(modules).collect();
    for (i, loaded) in all.iter().enumerate() {
        let name = &loaded.settings.name;
        if let Some(first) = all[..i]
            .iter()
            .find(|earlier| earlier.settings.name == *name)
        {
            let found = format!(
                "`{name}`, which {} has already",
                first.document.path().display()
            );
            let expected = "a name that no other plugin or module has";
            errors.push(
                loaded
                    .document
                    .error_at(&KeyPath::root().key("name"), &found, expected),
            );
        }
    }
}

/// The plugins that a module uses are there.
fn check_used_plugins(
    plugins: &[Loaded<Manifest>],
    modules: &[Loaded<Manifest>],
    errors: &mut Vec<ConfigError>,
) {
    let known: Vec<&str> = plugins
        .iter()
        .map(|plugin| plugin.settings.name.as_str())
        .collect();
    for module in modules {
        for (i, name) in module.settings.plugins.iter().enumerate() {
            if !known.contains(&name.as_str()) {
                let hint = crate::read::did_you_mean(name, known.iter().copied());
                let key = KeyPath::root().key("plugins").at(i);
                let expected = format!("the name of a plugin below plugins/{hint}");
                errors.push(
                    module
                        .document
                        .error_at(&key, &format!("`{name}`"), &expected),
                );
            }
        }
    }
}

/// The folder, beside levels, of their meshes.
const MESHES: &str = "meshes";

/// The levels in a folder by their number, which runs from 1 without holes, and their variants. Meshes that they name lie in a folder beside them.
fn levels(folder: &Path, errors: &mut Vec<ConfigError>) -> (Vec<PathBuf>, Vec<Variant>) {
    let mut numbered: Vec<(u32, PathBuf)> = Vec::new();
    let mut variants: Vec<Variant> = Vec::new();
    for path in entries(folder, errors) {
        match level_number(&file_name(&path)) {
            Some(number) => numbered.push((number, path)),
            None if variant(&path).is_some() => variants.extend(variant(&path)),
            None if path.is_dir() && file_name(&path) == MESHES => {}
            None => errors.push(whole_file(
                &path,
                "a file that is no level",
                "only level<N>.toml and level<N>.VARIANT.toml here, with N from 1, and the folder `meshes`",
            )),
        }
    }
    if numbered.is_empty() && folder.is_dir() {
        errors.push(whole_file(
            folder,
            "a folder without levels",
            "level1.toml at least",
        ));
    }
    // By number, not by name: level10 comes after level9.
    numbered.sort();
    let in_place = |(i, (number, _)): (usize, &(u32, PathBuf))| *number as usize == i + 1;
    let whole = numbered
        .iter()
        .enumerate()
        .take_while(|l| in_place(*l))
        .count();
    if let Some((number, path)) = numbered.get(whole) {
        let missing = format!(
            "level{}.toml before it, as levels are numbered from 1 without holes",
            whole + 1
        );
        errors.push(whole_file(path, &format!("level {number}"), &missing));
    }
    // What stands behind a hole would take the place of another level.
    numbered.truncate(whole);
    variants.retain(|variant| {
        let is_there = variant.level as usize <= whole;
        if !is_there {
            let found = format!("a variant of level {}", variant.level);
            errors.push(whole_file(
                &variant.path,
                &found,
                "one of a level that is there",
            ));
        }
        is_there
    });
    variants.sort();
    let levels = numbered.into_iter().map(|(_, path)| path).collect();
    (levels, variants)
}

/// Variants of the first `levels` levels in a folder that has nothing else, and what is wrong there; none where there is no folder.
pub fn variants_in(folder: &Path, levels: usize) -> (Vec<Variant>, Vec<ConfigError>) {
    let (mut found, mut errors) = (Vec::new(), Vec::new());
    if !folder.exists() {
        return (found, errors);
    }
    // What editors and file managers leave beside a file is none of it.
    let is_toml = |path: &PathBuf| {
        let name = file_name(path);
        name.ends_with(".toml") && !name.starts_with('.')
    };
    for path in entries(folder, &mut errors).into_iter().filter(is_toml) {
        match variant(&path).filter(|of| of.level as usize <= levels) {
            Some(variant) => found.push(variant),
            None => errors.push(whole_file(
                &path,
                "a file that is no variant of a level",
                &format!("only level<N>.NAME.toml here, with N from 1 to {levels}"),
            )),
        }
    }
    found.sort();
    (found, errors)
}

/// The variant that a file `level<N>.NAME.toml` is; names are identifiers.
fn variant(path: &Path) -> Option<Variant> {
    let file = file_name(path);
    let (level, name) = file.strip_suffix(".toml")?.split_once('.')?;
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let is_identifier =
        name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(is_name);
    Some(Variant {
        level: level_number(&format!("{level}.toml"))?,
        name: name.to_owned(),
        path: path.to_path_buf(),
    })
    .filter(|_| is_identifier)
}

/// N of `level<N>.toml`, written without leading zeros, from 1.
fn level_number(file_name: &str) -> Option<u32> {
    let digits = file_name.strip_prefix("level")?.strip_suffix(".toml")?;
    let number: u32 = digits.parse().ok()?;
    (number >= 1 && number.to_string() == digits).then_some(number)
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

fn whole_file(path: &Path, found: &str, expected: &str) -> ConfigError {
    ConfigError {
        file: path.display().to_string(),
        position: None,
        key: KeyPath::root(),
        found: found.to_owned(),
        expected: expected.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_named_by_its_number() {
        let cases = [
            ("level1.toml", Some(1)),
            ("level12.toml", Some(12)),
            ("level0.toml", None),
            ("level01.toml", None),
            ("level.toml", None),
            ("level+1.toml", None),
            ("level1.toml~", None),
            ("level99999999999.toml", None),
        ];
        for (name, number) in cases {
            assert_eq!(level_number(name), number, "{name}");
        }
    }

    #[test]
    fn a_variant_is_named_by_its_level_and_its_name() {
        let cases = [
            ("level2.dissertation.toml", Some((2, "dissertation"))),
            ("level12.as-in-2015.toml", Some((12, "as-in-2015"))),
            ("level2.toml", None),
            ("level2..toml", None),
            ("level2.Old.toml", None),
            ("level2.a.b.toml", None),
            ("level0.dissertation.toml", None),
        ];
        for (name, expected) in cases {
            let found = variant(Path::new(name));
            let found = found.as_ref().map(|of| (of.level, of.name.as_str()));
            assert_eq!(found, expected, "{name}");
        }
    }
}
