//! Whole trees of plugins and modules.

use crate::example;
use microsim_settings::discover;
use std::fs;
use std::path::Path;

fn write(root: &Path, file: &str, text: &str) {
    let path = root.join(file);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
    fs::write(path, text).expect("a file can be written");
}

fn plugin(name: &str, kind: &str) -> String {
    let texts = "title = {de='a', en='b'}\nsummary = {de='a', en='b'}";
    format!(
        "name = '{name}'\nkind = '{kind}'\nversion = '0.1.0'\nabi = 2\nlicence = 'MIT'\nlibrary = 'x'\n{texts}\n"
    )
}

#[test]
fn plugins_modules_and_levels_are_found_in_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path();
    write(
        root,
        "plugins/objects/plugin.toml",
        &plugin("objects", "objects"),
    );
    write(
        root,
        "plugins/a-translator/plugin.toml",
        &plugin("translator", "translator"),
    );
    write(root, "plugins/.hidden/x", "");
    write(
        root,
        "modules/touch-spheres/module.toml",
        example("manifest"),
    );
    for level in 1..=10 {
        write(
            root,
            &format!("modules/touch-spheres/levels/level{level}.toml"),
            "",
        );
    }
    let (tree, errors) = discover(root);
    assert_eq!(errors, []);
    let names: Vec<&str> = tree
        .plugins
        .iter()
        .map(|p| p.settings.name.as_str())
        .collect();
    assert_eq!(names, ["translator", "objects"]);
    let levels = &tree.modules[0].levels;
    assert_eq!(levels.len(), 10);
    assert!(levels[1].ends_with("level2.toml") && levels[9].ends_with("level10.toml"));
}

#[test]
fn what_is_wrong_in_a_tree_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path();
    write(root, "plugins/a/plugin.toml", &plugin("objects", "objects"));
    write(
        root,
        "plugins/b/plugin.toml",
        &plugin("objects", "renderer"),
    );
    write(root, "plugins/c/readme.md", "");
    write(root, "plugins/d/plugin.toml", &plugin("d", "module"));
    write(root, "modules/m/module.toml", example("manifest"));
    write(root, "modules/m/levels/level1.toml", "");
    write(root, "modules/m/levels/level3.toml", "");
    write(root, "modules/m/levels/notes.txt", "");
    let (tree, errors) = discover(root);
    assert_eq!((tree.plugins.len(), tree.modules.len()), (3, 1));
    // Level 3 is not level 2.
    assert_eq!(
        tree.modules[0].levels,
        [root.join("modules/m/levels/level1.toml")]
    );
    let at = |path: &str| root.join(path).display().to_string();
    let printed: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let expected = [
        format!(
            "{}: found no such file, expected the manifest of a plugin (plugin.toml) or module (module.toml)",
            at("plugins/c/plugin.toml")
        ),
        format!(
            "{}:2:8: key `kind`: found `module`, expected another kind, as a module has its manifest in module.toml",
            at("plugins/d/plugin.toml")
        ),
        format!(
            "{}:1:8: key `name`: found `objects`, which {} has already, expected a name that no other plugin or module has",
            at("plugins/b/plugin.toml"),
            at("plugins/a/plugin.toml")
        ),
        format!(
            "{}:10:12: key `plugins[0]`: found `translator`, expected the name of a plugin below plugins/",
            at("modules/m/module.toml")
        ),
        format!(
            "{}: found a file that is no level, expected only level<N>.toml and level<N>.VARIANT.toml here, with N from 1, and the folder `meshes`",
            at("modules/m/levels/notes.txt")
        ),
        format!(
            "{}: found level 3, expected level2.toml before it, as levels are numbered from 1 without holes",
            at("modules/m/levels/level3.toml")
        ),
    ];
    assert_eq!(printed, expected);
}

#[test]
fn a_module_has_a_level() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path();
    write(
        root,
        "plugins/objects/plugin.toml",
        &plugin("objects", "objects"),
    );
    write(root, "modules/m/module.toml", &plugin("m", "module"));
    write(root, "modules/m/levels/.keep", "");
    let (_, errors) = discover(root);
    let levels = root.join("modules/m/levels").display().to_string();
    let printed: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(
        printed,
        [format!(
            "{levels}: found a folder without levels, expected level1.toml at least"
        )]
    );
}

#[test]
fn a_root_without_folders_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, errors) = discover(folder.path());
    let files: Vec<&str> = errors.iter().map(|error| error.file.as_str()).collect();
    let expected =
        ["plugins", "modules"].map(|name| folder.path().join(name).display().to_string());
    assert_eq!(files, expected);
}
