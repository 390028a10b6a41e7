//! The built tree with one more plugin: the fixture `timer-source`, whose samples come when they like.

use crate::{Said, command, fixture_library, hear, repository, scratch, tree};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A tree of its own, gone with this value.
#[derive(Debug)]
pub struct LiveTree {
    folder: tempfile::TempDir,
}

impl LiveTree {
    /// The built tree, its folders as links, and the fixture. `behaviour`: what the fixture's `behaviour.json` says.
    ///
    /// # Panics
    /// If the folder cannot be made.
    pub fn new(behaviour: &Value) -> Self {
        let folder = scratch();
        let root = folder.path();
        let link = |from: &Path, to: PathBuf| symlink(from, to).expect("a link");
        for name in ["modules", "config", "assets"] {
            link(&tree().join(name), root.join(name));
        }
        fs::create_dir(root.join("plugins")).expect("a folder");
        for plugin in fs::read_dir(tree().join("plugins")).expect("the tree's plugins") {
            let plugin = plugin.expect("a plugin");
            link(
                &plugin.path(),
                root.join("plugins").join(plugin.file_name()),
            );
        }
        let own = root.join("plugins").join("timer-source");
        fs::create_dir(&own).expect("a folder");
        let manifest = repository().join("tests/fixtures/timer-source/plugin.toml");
        fs::copy(manifest, own.join("plugin.toml")).expect("the manifest");
        let library = fixture_library("microsim-fixture-timer-source");
        let name = library.file_name().unwrap_or_default().to_owned();
        link(&library, own.join(name));
        let tree = Self { folder };
        tree.behave(behaviour);
        tree
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
    pub fn run(&self, module: &str, session: &Path, args: &[&str]) -> Command {
        let mut command = command(["run", module, "--input", "plugin:timer-source", "--json"]);
        command.arg("--root").arg(self.root());
        command.arg("--session").arg(session).args(args);
        command
    }

    /// `microsim replay SESSION --verify --json` on this tree.
    pub fn verify(&self, session: &Path) -> Said {
        let mut command = command(["replay", "--verify", "--json"]);
        hear(command.arg(session).arg("--root").arg(self.root()))
    }
}
