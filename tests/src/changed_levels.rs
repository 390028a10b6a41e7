//! The built tree with the levels of a module changed.

use crate::{command, finish, scratch, tree};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// A tree of its own, gone with this value. All but the levels are links.
#[derive(Debug)]
pub struct ChangedLevels {
    folder: tempfile::TempDir,
    module: String,
}

/// A link in a new folder for each entry of another, but for one.
pub(crate) fn link_all(from: &Path, to: &Path, but: &str) {
    fs::create_dir(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder of the tree") {
        let entry = entry.expect("an entry");
        if entry.file_name() != but {
            symlink(entry.path(), to.join(entry.file_name())).expect("a link");
        }
    }
}

impl ChangedLevels {
    /// With the text of each level of `module` passed through `change`.
    ///
    /// # Panics
    /// If the folder cannot be made.
    pub fn new(module: &str, change: impl Fn(&str) -> String) -> Self {
        let folder = scratch();
        let (tree, root) = (tree(), folder.path());
        for name in ["assets", "config", "plugins", "installed.b3"] {
            symlink(tree.join(name), root.join(name)).expect("a link");
        }
        link_all(&tree.join("modules"), &root.join("modules"), module);
        let (of_tree, own) = (
            tree.join("modules").join(module),
            root.join("modules").join(module),
        );
        link_all(&of_tree, &own, "levels");
        fs::create_dir(own.join("levels")).expect("a folder");
        for entry in fs::read_dir(of_tree.join("levels")).expect("the levels") {
            let path = entry.expect("an entry").path();
            let text = fs::read_to_string(&path).expect("a level");
            let file = own.join("levels").join(path.file_name().expect("a name"));
            fs::write(file, change(&text)).expect("a level");
        }
        Self {
            folder,
            module: module.to_owned(),
        }
    }

    /// `microsim run MODULE --json ARGS…` on this tree; its standard output.
    #[track_caller]
    pub fn run(&self, session: &Path, args: &[&str]) -> Value {
        let mut command = self.command(&["run", &self.module, "--json", "--session"]);
        finish(command.arg(session).args(args)).expect(0).json()
    }

    /// The program on this tree.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = command(["--root".as_ref(), self.folder.path().as_os_str()]);
        command.args(args);
        command
    }
}

/// A level whose solver gets nowhere: one iteration for a tick of 48 ms, near the longest that a level may have, and no second try. Levels whose method has no
/// iterations stay as they are.
pub fn crippled(level: &str) -> String {
    if !level.contains("\niterations = ") {
        return level.to_owned();
    }
    let line = |line: &str| match line.split(" = ").next() {
        Some("tick") => "tick = \"48 ms\"\n".to_owned(),
        Some("iterations") => "iterations = 1\nrepeat_invalid = false\n".to_owned(),
        _ => format!("{line}\n"),
    };
    level.lines().map(line).collect()
}
