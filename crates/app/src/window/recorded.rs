//! Recorded sessions, computed again for the window: nothing is stored.

use crate::output::Problem;
use crate::session_file::{read_around, report_of};
use microsim_host::assemble::{Installation, locate, renderer_for};
use microsim_host::plan::{PlannedPlugin, PluginKind};
use microsim_host::playback::{Playback, PlaybackOptions};
use microsim_host::record::SessionReader;
use microsim_host::run::RunError;
use microsim_message::SetupFile;
use microsim_settings::{RendererConfig, open_regular};
use microsim_window::{Computation, Debrief, Recording, SHOWN};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Most memory for checkpoints \[byte\].
const MEMORY: usize = 256 << 20;

/// A session file, with what is installed of what it needs.
pub struct Recorded {
    path: PathBuf,
    picture: RendererConfig,
    files: Vec<SetupFile>,
    tick_s: f64,
    /// The installed plugins, by the names of those that were recorded.
    plugins: BTreeMap<String, PlannedPlugin>,
}

fn named(path: &Path) -> impl Fn(&dyn std::fmt::Display) -> String {
    let path = path.display().to_string();
    move |why| format!("session {path}: {why}")
}

fn opened(path: &Path) -> Result<BufReader<File>, String> {
    let file = open_regular(path).map_err(|e| named(path)(&e))?;
    Ok(BufReader::new(file))
}

impl Recorded {
    /// A session that can be computed again with what is installed.
    ///
    /// # Errors
    /// If it cannot be read, is of another version, or its module or one of its plugins is not installed.
    pub fn new(installation: &Installation, path: &Path) -> Result<Self, Problem> {
        let named = named(path);
        let reader = SessionReader::open(opened(path)?).map_err(|e| named(&e))?;
        let session = reader.session();
        session.check_recomputable().map_err(|e| named(&e))?;
        let plan = &session.header.plan;
        let renderer = renderer_for(installation, plan, None).map_err(|e| named(&e))?;
        let picture = renderer.setup.configuration().map_err(|e| named(&e))?;
        let mut plugins = BTreeMap::new();
        for plugin in plan.plugins.iter().filter(|p| !p.kind.is_observer()) {
            let located = locate(installation, plugin).map_err(|e| named(&e))?;
            if located.library_hash != plugin.library_hash && plugin.kind != PluginKind::Source {
                let name = &plugin.name;
                tracing::warn!("plugin \"{name}\" is not the build that made this recording");
            }
            plugins.insert(plugin.name.clone(), located);
        }
        Ok(Self {
            path: path.to_path_buf(),
            picture,
            files: renderer.setup.files,
            tick_s: plan.tick_ns as f64 * 1e-9,
            plugins,
        })
    }
}

impl Recording for Recorded {
    fn picture(&self) -> &RendererConfig {
        &self.picture
    }

    fn files(&self) -> &[SetupFile] {
        &self.files
    }

    fn tick(&self) -> f64 {
        self.tick_s
    }

    fn open(self: Box<Self>, is_left: &AtomicBool) -> Result<Box<dyn Computation>, String> {
        let options = PlaybackOptions {
            threads: 1,
            shown: &SHOWN,
            memory: MEMORY,
            stop: is_left,
        };
        let installed = |planned: &PlannedPlugin| {
            let found = self.plugins.get(&planned.name).cloned();
            // What lies in the file now is not what lay there.
            let other = || RunError::Host("the session has other plugins than before".into());
            found.ok_or_else(other)
        };
        let playback = Playback::open(opened(&self.path)?, &options, installed);
        Ok(Box::new(playback.map_err(|e| named(&self.path)(&e))?))
    }
}

/// What came of a session, as it is shown again.
///
/// # Errors
/// If it cannot be read.
pub fn debrief(session: PathBuf) -> Result<Debrief, Problem> {
    let recorded = read_around(&session)?;
    Ok(Debrief {
        report: report_of(&recorded, &session)?,
        variant: recorded.header.plan.variant.clone(),
        page: session.with_extension("html"),
        session,
        complaints: Vec::new(),
    })
}
