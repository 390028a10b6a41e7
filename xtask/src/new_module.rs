//! `cargo xtask new module NAME`: a small training module that builds, is listed, runs, and passes and fails with its
//! scripts. Nothing outside its folder has to be touched: the workspace takes every folder below `modules/`.

use crate::failure::Failure;
use crate::workspace::Workspace;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::SystemTime;

/// The module that a new one begins as: path and text. `{{name}}`, `{{name_snake}}`, `{{Name}}` and `{{title}}` stand
/// for its name.
const TEMPLATE: [(&str, &str); 9] = [
    ("Cargo.toml", include_str!("../templates/module/Cargo.toml")),
    ("README.md", include_str!("../templates/module/README.md")),
    (
        "levels/level1.toml",
        include_str!("../templates/module/levels/level1.toml"),
    ),
    (
        "module.toml",
        include_str!("../templates/module/module.toml"),
    ),
    (
        "scripts/level1-fail-dwell-too-short.toml",
        include_str!("../templates/module/scripts/level1-fail-dwell-too-short.toml"),
    ),
    (
        "scripts/level1-fail-losses.toml",
        include_str!("../templates/module/scripts/level1-fail-losses.toml"),
    ),
    (
        "scripts/level1-fail-targets-missed.toml",
        include_str!("../templates/module/scripts/level1-fail-targets-missed.toml"),
    ),
    (
        "scripts/level1-pass.toml",
        include_str!("../templates/module/scripts/level1-pass.toml"),
    ),
    ("src/lib.rs", include_str!("../templates/module/src/lib.rs")),
];

/// Longest name: the library's, `microsim_module_NAME`, may have 64 characters in a manifest.
const NAME_MAX: usize = 48;

/// Makes the module's folder in `folder`, by default `modules/`.
pub fn create(workspace: &Workspace, name: &str, folder: Option<PathBuf>) -> Result<(), Failure> {
    check_form(name).map_err(Failure::Cannot)?;
    let modules = workspace.root.join("modules");
    for taken in [
        modules.join(name),
        workspace.root.join("plugins").join(name),
    ] {
        if taken.exists() {
            return Err(taken_already(name, &taken));
        }
    }
    let place = folder.unwrap_or_else(|| modules.clone()).join(name);
    if place.exists() {
        return Err(taken_already(name, &place));
    }
    let before = files(workspace, &place);
    for (file, text) in TEMPLATE {
        write(&place.join(file), &render(text, name))?;
    }
    let inside = place.parent() == Some(&modules);
    if !inside {
        make_standalone(workspace, &place)?;
    }
    format(&place.join("src/lib.rs"));
    let touched = differences(&before, &files(workspace, &place));
    println!("{}: {} files made", place.display(), TEMPLATE.len());
    println!("files touched outside this folder: {touched}");
    if inside {
        println!("(at the next build cargo enters the new package into Cargo.lock by itself)");
        println!();
        println!("cargo xtask run {name} --level 1 --input script:level1-pass.toml --headless");
    } else {
        let place = place.display();
        println!();
        println!("cd {place} && cargo build --release && cd -");
        println!(
            "cargo xtask run {name} --modules {place} --level 1 --input script:level1-pass.toml --headless"
        );
    }
    Ok(())
}

/// Makes a package outside this workspace one that can be built: what it takes from the workspace is written out.
fn make_standalone(workspace: &Workspace, place: &Path) -> Result<(), Failure> {
    let read = |path: PathBuf| {
        fs::read_to_string(&path)
            .map_err(|e| Failure::Cannot(format!("cannot read {}: {e}", path.display())))
    };
    let root = fs::canonicalize(&workspace.root).unwrap_or_else(|_| workspace.root.clone());
    let (own, shared) = (place.join("Cargo.toml"), read(root.join("Cargo.toml"))?);
    write(&own, &standalone(&read(own.clone())?, &shared, &root))?;
    // The same versions of the same crates, and the same instructions.
    for file in ["Cargo.lock", ".cargo/config.toml"] {
        write(&place.join(file), &read(root.join(file))?)?;
    }
    Ok(())
}

/// A package's manifest without its workspace: each `KEY.workspace = true` has the value that the workspace's manifest gives, paths from its root.
fn standalone(own: &str, shared: &str, root: &Path) -> String {
    let crates = format!("path = \"{}/", root.display());
    let value = |key: &str| {
        let mut lines = shared.lines().filter_map(|line| line.split_once('='));
        let (_, value) = lines.find(|(k, _)| k.trim() == key)?;
        Some(value.trim().replace("path = \"", &crates))
    };
    let mut text = String::new();
    for line in own.replace("[lints]\nworkspace = true\n\n", "").lines() {
        let key = line.strip_suffix(".workspace = true");
        match key.and_then(|key| Some((key, value(key)?))) {
            Some((key, value)) => text += &format!("{key} = {value}\n"),
            None => text += &format!("{line}\n"),
        }
    }
    text + "\n# A workspace of its own.\n[workspace]\n"
}

/// The form of names that manifests allow.
fn check_form(name: &str) -> Result<(), String> {
    let word = |word: &str| {
        !word.is_empty()
            && word
                .chars()
                .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
    };
    let letter_first = name.starts_with(|c: char| c.is_ascii_lowercase());
    if name.len() <= NAME_MAX && letter_first && name.split('-').all(word) {
        return Ok(());
    }
    Err(format!(
        "\"{name}\" cannot be a module's name; expected: lower-case letters, digits and single hyphens, a letter \
         first, at most {NAME_MAX} characters, such as touch-spheres"
    ))
}

fn taken_already(name: &str, place: &Path) -> Failure {
    Failure::Cannot(format!(
        "the name \"{name}\" is taken: {} is there already",
        place.display()
    ))
}

/// Fills a template in.
fn render(text: &str, name: &str) -> String {
    let capital = |word: &str| {
        let mut letters = word.chars();
        let first = letters.next().map(|first| first.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    };
    let camel: String = name.split('-').map(capital).collect();
    text.replace("{{name}}", name)
        .replace("{{name_snake}}", &name.replace('-', "_"))
        .replace("{{Name}}", &camel)
        .replace("{{title}}", &capital(&name.replace('-', " ")))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let folder = path.parent().unwrap_or(path);
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(path, text))
        .map_err(|e| Failure::Cannot(format!("cannot write {}: {e}", path.display())))
}

/// The length of the name decides where lines break. Without rustfmt the file is as good, and no check asks for more.
fn format(file: &Path) {
    let mut rustfmt = Command::new("rustfmt");
    rustfmt
        .args(["--edition", "2024"])
        .arg(file)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // Not there: see above.
    let _ = rustfmt.status();
}

/// Every file of the repository, with time and length, except below `without`, the target folder and git's own.
fn files(workspace: &Workspace, without: &Path) -> BTreeMap<PathBuf, (Option<SystemTime>, u64)> {
    let skipped = [
        without.to_path_buf(),
        workspace.target.clone(),
        workspace.root.join(".git"),
    ];
    let mut files = BTreeMap::new();
    let mut folders = vec![workspace.root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            match entry.metadata() {
                Ok(_) if skipped.contains(&path) => {}
                Ok(data) if data.is_dir() => folders.push(path),
                Ok(data) => {
                    files.insert(path, (data.modified().ok(), data.len()));
                }
                Err(_) => {}
            }
        }
    }
    files
}

/// How many keys are in only one of the two, or differ in their value.
fn differences<K: Ord, V: PartialEq>(before: &BTreeMap<K, V>, after: &BTreeMap<K, V>) -> usize {
    let changed = after
        .iter()
        .filter(|(key, value)| before.get(key) != Some(value))
        .count();
    changed + before.keys().filter(|key| !after.contains_key(key)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repository with a module and a plugin.
    fn workspace(folder: &Path) -> Workspace {
        for taken in ["modules/touch-spheres", "plugins/objects", "target"] {
            fs::create_dir_all(folder.join(taken)).unwrap();
        }
        Workspace {
            root: folder.to_path_buf(),
            target: folder.join("target"),
        }
    }

    #[test]
    fn names_are_lower_case_words_joined_by_hyphens() {
        for good in ["a", "demo", "touch-spheres", "level-2d", &"a".repeat(48)] {
            assert_eq!(check_form(good), Ok(()), "{good}");
        }
        let long = "a".repeat(49);
        for bad in [
            "", "-", "Demo", "demo_two", "2d", "a--b", "a-", "-a", "a b", "../a", "ä", &long,
        ] {
            assert!(check_form(bad).is_err_and(|e| e.contains(bad)), "{bad}");
        }
    }

    #[test]
    fn a_taken_name_is_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let workspace = workspace(folder.path());
        for taken in ["touch-spheres", "objects"] {
            let Err(Failure::Cannot(text)) = create(&workspace, taken, None) else {
                panic!("{taken} was made")
            };
            assert!(text.contains("taken"), "{text}");
        }
        assert!(files(&workspace, Path::new("")).is_empty());
    }

    #[test]
    fn a_new_module_lies_in_its_folder_alone_and_is_filled_in() {
        let folder = tempfile::tempdir().unwrap();
        let workspace = workspace(folder.path());
        create(&workspace, "stay-calm", None).unwrap();
        let place = folder.path().join("modules/stay-calm");
        assert!(files(&workspace, &place).is_empty());
        for (file, _) in TEMPLATE {
            let text = fs::read_to_string(place.join(file)).unwrap();
            assert!(!text.contains("{{") && !text.contains("}}"), "{file}");
        }
        let manifest = fs::read_to_string(place.join("module.toml")).unwrap();
        for line in [
            "name = \"stay-calm\"",
            "library = \"microsim_module_stay_calm\"",
            "en = \"Stay calm\"",
        ] {
            assert!(manifest.lines().any(|l| l == line), "{line}");
        }
        let logic = fs::read_to_string(place.join("src/lib.rs")).unwrap();
        assert!(logic.contains("export_plugin!(Training<StayCalm>, \"../module.toml\");"));
        // Made once only.
        assert!(create(&workspace, "stay-calm", None).is_err());
    }

    /// Made elsewhere, it could not be built: it took everything from a workspace that it was not in.
    #[test]
    fn a_module_elsewhere_takes_nothing_from_a_workspace() {
        let folder = tempfile::tempdir().unwrap();
        let workspace = workspace(folder.path());
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        for file in ["Cargo.toml", "Cargo.lock", ".cargo/config.toml"] {
            let text = fs::read_to_string(repository.join(file)).unwrap();
            write(&folder.path().join(file), &text).unwrap();
        }
        let elsewhere = tempfile::tempdir().unwrap();
        create(&workspace, "stay-calm", Some(elsewhere.path().into())).unwrap();
        let place = elsewhere.path().join("stay-calm");
        let manifest = fs::read_to_string(place.join("Cargo.toml")).unwrap();
        assert!(!manifest.contains("workspace = true"), "{manifest}");
        let root = fs::canonicalize(folder.path()).unwrap();
        let sdk = format!(
            "microsim-sdk = {{ path = \"{}/crates/sdk\" }}",
            root.display()
        );
        assert!(manifest.contains(&sdk), "{manifest}");
        assert!(manifest.contains("edition = \"2024\""), "{manifest}");
        assert!(place.join("Cargo.lock").is_file());
    }

    #[test]
    fn the_template_is_complete() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates/module");
        let mut found = Vec::new();
        let mut folders = vec![root.clone()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    found.push(path.strip_prefix(&root).unwrap().display().to_string());
                }
            }
        }
        found.sort();
        assert_eq!(found, TEMPLATE.map(|(file, _)| file));
    }

    #[test]
    fn touched_files_are_counted() {
        let before = BTreeMap::from([("same", 1), ("changed", 1), ("gone", 1)]);
        let after = BTreeMap::from([("same", 1), ("changed", 2), ("new", 1)]);
        assert_eq!(differences(&before, &after), 3);
    }
}
