//! Opens a plugin's library in this process, from an explicit path, after checking all that can be checked before its code runs.

use abi_stable::library::{AbiHeaderRef, LibraryError};
use libloading::Library;
use microsim_abi::{
    ABI_VERSION, FaultKind, PluginBox, PluginModule_Ref, ROOT_SYMBOL, VERSION_SYMBOL,
};
use std::fmt;
use std::path::{Path, PathBuf};

/// Why a library was not loaded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// Name of the plugin.
    pub plugin: String,
    /// The library.
    pub path: PathBuf,
    /// The reason, one sentence.
    pub reason: String,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "plugin \"{}\" ({}): {}",
            self.plugin,
            self.path.display(),
            self.reason
        )
    }
}

impl std::error::Error for LoadError {}

/// Digest of a file, hexadecimal.
pub fn file_hash(path: &Path) -> std::io::Result<String> {
    Ok(blake3::hash(&std::fs::read(path)?).to_hex().to_string())
}

/// Opens the library and constructs the plugin. Checked before, in this order: the version of the contract, a plain word; the
/// memory layout; the manifest.
///
/// A library that is refused for its version, or because it exports no plugin, is closed again: none of its code has run. From the
/// check of its layout on it stays open until the process ends: function tables, thread-local values and texts of a static lifetime
/// that come from it may be in use for as long.
///
/// The error is the reason of a [`LoadError`].
pub(crate) fn open(path: &Path, manifest: &str) -> Result<PluginBox, String> {
    if !path.is_file() {
        return Err(
            "the library is not there; build it, or correct `library` in its manifest".into(),
        );
    }
    let library = map(path).map_err(|e| format!("cannot be opened as a library: {e}"))?;
    let header = header(&library)?;
    std::mem::forget(library);
    let header = header.upgrade().map_err(|e| short(&e))?;
    let module = header
        .init_root_module::<PluginModule_Ref>()
        .map_err(|e| short(&e))?;
    if module.manifest()().as_str() != manifest {
        return Err(
            "the manifest beside the library is not the one it was built with; build it again"
                .into(),
        );
    }
    module.create()().into_result().map_err(|fault| {
        let how = if fault.kind == FaultKind::Panic {
            "panicked"
        } else {
            "failed"
        };
        format!("{how} in `create`: {}", fault.text)
    })
}

/// Opens a library at an explicit path. All of its symbols are looked up now, so that one that is missing is found here and not in the
/// middle of a run; its own symbols serve no other library, so that two plugins never get each other's.
#[cfg(unix)]
fn map(path: &Path) -> Result<Library, libloading::Error> {
    use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
    // SAFETY: a plugin library has no initialisers but those of Rust's runtime, which need nothing. That a file of another kind
    // lies here cannot be known before it is opened; the operator has put it there.
    unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
}

/// Opens a library at an explicit path.
#[cfg(not(unix))]
fn map(path: &Path) -> Result<Library, libloading::Error> {
    // SAFETY: a plugin library has no initialisers but those of Rust's runtime, which need nothing. That a file of another kind
    // lies here cannot be known before it is opened; the operator has put it there.
    unsafe { Library::new(path) }
}

/// The header of a library that was built for this version of the contract; otherwise why there is none.
fn header(library: &Library) -> Result<AbiHeaderRef, String> {
    let missing = |what: &str, symbol: &str| {
        format!(
            "exports no plugin (the {what} `{symbol}` is missing): does it call `export_plugin!`?"
        )
    };
    // SAFETY: the symbol of this name is a `u32` by the contract, whatever its version.
    let version = unsafe { library.get::<*const u32>(VERSION_SYMBOL.as_bytes()) };
    let version = version.map_err(|_| missing("version", VERSION_SYMBOL))?;
    // SAFETY: as above; the library is open.
    let version = unsafe { **version };
    if version != ABI_VERSION {
        return Err(format!(
            "built for version {version} of the plugin contract, this host has version {ABI_VERSION}; build it again"
        ));
    }
    // SAFETY: the symbol of this name is the header that abi_stable defines, in this version of the contract.
    let header = unsafe { library.get::<AbiHeaderRef>(ROOT_SYMBOL.as_bytes()) };
    header
        .map(|header| *header)
        .map_err(|_| missing("root symbol", ROOT_SYMBOL))
}

/// The few lines of a library error that matter: a changed layout prints tens of kilobytes.
fn short(error: &LibraryError) -> String {
    let text = error.to_string();
    match error {
        LibraryError::AbiInstability(_) => format!(
            "its memory layout is not that of this host's plugin contract; build it again ({})",
            first_difference(&text)
        ),
        LibraryError::IncompatibleVersionNumber {
            expected_version,
            actual_version,
            ..
        } => format!(
            "built against version {actual_version} of the crate `abi`, this host has {expected_version}; build it again"
        ),
        _ => {
            let line = text
                .lines()
                .map(str::trim)
                .find(|l| !l.is_empty())
                .unwrap_or("unknown");
            format!("cannot be loaded: {line}")
        }
    }
}

/// Of the tens of kilobytes that a changed layout prints, in which the innermost difference stands last: where it is and
/// what it is.
fn first_difference(text: &str) -> String {
    let innermost = text.rsplit("error(s)inside:").next().unwrap_or(text);
    let (path, _) = innermost
        .split_once("Layout of expected type:")
        .unwrap_or((innermost, ""));
    // The n-th from the end.
    let value = |key: &str, n| {
        let values = path
            .lines()
            .rev()
            .filter_map(|l| l.trim().strip_prefix(key));
        values.map(str::to_owned).nth(n)
    };
    let place = match (value("field_name:", 0), value("type:", 1)) {
        (Some(field), Some(owner)) => format!("`{field}` of `{owner}`: "),
        _ => String::new(),
    };
    let error = innermost.rsplit_once("Error:").map_or("", |(_, e)| e);
    let error: Vec<&str> = error.split_whitespace().take(20).collect();
    format!("{place}{}", error.join(" "))
}
