//! Where the files of a user lie: sessions and trainees, settings of this station, what can be computed again, logs. Nothing of it lies in the installation.

use crate::cli::Place;
use etcetera::{AppStrategy, AppStrategyArgs, choose_app_strategy};
use microsim_settings::unwritable;
use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

/// Environment variable that is `--data`.
const VARIABLE: &str = "MICROSIM_DATA";

/// The folders of a user: those of the system (XDG on Linux), or all below one that `--data` or the environment names. None needs to exist yet.
#[derive(Clone, Debug)]
pub struct Folders {
    /// Sessions, the store, the key of the station.
    pub data: PathBuf,
    /// Settings that take the place of shipped ones.
    pub config: PathBuf,
    /// What can be computed again.
    pub cache: PathBuf,
    /// Log files.
    pub logs: PathBuf,
}

impl Folders {
    /// The folders for a command.
    ///
    /// # Errors
    /// If neither the command line nor the environment names a place: no home folder.
    pub fn of(place: &Place) -> Result<Self, String> {
        let variable = || std::env::var_os(VARIABLE).filter(|value| !value.is_empty());
        let named = place.data.clone().or_else(|| variable().map(PathBuf::from));
        if let Some(data) = named {
            let data =
                std::path::absolute(&data).map_err(|e| format!("{}: {e}", data.display()))?;
            return Ok(Self {
                config: data.join("config"),
                cache: data.join("cache"),
                logs: data.join("logs"),
                data,
            });
        }
        let names = AppStrategyArgs {
            top_level_domain: String::new(),
            author: String::new(),
            app_name: "microsim".into(),
        };
        let system = choose_app_strategy(names).map_err(|e| {
            format!(
                "there is no place for sessions and trainees: neither --data nor {VARIABLE} is given, and this user has no home folder ({e})"
            )
        })?;
        // Systems without a folder for state have logs beside the cache.
        let state = system.state_dir().unwrap_or_else(|| system.cache_dir());
        Ok(Self {
            data: system.data_dir(),
            config: system.config_dir(),
            cache: system.cache_dir(),
            logs: state.join("logs"),
        })
    }

    /// Folder of the sessions that no command names a place for.
    pub fn sessions(&self) -> PathBuf {
        self.data.join("sessions")
    }

    /// A session by the name under which a run has recorded it, with `.session` or without.
    pub fn session(&self, name: &Path) -> Option<PathBuf> {
        let is_name = name.components().count() == 1;
        let path = self.sessions().join(name);
        let mut with_extension = path.clone().into_os_string();
        with_extension.push(".session");
        let candidates = [path, with_extension.into()].into_iter();
        let mut found = candidates.filter(|path: &PathBuf| is_name && path.is_file());
        found.next()
    }

    /// Folder of the tables that nobody names a file for.
    pub fn tables(&self) -> PathBuf {
        self.data.join("tables")
    }

    /// Folder of the variants of levels that were made here.
    pub fn levels(&self) -> PathBuf {
        self.data.join("levels")
    }

    /// What was calibrated on this station.
    pub fn calibration(&self) -> PathBuf {
        self.config.join("calibration.toml")
    }

    /// The database of trainees, courses, sessions and results.
    pub fn store(&self) -> PathBuf {
        self.data.join("store.sqlite")
    }
}

/// Makes a folder of a user, and those around it that are missing, for the user alone: names of trainees are in them.
pub fn make(folder: &Path) -> Result<(), String> {
    let made = DirBuilder::new().recursive(true).mode(0o700).create(folder);
    made.map_err(|e| unwritable(folder, e))
}
