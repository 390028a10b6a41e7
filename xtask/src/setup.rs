//! `cargo xtask setup`: what the system has to bring, and getting it where that is possible.
//!
//! The program itself needs nothing but a linker to be built. Pictures need a Vulkan driver (a software one does);
//! without it everything else runs, so a missing driver is reported and is no failure.

use crate::failure::Failure;
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Debian's packages: the loader, and drivers for most graphics cards and for none.
const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

/// The Vulkan loader, by the name under which programs open it.
const LOADER: &str = "libvulkan.so.1";

/// Where the loader lies on most systems; if not, `ldconfig` is asked, which takes longer.
const LIBRARY_FOLDERS: [&str; 6] = [
    "/usr/lib/x86_64-linux-gnu",
    "/lib/x86_64-linux-gnu",
    "/usr/lib64",
    "/lib64",
    "/usr/lib",
    "/usr/local/lib",
];

/// Where drivers announce themselves.
const DRIVER_FOLDERS: [&str; 4] = [
    "/etc/vulkan/icd.d",
    "/usr/share/vulkan/icd.d",
    "/usr/local/share/vulkan/icd.d",
    "/usr/local/etc/vulkan/icd.d",
];

/// Names files that replace the drivers of the folders, the newer name first.
const DRIVER_VARIABLES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// How far the set-up goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Installs what is missing, if this user may, and prints only what is or was missing.
    Install,
    /// As `Install`, and prints what is there too.
    InstallAloud,
    /// Prints what is there and what is missing; installs nothing.
    Report,
}

/// Checks the system; fails only where nothing could be built.
pub fn setup(mode: Mode) -> Result<(), Failure> {
    check_linker(mode)?;
    let mut vulkan = find_vulkan();
    if let Err(missing) = &vulkan
        && mode != Mode::Report
        && missing.installable
        && may_install()
    {
        eprintln!(
            "setup: {}; installing {}",
            missing.what,
            PACKAGES.join(" and ")
        );
        vulkan = install().and_then(|()| find_vulkan());
    }
    match vulkan {
        Ok(driver) if mode != Mode::Install => {
            eprintln!("setup: Vulkan driver: {}", driver.display())
        }
        Ok(_) => {}
        Err(missing) => eprintln!(
            "setup: pictures are off: {}; {}. Nothing else needs it.",
            missing.what, missing.remedy
        ),
    }
    Ok(())
}

/// Whether pictures can be drawn, as far as can be seen without trying.
pub fn has_vulkan() -> bool {
    find_vulkan().is_ok()
}

fn check_linker(mode: Mode) -> Result<(), Failure> {
    match find_in(path_folders(), "cc") {
        Some(linker) => {
            if mode != Mode::Install {
                eprintln!("setup: C linker: {}", linker.display());
            }
            Ok(())
        }
        None => Err(Failure::Check(
            "no C linker `cc` on the PATH, which Rust needs to build programs; on Debian: apt-get install gcc libc6-dev"
                .into(),
        )),
    }
}

/// What pictures lack.
#[derive(Debug, PartialEq, Eq)]
struct Missing {
    what: String,
    remedy: String,
    /// Whether the packages would help.
    installable: bool,
}

impl Missing {
    fn package(what: String) -> Self {
        let remedy = format!("on Debian: apt-get install {}", PACKAGES.join(" "));
        Self {
            what,
            remedy,
            installable: true,
        }
    }
}

/// The file of a driver, if loader and driver are there.
fn find_vulkan() -> Result<PathBuf, Missing> {
    let named = DRIVER_VARIABLES
        .iter()
        .find_map(|name| Some((*name, env::var_os(name)?)));
    let folders = DRIVER_FOLDERS.map(PathBuf::from);
    let driver = find_driver(named, &folders)?;
    let listed = || {
        // Not on every user's PATH.
        let ldconfig = ["ldconfig", "/sbin/ldconfig"].iter();
        let mut outputs =
            ldconfig.filter_map(|program| Command::new(program).arg("-p").output().ok());
        outputs.any(|output| String::from_utf8_lossy(&output.stdout).contains(LOADER))
    };
    let own = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let folders = LIBRARY_FOLDERS
        .map(PathBuf::from)
        .into_iter()
        .chain(env::split_paths(&own));
    if find_in(folders, LOADER).is_some() || listed() {
        Ok(driver)
    } else {
        Err(Missing::package(format!("no Vulkan loader {LOADER}")))
    }
}

/// The first driver: of the files that a variable names, otherwise of the folders.
fn find_driver(
    named: Option<(&'static str, OsString)>,
    folders: &[PathBuf],
) -> Result<PathBuf, Missing> {
    if let Some((variable, files)) = named.filter(|(_, files)| !files.is_empty()) {
        let found = env::split_paths(&files).find(|file| file.is_file());
        return found.ok_or_else(|| Missing {
            what: format!("{variable} names no file that is there"),
            remedy: format!("unset {variable} or name a driver's JSON file"),
            installable: false,
        });
    }
    let is_json = |file: &PathBuf| file.extension().is_some_and(|e| e == "json");
    let mut drivers: Vec<PathBuf> = folders
        .iter()
        .filter_map(|folder| fs::read_dir(folder).ok())
        .flat_map(|listing| listing.filter_map(|entry| Some(entry.ok()?.path())))
        .filter(is_json)
        .collect();
    drivers.sort();
    let first = drivers.into_iter().next();
    first.ok_or_else(|| Missing::package("no Vulkan driver".into()))
}

fn path_folders() -> Vec<PathBuf> {
    env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect()
}

fn find_in(folders: impl IntoIterator<Item = PathBuf>, name: &str) -> Option<PathBuf> {
    folders
        .into_iter()
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
}

/// Root, on a system with apt.
fn may_install() -> bool {
    is_root() && find_in(path_folders(), "apt-get").is_some()
}

#[cfg(target_os = "linux")]
fn is_root() -> bool {
    use std::os::unix::fs::MetadataExt;
    // The owner of a process's folder is its effective user.
    fs::metadata(Path::new("/proc/self")).is_ok_and(|own| own.uid() == 0)
}

#[cfg(not(target_os = "linux"))]
fn is_root() -> bool {
    false
}

/// Installs the packages; with fresh package lists only if the ones that are there do not do.
fn install() -> Result<(), Missing> {
    let mut install = vec!["install", "-y", "-qq", "--no-install-recommends"];
    install.extend(PACKAGES);
    let installed = match apt(&install) {
        Err(_) => apt(&["update", "-qq"]).and_then(|()| apt(&install)),
        done => done,
    };
    installed.map_err(|printed| {
        Missing::package(format!(
            "no Vulkan driver, and apt-get could not install one ({printed})"
        ))
    })
}

/// Runs apt-get silently; the error is the last line that it printed.
fn apt(arguments: &[&str]) -> Result<(), String> {
    let output = Command::new("apt-get")
        .args(arguments)
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null())
        .output()
        .map_err(|e| e.to_string())?;
    if output.status.success() {
        return Ok(());
    }
    let printed = String::from_utf8_lossy(&output.stderr);
    let last = printed
        .lines()
        .map(str::trim)
        .rfind(|line| !line.is_empty());
    Err(last.unwrap_or("it did not say why").to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_driver_is_found_where_the_loader_looks() {
        let folder = tempfile::tempdir().unwrap();
        let (empty, full) = (folder.path().join("empty"), folder.path().join("full"));
        fs::create_dir(&empty).unwrap();
        fs::create_dir(&full).unwrap();
        for file in ["readme.txt", "b.json", "a.json"] {
            fs::write(full.join(file), "").unwrap();
        }
        let not_there = folder.path().join("not-there");
        let folders = [not_there.clone(), empty.clone(), full.clone()];
        assert_eq!(find_driver(None, &folders), Ok(full.join("a.json")));
        assert!(find_driver(None, &folders[..2]).is_err_and(|m| m.installable));

        // A variable replaces the folders, unless it is empty; no package mends a wrong one.
        let named = |files: &[&Path]| Some(("VK_DRIVER_FILES", env::join_paths(files).unwrap()));
        let b = full.join("b.json");
        assert_eq!(find_driver(named(&[&not_there, &b]), &folders), Ok(b));
        assert_eq!(find_driver(named(&[]), &folders), Ok(full.join("a.json")));
        let wrong = find_driver(named(&[&not_there]), &folders).unwrap_err();
        assert!(!wrong.installable);
        assert_eq!(wrong.what, "VK_DRIVER_FILES names no file that is there");
    }
}
