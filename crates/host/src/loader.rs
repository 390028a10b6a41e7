//! Loads a plugin's library from an explicit path, after checking all that can be checked before its code runs.

use crate::plan::PlannedPlugin;
use abi_stable::library::{LibraryError, lib_header_from_path};
use microsim_abi::{ABI_VERSION, FaultKind, PluginBox, PluginModule_Ref};
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

/// Loads the library and constructs the plugin. Layout, ABI version and manifest are checked first, in this order.
///
/// The library stays loaded until the process ends (abi_stable never unloads one).
pub fn load(plugin: &PlannedPlugin) -> Result<PluginBox, LoadError> {
    let refuse = |reason: String| LoadError {
        plugin: plugin.name.clone(),
        path: plugin.library.clone(),
        reason,
    };
    if !plugin.library.is_file() {
        return Err(refuse(
            "the library is not there; build it, or correct `library` in its manifest".into(),
        ));
    }
    // `RootModule::load_from_file` would return the first plugin again for a second path; the header does not.
    let header = lib_header_from_path(&plugin.library).map_err(|e| refuse(short(&e)))?;
    let module = header
        .init_root_module::<PluginModule_Ref>()
        .map_err(|e| refuse(short(&e)))?;
    let version = module.abi_version();
    if version != ABI_VERSION {
        return Err(refuse(format!(
            "built for version {version} of the plugin contract, this host has version {ABI_VERSION}; build it again"
        )));
    }
    if module.manifest()().as_str() != plugin.manifest {
        return Err(refuse(
            "the manifest beside the library is not the one it was built with; build it again"
                .into(),
        ));
    }
    module.create()().into_result().map_err(|fault| {
        let how = if fault.kind == FaultKind::Panic {
            "panicked"
        } else {
            "failed"
        };
        refuse(format!("{how} in `create`: {}", fault.text))
    })
}

/// The few lines of a library error that matter: a changed layout prints tens of kilobytes.
fn short(error: &LibraryError) -> String {
    let text = error.to_string();
    match error {
        LibraryError::OpenError { err, .. } => format!("cannot be opened as a library: {err}"),
        LibraryError::GetSymbolError { .. } => {
            "exports no plugin (the root symbol is missing): does it call `export_plugin!`?".into()
        }
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
    let (way, _) = innermost
        .split_once("Layout of expected type:")
        .unwrap_or((innermost, ""));
    // The n-th from the end.
    let value = |key: &str, n| {
        let values = way.lines().rev().filter_map(|l| l.trim().strip_prefix(key));
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
