//! The harness of the integration tests: they run the built program on the built tree, as a user would.
//!
//! The tree is what `cargo xtask build` makes; `cargo xtask test` builds it first and passes its place on.
//!
//! - here: running the program and reading its output;
//! - [`alter`]: sessions written again with one value changed;
//! - [`comb`]: a band that is cut a hundred times;
//! - [`counts`]: instruction counts of kernels, recorded and compared;
//! - [`desktop`]: a display without a screen, and mouse and keyboard at it;
//! - [`detected`]: contact for a solver without a scene;
//! - [`digests`]: physics digests of shipped runs, recorded and compared;
//! - [`driver`]: a graphics driver that loses its device when it is asked to;
//! - [`hands`]: random players, and what comes of their runs;
//! - [`in_process`]: a run in the test's own process;
//! - [`kill`]: runs killed by SIGKILL, and what is left of them;
//! - [`live`]: a tree with a source that has a timer of its own;
//! - [`long`]: runs of any length, and what they cost;
//! - [`matrix`]: scripts played without what makes tissue answer;
//! - [`measured`]: CPU time and memory of the program;
//! - [`peers`]: OpenIGTLink of others: pyigtl and the C++ library;
//! - [`simulated`]: scenes run by the program, and what they give;
//! - [`statistics`]: percentiles of measurements;
//! - [`stations`]: folders of users, with trainees and a store of their own;
//! - [`system`]: the linear system of a body, phase by phase;
//! - [`training`]: training after training in one process;
//! - [`trainees`]: synthetic trainees, made and run;
//! - [`vessel`]: tubes of layers under pressure, solved in one dimension.

#![forbid(unsafe_code)]

pub mod alter;
pub mod changed_levels;
pub mod comb;
pub mod counts;
pub mod desktop;
pub mod detected;
pub mod digests;
pub mod driver;
pub mod hands;
pub mod in_process;
pub mod kill;
pub mod live;
pub mod long;
pub mod matrix;
pub mod measured;
pub mod peers;
pub mod sensitivity;
pub mod simulated;
pub mod stations;
pub mod statistics;
pub mod system;
pub mod trainees;
pub mod training;
pub mod vessel;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Motion of a real hand: 98 s of a haptic stylus.
pub const RECORDING: &str = "recording:assets/recordings/cataract-stylus/stylus.csv";

/// Root of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("tests/ lies in the repository")
        .to_path_buf()
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
    assert!(
        tree.join("plugins").is_dir(),
        "no built tree in {}: run `cargo xtask test`, or `cargo xtask build` first",
        tree.display()
    );
    tree
}

/// The built program.
pub fn program() -> PathBuf {
    tree().join(format!("microsim{}", std::env::consts::EXE_SUFFIX))
}

/// The library of a package of `tests/fixtures`, which cargo has built as a dependency of this one.
///
/// # Panics
/// If it is not there.
pub fn fixture_library(package: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a running test has a file");
    let name = format!(
        "{}{}{}",
        std::env::consts::DLL_PREFIX,
        package.replace('-', "_"),
        std::env::consts::DLL_SUFFIX
    );
    // Tests lie in `deps/` themselves, examples beside it.
    let folders = test
        .ancestors()
        .skip(1)
        .take(2)
        .flat_map(|f| [f.join(&name), f.join("deps").join(&name)]);
    let found = folders.into_iter().find(|path| path.is_file());
    found.unwrap_or_else(|| {
        panic!(
            "cargo has built no {name} for {}: is it a dev-dependency?",
            test.display()
        )
    })
}

/// The output of the program.
#[derive(Clone, Debug)]
pub struct Finished {
    /// Exit status; `None` if a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl From<Output> for Finished {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

impl Finished {
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

/// The program, to be run in the repository's root.
pub fn command<I, S>(args: I) -> Command
where
    I: IntoIterator<Item = S>,
    S: AsRef<std::ffi::OsStr>,
{
    let mut command = Command::new(program());
    command.args(args).current_dir(repository());
    apart(&mut command);
    command
}

/// Has a command leave the folders of whoever runs the tests as they are: it has settings, logs, sessions and a key of the tests.
pub fn apart(command: &mut Command) {
    command.env("MICROSIM_DATA", data());
    command.env("MICROSIM_STATION_KEY", station_key());
}

/// The folder that the tests have instead of those of a user: beside the built tree.
pub fn data() -> PathBuf {
    tree().with_extension("tests")
}

/// The key that sessions of the tests are signed with: beside the built tree, not in the data folder of whoever runs them.
pub fn station_key() -> PathBuf {
    tree().with_extension("station.key")
}

/// Runs a command to its end.
pub fn finish(command: &mut Command) -> Finished {
    command.output().expect("the built program starts").into()
}

/// Runs the program in the repository's root.
pub fn microsim<I, S>(args: I) -> Finished
where
    I: IntoIterator<Item = S>,
    S: AsRef<std::ffi::OsStr>,
{
    finish(&mut command(args))
}

/// `microsim run MODULE ARGS… --session SESSION --json`; its standard output.
#[track_caller]
pub fn run(module: &str, session: &Path, args: &[&str]) -> serde_json::Value {
    let mut command = command(["run", module, "--json", "--session"]);
    finish(command.arg(session).args(args)).expect(0).json()
}

/// `microsim replay SESSION --verify --json ARGS…`.
pub fn verify(session: &Path, args: &[&str]) -> Finished {
    let mut command = command(["replay", "--verify", "--json"]);
    finish(command.arg(session).args(args))
}

/// Fails the test unless a fresh process recomputes the session to the bit, to its very end.
#[track_caller]
pub fn assert_verified(session: &Path) {
    let printed = verify(session, &[]).expect(0).json();
    assert_eq!(printed["verified"], true, "{printed}");
    assert_eq!(printed["complaint"], serde_json::Value::Null, "{printed}");
    assert_eq!(printed["state_hash"], printed["recorded_hash"], "{printed}");
}

/// A copy of the settings of the built tree below `folder`, with another text of one file.
///
/// # Panics
/// If it cannot be made.
pub fn config_with(folder: &Path, file: &str, text: &str) -> PathBuf {
    let config = folder.join("config");
    changed_levels::link_all(&tree().join("config"), &config, file);
    std::fs::write(config.join(file), text).expect("the settings");
    config
}

/// The report that `run` has left beside its session.
pub fn report_beside(session: &Path) -> serde_json::Value {
    let path = session.with_extension("json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Whether a file among the levels of a module is a variant of one: `level<N>.NAME.toml`.
pub fn is_variant(level: &Path) -> bool {
    let stem = level.file_stem().unwrap_or_default();
    stem.to_string_lossy().contains('.')
}

/// A folder that is gone after the test.
pub fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}
