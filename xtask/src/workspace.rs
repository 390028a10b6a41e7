//! Where everything lies: the repository, cargo's target folder and the tree that is assembled there.

use crate::failure::Failure;
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Environment variable that names the assembled tree to the integration tests.
pub const TREE_VARIABLE: &str = "MICROSIM_TREE";

/// Environment variable that names the simulator a folder for what belongs to its user.
const DATA_VARIABLE: &str = "MICROSIM_DATA";

/// The folders of this workspace.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The repository.
    pub root: PathBuf,
    /// Cargo's target folder.
    pub target: PathBuf,
}

impl Workspace {
    /// Of the running program. Cargo put it into `<target>/release`, so CARGO_TARGET_DIR and every other means to name
    /// the target folder is honoured.
    pub fn here() -> Result<Self, Failure> {
        let program = env::current_exe()
            .map_err(|e| Failure::Cannot(format!("this program's own place is unknown: {e}")))?;
        let target = program.ancestors().nth(2).unwrap_or(Path::new("target"));
        // What cargo says now is right even where clones share a target folder and so this program.
        let from_cargo =
            env::var("CARGO_PKG_NAME").is_ok_and(|name| name == env!("CARGO_PKG_NAME"));
        let package = env::var_os("CARGO_MANIFEST_DIR").filter(|_| from_cargo);
        let root = match package {
            Some(package) => {
                let package = PathBuf::from(package);
                package.parent().unwrap_or(&package).to_path_buf()
            }
            // Run by itself it works where it lies, or where it is run, and never where it once was built.
            None => {
                let folder = env::current_dir().unwrap_or_default();
                repository_among(target.parent().into_iter().chain(folder.ancestors())).ok_or_else(
                    || {
                        Failure::Cannot(format!(
                            "neither {} nor the present folder belongs to the repository: run `cargo xtask` in it",
                            target.display()
                        ))
                    },
                )?
            }
        };
        Ok(Self {
            root,
            target: target.to_path_buf(),
        })
    }

    /// Where cargo puts what it builds.
    pub fn release(&self) -> PathBuf {
        self.target.join("release")
    }

    /// The tree that runs as it lies.
    pub fn tree(&self) -> PathBuf {
        self.target.join("microsim")
    }

    /// The simulator in the tree.
    pub fn program(&self) -> PathBuf {
        self.tree()
            .join(format!("microsim{}", env::consts::EXE_SUFFIX))
    }

    /// The simulator in the tree, with a folder of its own below cargo's instead of those of the user, unless another is named.
    pub fn simulator(&self) -> Command {
        let mut simulator = Command::new(self.program());
        if env::var_os(DATA_VARIABLE).is_none_or(|folder| folder.is_empty()) {
            simulator.env(DATA_VARIABLE, self.data());
        }
        simulator
    }

    /// Where the simulator puts sessions, logs and its key when `cargo xtask` runs it.
    pub fn data(&self) -> PathBuf {
        self.target.join("microsim.data")
    }

    /// Cargo, in the repository, building into the same target folder as this program.
    pub fn cargo(&self) -> Command {
        let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo
            .current_dir(&self.root)
            .env("CARGO_TARGET_DIR", &self.target);
        cargo
    }

    /// Cargo for programs that work on the assembled tree.
    pub fn cargo_with_tree(&self) -> Command {
        self.with_tree(self.cargo())
    }

    /// A program that works on the assembled tree.
    pub fn with_tree(&self, mut program: Command) -> Command {
        program.env(TREE_VARIABLE, self.tree());
        // Otherwise a layer of the graphics driver prints a line about the missing folder at every start.
        if env::var_os("XDG_RUNTIME_DIR").is_none() {
            program.env("NODEVICE_SELECT", "1");
        }
        program
    }
}

/// The first of these folders that is the root of the repository.
fn repository_among<'a>(folders: impl IntoIterator<Item = &'a Path>) -> Option<PathBuf> {
    let mut folders = folders.into_iter();
    let found = folders.find(|root| root.join("xtask").join("Cargo.toml").is_file());
    found.map(Path::to_path_buf)
}

#[cfg(test)]
mod tests {
    use super::repository_among;
    use std::path::Path;

    /// A program that was moved finds the repository around it, not the one that it was built in.
    #[test]
    fn a_moved_program_works_where_it_lies() {
        let moved = tempfile::tempdir().expect("a folder");
        let target = moved.path().join("target");
        std::fs::create_dir_all(moved.path().join("xtask")).expect("a folder");
        assert_eq!(repository_among([moved.path(), target.as_path()]), None);
        std::fs::write(moved.path().join("xtask/Cargo.toml"), "").expect("a file");
        let found = repository_among([target.as_path(), moved.path()]);
        assert_eq!(found.as_deref(), Some(moved.path()));
        assert_eq!(repository_among([Path::new("/")]), None);
    }
}
