//! The built tree with one more plugin: the fixture `timer-source`, whose samples come when they like.

use crate::changed_levels::link_all;
use crate::{Finished, command, finish, fixture_library, repository, scratch, tree};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// A tree of its own, gone with this value.
#[derive(Debug)]
pub struct LiveTree {
    folder: tempfile::TempDir,
}

/// Which device drives which tool.
const TRANSLATOR: &str = "translator.toml";

/// A level that a module of the tree has not.
#[derive(Clone, Copy, Debug)]
pub struct NewLevel<'a> {
    /// The module's name.
    pub module: &'a str,
    /// The level file.
    pub text: &'a str,
}

impl LiveTree {
    /// The built tree, its folders as links, and the fixture. `behaviour`: the fixture's `behaviour.json`.
    ///
    /// # Panics
    /// If the folder cannot be made.
    pub fn new(behaviour: &Value) -> Self {
        Self::with_level(behaviour, None)
    }

    /// The same with one level more, behind those that its module has.
    ///
    /// # Panics
    /// If the folder cannot be made.
    pub fn with_level(behaviour: &Value, level: Option<&NewLevel<'_>>) -> Self {
        let folder = scratch();
        let root = folder.path();
        let (tree, modules) = (tree(), root.join("modules"));
        let link = |name: &str| symlink(tree.join(name), root.join(name)).expect("a link");
        link("assets");
        link("installed.b3");
        link("microsim");
        match level {
            None => ["config", "modules"].into_iter().for_each(link),
            Some(NewLevel { module, text }) => {
                // Devices drive the tools of their own names.
                link_all(&tree.join("config"), &root.join("config"), TRANSLATOR);
                let translator = root.join("config").join(TRANSLATOR);
                fs::write(translator, "stale_after = \"100 ms\"\n").expect("the settings");
                link_all(&tree.join("modules"), &modules, module);
                let (of_tree, own) = (tree.join("modules").join(module), modules.join(module));
                link_all(&of_tree, &own, "levels");
                link_all(&of_tree.join("levels"), &own.join("levels"), "");
                let levels = fs::read_dir(own.join("levels")).expect("the levels");
                let levels = levels
                    .flatten()
                    .filter(|entry| !crate::is_variant(&entry.path()));
                let file = format!("level{}.toml", levels.count() + 1);
                fs::write(own.join("levels").join(file), text).expect("the level");
            }
        }
        link_all(&tree.join("plugins"), &root.join("plugins"), "");
        let own = root.join("plugins").join("timer-source");
        fs::create_dir(&own).expect("a folder");
        let manifest = repository().join("tests/fixtures/timer-source/plugin.toml");
        fs::copy(manifest, own.join("plugin.toml")).expect("the manifest");
        let library = fixture_library("microsim-fixture-timer-source");
        let name = library.file_name().unwrap_or_default().to_owned();
        symlink(&library, own.join(name)).expect("a link");
        let tree = Self { folder };
        tree.behave(behaviour);
        tree
    }

    /// The number of the last level of a module.
    ///
    /// # Panics
    /// If the module is not there.
    pub fn last_level(&self, module: &str) -> usize {
        let levels = self.root().join("modules").join(module).join("levels");
        let levels = fs::read_dir(levels).expect("the levels").flatten();
        levels
            .filter(|entry| !crate::is_variant(&entry.path()))
            .count()
    }

    /// Where it lies.
    pub fn root(&self) -> &Path {
        self.folder.path()
    }

    /// Changes what the fixture does from the next run on.
    ///
    /// # Panics
    /// If the file cannot be written.
    pub fn behave(&self, behaviour: &Value) {
        let file = self.root().join("plugins/timer-source/behaviour.json");
        fs::write(file, behaviour.to_string()).expect("the fixture's file");
    }

    /// `microsim run MODULE --input plugin:timer-source --json` on this tree.
    pub fn run(
        &self,
        module: &str,
        session: &Path,
        args: &[impl AsRef<std::ffi::OsStr>],
    ) -> Command {
        let mut command = command(["run", module, "--input", "plugin:timer-source", "--json"]);
        command.arg("--root").arg(self.root());
        command.arg("--session").arg(session).args(args);
        command
    }

    /// `microsim replay SESSION --verify --json` on this tree.
    pub fn verify(&self, session: &Path) -> Finished {
        let mut command = command(["replay", "--verify", "--json"]);
        finish(command.arg(session).arg("--root").arg(self.root()))
    }
}
