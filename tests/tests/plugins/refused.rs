//! Libraries and manifests that are refused before anything of them runs.

use crate::awkward::{Installed, MODULE, Role, SOURCE, TRANSLATOR};
use crate::tree::Tree;
use microsim_tests::finish;

/// A library in the place of the translator.
#[track_caller]
fn assert_library_refused(package: &str, reason: &str) {
    let installed = Installed::library(TRANSLATOR, package);
    let run = installed.run("", &[]);
    let library = format!("lib{}.so", package.replace('-', "_"));
    let path = installed.tree.path("plugins/translator").join(library);
    run.assert_refused(&format!(
        "plugin \"translator\" ({}): {reason}",
        path.display()
    ));
    // A person has to read it, and a changed layout alone prints tens of kilobytes.
    assert!(run.output.err.len() < 1000, "{}", run.output.err);
    // `check` finds the same and goes on with the rest.
    let check = finish(&mut installed.command("", &["check", "--json"]))
        .expect(1)
        .json();
    let problems = check["problems"].as_array().expect("a list");
    let about = problems
        .iter()
        .filter(|p| p.as_str().is_some_and(|p| p.contains(reason)))
        .count();
    assert!(about >= 1, "{check}");
    assert_eq!(about, problems.len(), "nothing else is wrong: {check}");
}

#[test]
fn library_of_another_abi_version() {
    let reason =
        "built for version 999 of the plugin contract, this host has version 2; build it again";
    assert_library_refused("microsim-fixture-other-abi", reason);
}

/// The fixture's `Call` has a tick of 32 bits: see its build script.
#[test]
fn library_with_a_changed_layout() {
    let reason = "its memory layout is not that of this host's plugin contract; build it again \
                  (`tick` of `Call<'a>`: mismatched type Expected: u64 Found: u32)";
    assert_library_refused("microsim-fixture-changed-layout", reason);
}

#[test]
fn library_without_the_symbol() {
    let reason = "exports no plugin (the version `MICROSIM_ABI_VERSION` is missing): does it call `export_plugin!`?";
    assert_library_refused("microsim-fixture-not-a-plugin", reason);
}

/// Its version is right, and there is nothing behind it.
#[test]
fn library_without_the_header() {
    let reason = "exports no plugin (the root symbol `_1as_0lib_1header_0root_bmodule_bloader` is missing): does it call `export_plugin!`?";
    assert_library_refused("microsim-fixture-no-header", reason);
}

#[test]
fn library_that_is_none() {
    let installed = Installed::awkward(TRANSLATOR);
    let library = installed.tree.write(
        "plugins/translator/libmicrosim_fixture_awkward.so",
        "This is not a library, but more than the header of one is long, so that its beginning is looked at.\n",
    );
    let path = library.display();
    let sentence = format!("plugin \"translator\" ({path}): cannot be opened as a library: ");
    installed.run("", &[]).assert_refused(&sentence);
}

#[test]
fn missing_library() {
    let installed = Installed::awkward(TRANSLATOR);
    let library = installed
        .tree
        .path("plugins/translator/libmicrosim_fixture_awkward.so");
    std::fs::remove_file(&library).expect("removed");
    let sentence = format!(
        "plugin \"translator\": its library {} cannot be read: ",
        library.display()
    );
    installed.run("", &[]).assert_refused(&sentence);
}

#[test]
fn manifest_of_another_abi_version() {
    let installed = Installed::awkward(TRANSLATOR);
    let manifest = installed
        .tree
        .edit("plugins/translator/plugin.toml", "abi = 2\n", "abi = 3\n");
    let sentence = format!(
        "plugin \"translator\" ({}): its manifest has version 3 of the plugin contract, this host has version 2",
        manifest.display()
    );
    installed.run("", &[]).assert_refused(&sentence);
}

/// The real translator with a manifest that was edited after the build.
#[test]
fn manifest_that_is_not_the_one_of_the_build() {
    let tree = Tree::new();
    tree.write("script.toml", crate::awkward::SCRIPT);
    tree.edit(
        "plugins/translator/plugin.toml",
        r#"["input.sample"]"#,
        r#"["input.sample", "input.end"]"#,
    );
    let printed = tree.microsim(&[
        "run",
        "touch-spheres",
        "--input",
        "script:script.toml",
        "--session",
        "x.session",
    ]);
    let library = tree.path("plugins/translator/libmicrosim_plugin_translator.so");
    let sentence = format!(
        "microsim: plugin \"translator\" ({}): the manifest beside the library is not the one it was built with; build it \
         again\n",
        library.display()
    );
    assert_eq!((printed.code, printed.err), (Some(2), sentence));
    assert!(!tree.path("x.session").exists());
}

#[test]
fn two_plugins_of_one_name() {
    let tree = Tree::new();
    tree.write("script.toml", crate::awkward::SCRIPT);
    let manifest =
        std::fs::read_to_string(tree.path("plugins/translator/plugin.toml")).expect("read");
    let second = tree.write("plugins/zweiter/plugin.toml", manifest);
    let library = "libmicrosim_plugin_translator.so";
    let at = |folder: &str| tree.path(format!("plugins/{folder}/{library}"));
    std::fs::copy(at("translator"), at("zweiter")).expect("copied");
    let printed = tree.microsim(&[
        "run",
        "touch-spheres",
        "--input",
        "script:script.toml",
        "--session",
        "x.session",
    ]);
    let sentence = format!(
        "{}:1:8: key `name`: found `translator`, which {} has already, expected a name that no other plugin or module has",
        second.display(),
        tree.path("plugins/translator/plugin.toml").display()
    );
    assert_eq!(
        (printed.code, printed.err),
        (Some(2), format!("microsim: {sentence}\n"))
    );
    assert!(!tree.path("x.session").exists());
    // Every level needs a translator, and still it is said once.
    let check = tree.microsim(&["check", "--json"]).expect(1).json();
    assert_eq!(check["problems"], serde_json::json!([sentence]));
    // Who only looks is told, and sees the rest.
    let list = tree.microsim(&["list"]).expect(0);
    assert!(
        list.err.contains(&sentence) && list.out.contains("touch-spheres"),
        "{list:?}"
    );
}

/// Neither the module nor what uses the plugin is run.
#[test]
fn module_and_plugin_of_one_name() {
    for run in [["objects", "--input", "script:script.toml"], TRANSLATOR.run] {
        let installed = Installed::awkward(Role {
            name: "objects",
            run,
            ..MODULE
        });
        let sentence = format!(
            "modules/objects/module.toml:1:8: key `name`: found `objects`, which {} has already, expected a name that no \
             other plugin or module has",
            installed.tree.path("plugins/objects/plugin.toml").display()
        );
        installed.run("", &[]).assert_refused(&sentence);
    }
}

#[test]
fn topics_that_nobody_brings() {
    let publishes = Role {
        publishes: r#""input.end", "nobody.knows""#,
        ..SOURCE
    };
    let hears = Role {
        subscribes: r#""nobody.knows""#,
        ..SOURCE
    };
    for role in [publishes, hears] {
        let sentence = "plugin \"awkward\" failed in `register` at tick 0: \"awkward\" names the message kind \
                        \"nobody.knows\", which no loaded plugin brings";
        Installed::awkward(role)
            .run("", &[])
            .assert_refused(sentence);
    }
}

#[test]
fn a_plugin_that_is_no_source_as_input() {
    let tree = Tree::new();
    let printed = tree.microsim(&[
        "run",
        "touch-spheres",
        "--input",
        "plugin:physics",
        "--session",
        "x.session",
    ]);
    let sentence = format!(
        "microsim: plugin \"physics\" ({}): it is of kind `physics`, an input has to be a `source`\n",
        tree.path("plugins/physics/plugin.toml").display()
    );
    assert_eq!((printed.code, printed.err), (Some(2), sentence));
}
