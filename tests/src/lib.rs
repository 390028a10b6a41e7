//! The harness of the integration tests: they run the built program on the built tree, as a user would.
//!
//! The tree is what `cargo xtask build` makes; `cargo xtask test` builds it first and says where it lies.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Root of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the repository").to_path_buf()
}

/// The built tree.
///
/// # Panics
/// If it is not there: these tests prove nothing without it.
pub fn tree() -> PathBuf {
    let tree = match std::env::var_os("MICROSIM_TREE") {
        Some(tree) => PathBuf::from(tree),
        None => repository().join("target").join("microsim"),
    };
    assert!(tree.join("plugins").is_dir(), "no built tree in {}: run `cargo xtask test`, or `cargo xtask build` first", tree.display());
    tree
}

/// The built program.
pub fn program() -> PathBuf {
    tree().join(format!("microsim{}", std::env::consts::EXE_SUFFIX))
}

/// What the program said.
#[derive(Clone, Debug)]
pub struct Said {
    /// Exit status; `None` if a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

impl Said {
    /// The one JSON document on standard output.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e} in: {self:?}"))
    }

    /// Fails the test unless the exit status is `code`.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:?}");
        self
    }
}

/// Runs the program in the repository's root.
pub fn microsim<I, S>(args: I) -> Said
where
    I: IntoIterator<Item = S>,
    S: AsRef<std::ffi::OsStr>,
{
    let output = Command::new(program()).args(args).current_dir(repository()).output();
    output.expect("the built program starts").into()
}

/// A folder that is gone after the test.
pub fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}
