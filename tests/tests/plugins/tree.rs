//! An installation of its own for a test, so that it can be spoilt.

use microsim_tests::Finished;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A copy of the built tree without recordings; gone after the test.
pub struct Tree {
    folder: tempfile::TempDir,
}

impl Tree {
    /// A copy of the built tree.
    pub fn new() -> Self {
        let tree = Self {
            folder: microsim_tests::scratch(),
        };
        for part in ["plugins", "modules", "config"] {
            copy(&microsim_tests::tree().join(part), &tree.path(part));
        }
        let hashes = "installed.b3";
        fs::copy(microsim_tests::tree().join(hashes), tree.path(hashes)).expect("it is copied");
        tree
    }

    /// A path below the installation.
    pub fn path(&self, below: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(below)
    }

    /// Writes a file, with the folders above it.
    pub fn write(&self, below: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(below);
        fs::create_dir_all(path.parent().expect("a folder above")).expect("the folder is made");
        fs::write(&path, content).expect("the file is written");
        path
    }

    /// Replaces a text in a file by another one.
    #[track_caller]
    pub fn edit(&self, below: &str, from: &str, to: &str) -> PathBuf {
        let text = fs::read_to_string(self.path(below)).expect("the file is read");
        assert!(text.contains(from), "{below} has no {from:?}");
        self.write(below, text.replacen(from, to, 1))
    }

    /// The program on this installation, with the session file `run.session` where one is written.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(microsim_tests::program());
        command
            .arg("--root")
            .arg(self.folder.path())
            .args(args)
            .current_dir(self.folder.path());
        microsim_tests::apart(&mut command);
        command
    }

    /// Runs the program on this installation.
    pub fn microsim(&self, args: &[&str]) -> Finished {
        self.command(args)
            .output()
            .expect("the program starts")
            .into()
    }
}

/// Copies a folder. Libraries are linked where that works: nothing writes into them.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("the folder is made");
    for entry in fs::read_dir(from).expect("the built tree is read") {
        let from = entry.expect("an entry").path();
        let to = to.join(from.file_name().expect("a name"));
        if from.is_dir() {
            copy(&from, &to);
        } else if from.extension().is_some_and(|e| e == "toml")
            || fs::hard_link(&from, &to).is_err()
        {
            fs::copy(&from, &to).expect("the file is copied");
        }
    }
}
