//! A plugin as it is installed: its library, its files and the set-up that it is given.

use crate::installation::{HASHES, Installation, Isolate};
use crate::loader::file_hash;
use crate::plan::{Hosting, OwnKind, PlannedPlugin};
use crate::request::{AssembleError, refuse};
use abi_stable::std_types::{ROption, RSlice};
use microsim_message::{Setup, SetupFile, encode};
use microsim_settings::{self as settings, Loaded, Manifest};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// What all plugins of a run are given alike.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunSetup {
    pub seed: u64,
    pub tick_ns: u64,
    pub steps: u32,
    pub level: u32,
}

/// The folder of a manifest.
fn folder(manifest: &Loaded<Manifest>) -> PathBuf {
    let path = manifest.document.path();
    path.parent().map(Path::to_path_buf).unwrap_or_default()
}

/// Where the library of a manifest lies: beside it, or, for a project of its own, where cargo builds it.
pub(crate) fn library(manifest: &Loaded<Manifest>) -> PathBuf {
    let name = format!(
        "{}{}{}",
        std::env::consts::DLL_PREFIX,
        manifest.settings.library,
        std::env::consts::DLL_SUFFIX
    );
    let folder = folder(manifest);
    let beside = folder.join(&name);
    let built = folder.join("target").join("release").join(name);
    match !beside.is_file() && built.is_file() {
        true => built,
        false => beside,
    }
}

/// In which process a plugin runs: in the host's if its library is one that the installation brought, and nobody wants it otherwise.
fn hosting(
    installation: &Installation,
    manifest: &Manifest,
    library: &Path,
    hash: &str,
) -> Hosting {
    let known = installation.brought(library, hash);
    let guests = &installation.guests;
    let rules = || guests.rules.clone();
    match (manifest.kind.can_be_isolated(), guests.which) {
        (true, Isolate::All) => Hosting::Guest(rules()),
        (true, Isolate::Guests) if !known || manifest.isolate => Hosting::Guest(rules()),
        _ if known => Hosting::Inside,
        _ => Hosting::TriedFirst(rules()),
    }
}

/// What is wrong with the library of an installed plugin: it is not there, is not the one that was installed, cannot be opened, or was built
/// for another version of the contract.
pub fn check_library(
    installation: &Installation,
    manifest: &Loaded<Manifest>,
) -> Result<(), AssembleError> {
    let m = &manifest.settings;
    let run = RunSetup {
        seed: 0,
        tick_ns: 1_000_000,
        steps: 1,
        level: 1,
    };
    let planned = planned(
        installation,
        manifest,
        String::new(),
        run,
        Value::Null,
        Vec::new(),
    )?;
    if let Some(installed) = installation.hash_of(&planned.library)
        && *installed != planned.library_hash
    {
        return refuse(format!(
            "plugin \"{}\" ({}): the library is not the one that was installed (its hash is not that of {}); install it again",
            m.name,
            planned.library.display(),
            HASHES
        ));
    }
    // In a process of its own, whatever is wrong with it.
    let rules = installation.guests.rules.clone();
    let tried = PlannedPlugin {
        hosting: Hosting::Guest(rules),
        ..planned
    };
    let opened = crate::loader::load(&tried).map(drop);
    opened.map_err(|e| AssembleError(e.to_string()))
}

/// A plugin of a run with its configuration, `more` being files that the configuration names.
pub(crate) fn planned(
    installation: &Installation,
    manifest: &Loaded<Manifest>,
    why: String,
    run: RunSetup,
    config: Value,
    more: Vec<SetupFile>,
) -> Result<PlannedPlugin, AssembleError> {
    let m = &manifest.settings;
    if m.abi != microsim_abi::ABI_VERSION {
        return refuse(format!(
            "plugin \"{}\" ({}): its manifest has version {} of the plugin contract, this host has version {}",
            m.name,
            manifest.document.path().display(),
            m.abi,
            microsim_abi::ABI_VERSION
        ));
    }
    let library = library(manifest);
    let library_hash = file_hash(&library).map_err(|e| {
        AssembleError(format!(
            "plugin \"{}\": its library {} cannot be read: {}",
            m.name,
            library.display(),
            settings::in_words(e)
        ))
    })?;
    let mut files = Vec::new();
    for file in &m.file {
        let path = folder(manifest).join(&file.path);
        let bytes = std::fs::read(&path).map_err(|e| {
            AssembleError(format!(
                "plugin \"{}\": file {}: {e}",
                m.name,
                path.display()
            ))
        })?;
        files.push(SetupFile {
            name: file.name.clone(),
            bytes,
        });
    }
    files.extend(more);
    Ok(PlannedPlugin {
        name: m.name.clone(),
        kind: m.kind,
        version: m.version.clone(),
        publishes: m.publishes.clone(),
        subscribes: m.subscribes.clone(),
        own_kinds: own_kinds(m),
        hosting: hosting(installation, m, &library, &library_hash),
        library,
        manifest: manifest.document.text().to_owned(),
        library_hash,
        why,
        setup: Setup {
            name: m.name.clone(),
            seed: run.seed,
            tick_ns: run.tick_ns,
            steps: run.steps,
            level: run.level,
            config,
            files,
        },
    })
}

/// The installed plugin for a recorded one, for a replay: what is installed decides of what kind it is, what it may publish and what it
/// subscribes to; only what it was given comes from the recording.
pub fn locate(
    installation: &Installation,
    recorded: &PlannedPlugin,
) -> Result<PlannedPlugin, AssembleError> {
    let manifest = manifest(installation, recorded)?;
    let m = &manifest.settings;
    if m.kind != recorded.kind {
        return refuse(format!(
            "plugin \"{}\" is recorded as a {}; what is installed is a {}, so that the recording is not what it seems",
            m.name,
            recorded.kind.name(),
            m.kind.name()
        ));
    }
    let library = library(manifest);
    let library_hash = file_hash(&library)
        .map_err(|e| AssembleError(format!("library {}: {e}", library.display())))?;
    Ok(PlannedPlugin {
        hosting: hosting(installation, m, &library, &library_hash),
        library,
        library_hash,
        manifest: manifest.document.text().to_owned(),
        publishes: m.publishes.clone(),
        subscribes: m.subscribes.clone(),
        own_kinds: own_kinds(m),
        ..recorded.clone()
    })
}

/// The manifest of this name, whatever kind the recording states.
fn manifest<'a>(
    installation: &'a Installation,
    recorded: &PlannedPlugin,
) -> Result<&'a Loaded<Manifest>, AssembleError> {
    let name = &recorded.name;
    let modules = &installation.tree.modules;
    let is_module = modules.iter().any(|m| m.manifest.settings.name == *name);
    match is_module {
        true => Ok(&installation.module(name)?.manifest),
        false => installation.plugin(name),
    }
}

/// The message kinds that a plugin brings.
fn own_kinds(manifest: &Manifest) -> Vec<OwnKind> {
    let own_kind = |kind: &settings::MessageKind| OwnKind {
        name: kind.name.clone(),
        version: kind.version as u16,
        drop_oldest: kind.overflow == settings::Overflow::DropOldest,
    };
    manifest.message.iter().map(own_kind).collect()
}

/// Loads and initialises one plugin, and nothing more.
pub(crate) fn probe(
    installation: &Installation,
    name: &str,
    config: Value,
    files: Vec<SetupFile>,
) -> Result<(), String> {
    let manifest = installation.plugin(name).map_err(|e| e.to_string())?;
    let run = RunSetup {
        seed: 0,
        tick_ns: 1_000_000,
        steps: 1,
        level: 1,
    };
    let planned = planned(installation, manifest, String::new(), run, config, files)
        .map_err(|e| e.to_string())?;
    let mut object = crate::loader::load(&planned).map_err(|e| e.to_string())?;
    let setup = encode(&planned.setup);
    let result = object
        .initialise(RSlice::from_slice(&setup), ROption::RNone)
        .into_result();
    result.map_err(|fault| fault.text.into_string())
}
