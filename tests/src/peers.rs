//! OpenIGTLink as others speak it: pyigtl in an environment of its own, and the examples of the C++ library of Debian, built here. Both are installed if they are not there
//! and can be; where not, the reason comes back.

use crate::repository;
use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// The version that frames were recorded with.
const PYIGTL: &str = "pyigtl==0.3.4";
/// Where Debian has the examples, and the headers.
const EXAMPLES: &str = "/usr/share/doc/openigtlink-examples/examples";
const HEADERS: &str = "/usr/include/openigtlink";
/// Examples that are built.
const PROGRAMS: [&str; 5] = [
    "Tracker/TrackerServer",
    "Tracker/TrackerClient",
    "TrackingData/TrackingDataServer",
    "QuaternionTrackingData/QuaternionTrackingDataServer",
    "Receiver/ReceiveClient",
];

/// A process that ends with this value.
#[derive(Debug)]
pub struct Peer(pub Child);

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn folder() -> PathBuf {
    repository().join("target/peers")
}

/// Runs a command; what it printed on standard error if it failed.
pub fn done(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|e| format!("{name}: {e}"))?;
    match output.status.success() {
        true => Ok(()),
        false => {
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            let last = text.lines().last().unwrap_or_default().to_owned();
            Err(format!("{name} failed: {last}"))
        }
    }
}

/// A Python that has pyigtl.
///
/// # Errors
/// Why there is none.
pub fn python() -> Result<PathBuf, String> {
    let place = folder().join("igtl");
    let python = place.join("bin/python");
    let has = |python: &Path| done(Command::new(python).args(["-c", "import pyigtl"]));
    if has(&python).is_ok() {
        return Ok(python);
    }
    done(Command::new("python3").args(["-m", "venv"]).arg(&place))?;
    let mut install = Command::new(&python);
    install.args(["-m", "pip", "install", "--quiet", "--timeout", "20", PYIGTL]);
    done(&mut install)?;
    has(&python)?;
    Ok(python)
}

/// The folder of the examples of the C++ library, built.
///
/// # Errors
/// Why they are not there.
pub fn examples() -> Result<PathBuf, String> {
    let is_there = || Path::new(EXAMPLES).is_dir() && Path::new(HEADERS).is_dir();
    if !is_there() {
        let packages = ["libopenigtlink-dev", "openigtlink-examples"];
        let mut install = Command::new("apt-get");
        install.args(["install", "-y", "-q"]).args(packages);
        install.env("DEBIAN_FRONTEND", "noninteractive");
        done(&mut install)?;
    }
    let place = folder().join("igtl-examples");
    fs::create_dir_all(&place).map_err(|e| format!("{}: {e}", place.display()))?;
    for program in PROGRAMS {
        let source = Path::new(EXAMPLES).join(program).with_extension("cxx");
        let built = place.join(source.file_stem().unwrap_or_default());
        if built.is_file() {
            continue;
        }
        let mut compile = Command::new("c++");
        compile
            .args(["-O1", "-w", "-I", HEADERS, "-o"])
            .arg(&built)
            .arg(&source);
        compile.args(["-lOpenIGTLink", "-lpthread"]);
        done(&mut compile)?;
    }
    Ok(place)
}

/// The value, or `None` with the reason on standard error: the test is skipped. With `MICROSIM_PEERS=required` in the environment, as `cargo xtask soak trackers`
/// sets it, a peer that is missing is a failure.
///
/// # Panics
/// If it is missing and required.
pub fn or_skipped<T>(what: &str, found: Result<T, String>) -> Option<T> {
    match found {
        Ok(found) => Some(found),
        Err(why) => {
            let required = std::env::var("MICROSIM_PEERS").is_ok_and(|value| value == "required");
            assert!(!required, "{what} is required and not there: {why}");
            eprintln!("SKIPPED: {what} is not there: {why}");
            None
        }
    }
}

/// A port that nobody has.
pub fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("an address").port()
}

/// A script of `tests/peers/igtl`, started.
pub fn start_script<I, S>(python: &Path, name: &str, args: I) -> Peer
where
    I: IntoIterator<Item = S>,
    S: AsRef<std::ffi::OsStr>,
{
    let script = repository().join("tests/peers/igtl").join(name);
    let mut command = Command::new(python);
    command.arg(script).args(args).stdout(Stdio::piped());
    Peer(command.spawn().expect("Python starts"))
}

/// An example of the C++ library, started; it prints a lot.
pub fn start_example(folder: &Path, name: &str, args: &[String]) -> Peer {
    let mut command = Command::new(folder.join(name));
    command
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    Peer(command.spawn().expect("the example starts"))
}
