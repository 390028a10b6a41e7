//! The virtual environment of the other engines, and what is installed in it.

use crate::peers::{Engine, printed};
use microsim_tests::repository;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest Python that the pinned versions have wheels for.
const PYTHON: &str = "3.11";

/// The interpreter of the environment in `folder`, which is made if it is not there. The error is one sentence.
pub fn environment(folder: &Path) -> Result<PathBuf, String> {
    let environment = folder.join("venv");
    let python = environment.join("bin/python");
    if python.is_file() {
        return Ok(python);
    }
    let version = "import sys; print('%d.%d' % sys.version_info[:2], sys.version_info >= (3, 11))";
    match Command::new("python3").args(["-c", version]).output() {
        Err(e) if e.kind() == ErrorKind::NotFound => {
            return Err(format!(
                "Python is not installed: there is no `python3` in PATH, and {PYTHON} or newer is needed"
            ));
        }
        Err(e) => return Err(format!("`python3` does not start: {e}")),
        Ok(output) => {
            let told = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            if !told.ends_with("True") {
                let found = told.split(' ').next().unwrap_or_default();
                return Err(format!(
                    "`python3` is Python {found}, and {PYTHON} or newer is needed"
                ));
            }
        }
    }
    let mut venv = Command::new("python3");
    printed(venv.args(["-m", "venv"]).arg(&environment)).map_err(|why| {
        // What was begun would be taken for an environment the next time.
        let _ = fs::remove_dir_all(&environment);
        format!("Python makes no virtual environment, so its module `venv` or `ensurepip` is missing (Debian: `apt install python3-venv`): {why}")
    })?;
    Ok(python)
}

/// Installs what an engine needs, unless it is there. The error states in one sentence why it is not.
pub fn install(engine: &Engine, python: &Path, folder: &Path) -> Result<(), String> {
    let wanted = repository().join(format!("tests/peers/requirements-{}.txt", engine.name));
    let wanted_text =
        fs::read_to_string(&wanted).map_err(|e| format!("{}: {e}", wanted.display()))?;
    let stamp = folder.join(format!("venv/installed-{}.txt", engine.name));
    if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted_text) {
        return Ok(());
    }
    eprintln!("{}: installing from PyPI", engine.title);
    // Only what the requirements name: viewers and plotting are not needed.
    let options = "-m pip install --quiet --disable-pip-version-check --retries 1 --no-deps --only-binary :all: -r";
    let mut pip = Command::new(python);
    let output = pip
        .args(options.split(' '))
        .arg(&wanted)
        .output()
        .map_err(|e| format!("{}: {e}", python.display()))?;
    if !output.status.success() {
        return Err(why_not_installed(&String::from_utf8_lossy(&output.stderr)));
    }
    fs::write(&stamp, wanted_text).map_err(|e| format!("{}: {e}", stamp.display()))
}

/// One sentence of what `pip` complains about.
fn why_not_installed(complaint: &str) -> String {
    let unreachable = [
        "Failed to establish a new connection",
        "Failed to resolve",
        "Could not fetch URL",
        "Connection",
        "ProxyError",
        "timed out",
    ];
    if unreachable.iter().any(|words| complaint.contains(words)) {
        return "PyPI cannot be reached, and the first run needs a network".into();
    }
    let last = complaint
        .lines()
        .rev()
        .find(|line| !line.trim().is_empty())
        .unwrap_or("`pip` does not say why");
    format!("it cannot be installed from PyPI: {last}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `pip` 24 prints it without a network, and with one for a version that has no wheel.
    #[test]
    fn no_network_and_no_wheel_are_told_apart() {
        let offline = "WARNING: Retrying (Retry(total=0, connect=None)) after connection broken by 'NewConnectionError('\
            <pip._vendor.urllib3.connection.HTTPSConnection object>: Failed to establish a new connection: [Errno -3] Temporary \
            failure in name resolution')': /simple/drake/\nERROR: Could not find a version that satisfies the requirement \
            drake==1.51.1 (from versions: none)\nERROR: No matching distribution found for drake==1.51.1\n";
        assert_eq!(
            why_not_installed(offline),
            "PyPI cannot be reached, and the first run needs a network"
        );
        let absent = "ERROR: Could not find a version that satisfies the requirement drake==9 (from versions: 1.51.1)\n\
            ERROR: No matching distribution found for drake==9\n\n";
        assert_eq!(
            why_not_installed(absent),
            "it cannot be installed from PyPI: ERROR: No matching distribution found for drake==9"
        );
    }
}
