//! What is installed below one folder: plugins, modules with their levels, and how the host runs sessions.

use crate::guest::GuestRules;
use crate::library::file_hash;
use crate::request::AssembleError;
use microsim_settings as settings;
use settings::{Level, Loaded, Manifest, ModuleFolder, Variant};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// The file below an installation with the digests of the libraries that it brought, and of manifests of modules, levels and shapes of tools,
/// as `b3sum --check` reads it.
pub const HASHES: &str = "installed.b3";

/// What else belongs to an installation: folders of plugins and modules with one folder for each, or the folder of one; settings of this station.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// Of plugins.
    pub plugins: Vec<PathBuf>,
    /// Of modules.
    pub modules: Vec<PathBuf>,
    /// Whose files take the place of those of `config/` with the same name, as far as [`OF_STATION`] names them.
    pub settings: Option<PathBuf>,
    /// Whose folders, one for each module, have variants of its levels that were made here.
    pub levels: Option<PathBuf>,
}

/// The files of `config/` that a station may replace by its own: how it runs, what its trackers are. What is trained and measured is not among them.
pub const OF_STATION: [&str; 6] = [
    "host.toml",
    "window.toml",
    "desktop.toml",
    "translator.toml",
    "openigtlink.toml",
    "trainees.toml",
];

/// Which plugins run in a process of their own, among modules, sources and translators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isolate {
    /// Those that the installation did not bring, and those whose manifest asks for it.
    Guests,
    /// All of them.
    All,
    /// None.
    None,
}

/// Which plugins run in a process of their own, and how.
#[derive(Clone, Debug)]
pub struct Guests {
    /// Which.
    pub which: Isolate,
    /// How.
    pub rules: GuestRules,
}

/// An installed tree: `plugins/`, `modules/`, `config/`, `assets/` below one folder.
#[derive(Debug)]
pub struct Installation {
    /// The folder.
    pub root: PathBuf,
    /// Folder of the configuration.
    pub config: PathBuf,
    /// Folder of the settings of this station, which need not exist.
    pub station: Option<PathBuf>,
    /// Folder of the variants of levels that were made here, which need not exist.
    pub made_here: Option<PathBuf>,
    /// Plugins and modules.
    pub tree: settings::Tree,
    /// How the host runs sessions.
    pub host: settings::Host,
    /// What is wrong with single plugins or modules; they are hidden.
    pub complaints: Vec<settings::ConfigError>,
    /// Which plugins run in a process of their own, and how.
    pub guests: Guests,
    /// The calibration of this station, which need not exist; `None` where nothing of it counts.
    pub calibration: Option<PathBuf>,
    /// Files that the installation brought, by their path, with their digests.
    hashes: BTreeMap<PathBuf, String>,
    /// Levels that were read already, by their files: each is parsed once in a process.
    levels: Mutex<BTreeMap<PathBuf, Arc<Loaded<Level>>>>,
}

impl Installation {
    /// Opens the tree below `root`; `config` replaces its `config/`.
    pub fn open(root: &Path, config: Option<&Path>) -> Result<Self, AssembleError> {
        Self::open_with(root, config, &Places::default())
    }

    /// Opens the tree below `root` and what lies in other places.
    pub fn open_with(
        root: &Path,
        config: Option<&Path>,
        more: &Places,
    ) -> Result<Self, AssembleError> {
        let config = config.map_or_else(|| root.join("config"), Path::to_path_buf);
        let station = more.settings.clone();
        let host =
            settings::load_host(&setting(&config, station.as_deref(), "host.toml"))?.settings;
        let (tree, complaints) = settings::discover_with(root, &more.plugins, &more.modules);
        let guests = Guests {
            which: Isolate::Guests,
            rules: GuestRules {
                program: root.join(format!("microsim{}", std::env::consts::EXE_SUFFIX)),
                deadline: Some(Duration::from_secs_f64(host.guest.deadline)),
                memory: Some(u64::from(host.guest.memory) << 20),
                silent: false,
            },
        };
        Ok(Self {
            root: root.to_path_buf(),
            config,
            station,
            made_here: more.levels.clone(),
            tree,
            host,
            complaints,
            guests,
            calibration: None,
            hashes: hashes(root)?,
            levels: Mutex::default(),
        })
    }

    /// The file of settings of this name: that of the station, if it has one, else that of `config/`.
    pub fn setting(&self, name: &str) -> PathBuf {
        setting(&self.config, self.station.as_deref(), name)
    }

    /// The files of the station that take the place of those of `config/`.
    pub fn replaced(&self) -> Vec<PathBuf> {
        let files = OF_STATION.iter().map(|name| self.setting(name));
        files
            .filter(|file| !file.starts_with(&self.config))
            .collect()
    }

    /// Whether the installation brought this file, as it is.
    pub(crate) fn brought(&self, file: &Path, hash: &str) -> bool {
        self.hash_of(file).is_some_and(|known| known == hash)
    }

    /// The digest with which the installation brought a file.
    pub(crate) fn hash_of(&self, file: &Path) -> Option<&String> {
        self.hashes.get(file)
    }

    /// Those of the files of a level of a module that are not as the installation brought them, `config/`, `modules/` and `levels/` before their names.
    /// None for a module that it did not bring, and in an installation without digests.
    pub(crate) fn changed(
        &self,
        module: &ModuleFolder,
        level: &Path,
        parts: impl Iterator<Item = PathBuf>,
    ) -> Result<Vec<String>, AssembleError> {
        let manifest = module.manifest.document.path();
        if self.hash_of(&manifest).is_none() {
            return Ok(Vec::new());
        }
        let files = [manifest, level.to_path_buf()];
        let mut changed = Vec::new();
        for file in files.into_iter().chain(parts) {
            let hash = file_hash(&file).map_err(|e| {
                AssembleError(format!("{}: {}", file.display(), settings::in_words(e)))
            })?;
            if self.brought(&file, &hash) {
                continue;
            }
            let here = self.made_here.iter().map(|folder| (folder, "levels"));
            let name = [(&self.config, "config"), (&self.root, "")]
                .into_iter()
                .chain(here)
                .find_map(|(folder, name)| {
                    Some(Path::new(name).join(file.strip_prefix(folder).ok()?))
                });
            changed.push(name.unwrap_or(file).display().to_string());
        }
        Ok(changed)
    }

    /// The manifest of a plugin.
    pub fn plugin(&self, name: &str) -> Result<&Loaded<Manifest>, AssembleError> {
        let found = self.tree.plugins.iter().find(|p| p.settings.name == name);
        let found = found.ok_or_else(|| {
            let names: Vec<&str> = self
                .tree
                .plugins
                .iter()
                .map(|p| p.settings.name.as_str())
                .collect();
            AssembleError(
                format!(
                    "no plugin \"{name}\" below {}; there are: {}",
                    self.root.join("plugins").display(),
                    names.join(", ")
                ) + &self.hidden(name),
            )
        })?;
        self.unless_wrong(name, found)
    }

    /// A module with its levels.
    pub fn module(&self, name: &str) -> Result<&ModuleFolder, AssembleError> {
        let found = self
            .tree
            .modules
            .iter()
            .find(|m| m.manifest.settings.name == name);
        let found = found.ok_or_else(|| {
            let names: Vec<&str> = self
                .tree
                .modules
                .iter()
                .map(|m| m.manifest.settings.name.as_str())
                .collect();
            AssembleError(
                format!(
                    "no module \"{name}\" below {}; there are: {}",
                    self.root.join("modules").display(),
                    names.join(", ")
                ) + &self.hidden(name),
            )
        })?;
        self.unless_wrong(name, found)
    }

    /// What was found, unless something is wrong with a manifest of this name: that there is another one, for example.
    fn unless_wrong<T>(&self, name: &str, found: T) -> Result<T, AssembleError> {
        let modules = self.tree.modules.iter().map(|m| &m.manifest);
        let files: Vec<String> = self
            .tree
            .plugins
            .iter()
            .chain(modules)
            .filter(|m| m.settings.name == name)
            .map(|m| m.document.path().display().to_string())
            .collect();
        let wrong: Vec<String> = self
            .complaints
            .iter()
            // Which plugins a module lacks, and why, is found when they are looked for.
            .filter(|c| files.contains(&c.file) && !c.key.to_string().starts_with("plugins"))
            .map(ToString::to_string)
            .collect();
        match wrong.is_empty() {
            true => Ok(found),
            false => Err(AssembleError(wrong.join("\n"))),
        }
    }

    /// The complaints that may be why something is not there.
    fn hidden(&self, name: &str) -> String {
        let about: Vec<String> = self
            .complaints
            .iter()
            .filter(|c| c.file.contains(name))
            .map(|c| format!("\n{c}"))
            .collect();
        about.concat()
    }

    /// A level of a module, checked.
    pub fn level(&self, module: &str, level: u32) -> Result<Arc<Loaded<Level>>, AssembleError> {
        self.variant(module, level, None)
    }

    /// The variants of the levels of a module: those that came with it, then those that were made here, as they are now; what is wrong with these.
    pub fn variants(&self, folder: &ModuleFolder) -> (Vec<Variant>, Vec<settings::ConfigError>) {
        let mut variants = folder.variants.clone();
        let Some(here) = self.folder_made_here(folder) else {
            return (variants, Vec::new());
        };
        let (found, errors) = settings::variants_in(&here, folder.levels.len());
        // One that came with the module goes before one of the same name.
        let is_new = |of: &Variant| {
            let mut shipped = folder.variants.iter();
            !shipped.any(|known| (known.level, &known.name) == (of.level, &of.name))
        };
        variants.extend(found.into_iter().filter(is_new));
        (variants, errors)
    }

    /// Whether a variant was made here, and did not come with its module.
    pub fn is_made_here(&self, variant: &Variant) -> bool {
        let here = self.made_here.as_ref();
        here.is_some_and(|folder| variant.path.starts_with(folder))
    }

    /// The folder of the variants of a module's levels that were made here, which need not exist.
    pub fn folder_made_here(&self, folder: &ModuleFolder) -> Option<PathBuf> {
        let here = self.made_here.as_ref()?;
        Some(here.join(&folder.manifest.settings.name))
    }

    /// A variant of a level, or the level itself, checked.
    pub fn variant(
        &self,
        module: &str,
        level: u32,
        variant: Option<&str>,
    ) -> Result<Arc<Loaded<Level>>, AssembleError> {
        let folder = self.module(module)?;
        let index = (level as usize).wrapping_sub(1);
        let path = folder.levels.get(index).ok_or_else(|| {
            let has = match folder.levels.len() {
                0 => "no level".to_owned(),
                n => format!("levels 1 to {n}"),
            };
            AssembleError(
                format!("module \"{module}\" has {has}, not {level}") + &self.hidden(module),
            )
        })?;
        let path = match variant {
            None => path,
            Some(name) => &variant_of(self.variants(folder).0, level, name)
                .map_err(|has| AssembleError(format!("level {level} of \"{module}\" {has}")))?,
        };
        let mut levels = self.levels.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(read) = levels.get(path) {
            return Ok(Arc::clone(read));
        }
        let manifest = &folder.manifest.settings;
        let vessels = self.config.join("vessels");
        let read = settings::load_level_with(path, manifest, &known_metrics(), &vessels)?;
        let read = Arc::new(read);
        levels.insert(path.clone(), Arc::clone(&read));
        Ok(read)
    }

    /// The file with the shape of a tool.
    pub fn tool_file(&self, model: &str) -> PathBuf {
        self.config.join("tools").join(format!("{model}.toml"))
    }

    /// The file of a vessel.
    pub(crate) fn vessel_file(&self, name: &str) -> PathBuf {
        self.config.join("vessels").join(format!("{name}.toml"))
    }

    /// A file by the name that an operator gave: as it stands, or below the installation.
    pub fn find(&self, given: &Path, folders: &[PathBuf]) -> PathBuf {
        let mut candidates = vec![given.to_path_buf(), self.root.join(given)];
        candidates.extend(folders.iter().map(|f| f.join(given)));
        let found = candidates.into_iter().find(|p| p.is_file());
        found.unwrap_or_else(|| given.to_path_buf())
    }
}

/// The file of a variant of a level, or what variants there are.
fn variant_of(mut variants: Vec<Variant>, level: u32, name: &str) -> Result<PathBuf, String> {
    variants.retain(|variant| variant.level == level);
    if let Some(found) = variants.iter().find(|variant| variant.name == name) {
        return Ok(found.path.clone());
    }
    let names: Vec<&str> = variants
        .iter()
        .map(|variant| variant.name.as_str())
        .collect();
    Err(match names.as_slice() {
        [] => format!("has no variants, and so no \"{name}\""),
        names => format!("has no variant \"{name}\": there is {}", names.join(", ")),
    })
}

/// The file of settings of this name. One that is there and cannot be read is taken all the same, and complained about.
fn setting(config: &Path, station: Option<&Path>, name: &str) -> PathBuf {
    let own = station.filter(|_| OF_STATION.contains(&name));
    let own = own.map(|folder| folder.join(name));
    let there = |file: &PathBuf| match file.symlink_metadata() {
        Ok(_) => true,
        Err(error) => !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory),
    };
    own.filter(there).unwrap_or_else(|| config.join(name))
}

/// The digests of the files that the installation brought; none where it has no such file.
fn hashes(root: &Path) -> Result<BTreeMap<PathBuf, String>, AssembleError> {
    let path = root.join(HASHES);
    if !path.exists() {
        return Ok(BTreeMap::new());
    }
    let bad = |what: &str| AssembleError(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(&path).map_err(|e| bad(&e.to_string()))?;
    let line = |(number, line): (usize, &str)| {
        let parts = line
            .split_once("  ")
            .filter(|(hash, _)| hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit()));
        let (hash, file) = parts.ok_or_else(|| {
            let number = number + 1;
            bad(&format!(
                "line {number}: expected a digest of 64 hexadecimal digits, two spaces, a path"
            ))
        })?;
        Ok((root.join(file), hash.to_owned()))
    };
    text.lines().enumerate().map(line).collect()
}

/// The motion metrics that every level may limit.
pub fn known_metrics() -> Vec<settings::KnownMetric<'static>> {
    use microsim_training::MOTION_METRICS;
    let known = MOTION_METRICS.iter().filter_map(|metric| {
        Some(settings::KnownMetric {
            id: metric.id.as_ref(),
            unit: settings::Unit::of_symbol(&metric.unit)?,
            direction: metric.direction,
        })
    });
    known.collect()
}
