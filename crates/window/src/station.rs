//! What the window needs of the station at which it is opened.

use crate::copies::LevelCopies;
use crate::films::Films;
use crate::ledger::{Debrief, Ledger};
use crate::level_pictures::LevelPictures;
use crate::references::References;
use microsim_host::playback::{Moment, Playback, Standing};
use microsim_host::run::{Operator, RunOutcome};
use microsim_message::{LocalText, SetupFile};
use microsim_settings::{Desktop, RendererConfig, WindowSettings};
use std::io::{Read, Seek};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

pub use crate::choice::Choice;

/// All that can be trained.
#[derive(Clone, Debug, Default)]
pub struct Catalogue {
    /// The modules, in the order of the installation.
    pub modules: Vec<ModuleEntry>,
    /// What is wrong with modules that are left out.
    pub complaints: Vec<String>,
}

/// A training module.
#[derive(Clone, Debug)]
pub struct ModuleEntry {
    /// Its name.
    pub name: String,
    /// Its title.
    pub title: LocalText,
    /// One sentence.
    pub summary: LocalText,
    /// Its levels, from the first, each before its variants.
    pub levels: Vec<LevelEntry>,
}

/// A level.
#[derive(Clone, Debug)]
pub struct LevelEntry {
    /// Its number, from 1.
    pub number: u32,
    /// The variant of it that this is; `None` for the level itself.
    pub variant: Option<String>,
    /// Its title.
    pub title: LocalText,
    /// What it asks for.
    pub summary: LocalText,
    /// The tools that take part.
    pub tools: Vec<ToolEntry>,
}

/// A tool that takes part.
#[derive(Clone, Debug)]
pub struct ToolEntry {
    /// Its slot.
    pub slot: String,
    /// What it is.
    pub title: LocalText,
}

/// Somebody who trains here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraineeEntry {
    /// Id of the store.
    pub id: String,
    /// The name.
    pub name: String,
}

/// A place to train at.
pub trait Station: Ledger + LevelCopies + Films + References + LevelPictures {
    /// What can be trained.
    fn catalogue(&self) -> Catalogue;

    /// Who trains here.
    ///
    /// # Errors
    /// Why the store cannot be read.
    fn trainees(&self) -> Result<Vec<TraineeEntry>, String>;

    /// Whether a level is not open to a trainee yet, and why.
    fn locked(&self, choice: &Choice) -> Option<LocalText>;

    /// A recorded run of a level.
    ///
    /// # Errors
    /// Why it cannot begin.
    fn begin(&self, choice: &Choice) -> Result<Box<dyn LiveSession>, String>;

    /// Stores how the window looks, for later windows of this station; the file.
    ///
    /// # Errors
    /// Why it cannot be written.
    fn store_settings(&self, settings: &WindowSettings) -> Result<PathBuf, String>;

    /// A recorded session that can be computed again.
    ///
    /// # Errors
    /// Why it cannot: it cannot be read, or its module is not installed.
    fn replay(&self, session: &Path) -> Result<Box<dyn Recording>, String>;
}

/// A recorded session that was not opened yet.
pub trait Recording: Send {
    /// What is seen of it, and how.
    fn picture(&self) -> &RendererConfig;

    /// The files of models that objects of its level have, by their names.
    fn files(&self) -> &[SetupFile];

    /// Length of a tick \[s\].
    fn tick(&self) -> f64;

    /// Reads it and prepares what computes it, in the thread that does, unless the viewer has left.
    ///
    /// # Errors
    /// Why it cannot be computed, or that it was left.
    fn open(self: Box<Self>, is_left: &AtomicBool) -> Result<Box<dyn Computation>, String>;
}

/// What computes a recorded session again, as [`Playback`] does.
pub trait Computation {
    /// The ticks that can be computed.
    fn range(&self) -> Range<u64>;

    /// The tick that comes next.
    fn tick(&self) -> u64;

    /// What the comparison with the recording shows so far.
    fn standing(&self) -> Standing;

    /// Plugins whose library is not the one that made the recording.
    fn rebuilt(&self) -> Vec<String>;

    /// Goes to the nearest place from which a tick can be computed.
    ///
    /// # Errors
    /// If the state cannot be restored.
    fn seek(&mut self, tick: u64) -> Result<(), String>;

    /// From the next tick on, states have what pictures of the computation show of bodies, or have it no longer.
    fn show_fields(&mut self, shows: bool);

    /// Computes a tick; `None` behind the last one.
    ///
    /// # Errors
    /// If the session cannot be read any more, or the state cannot be saved or restored.
    fn step(&mut self) -> Result<Option<Moment>, String>;
}

impl<R: Read + Seek> Computation for Playback<R> {
    fn range(&self) -> Range<u64> {
        let (first, end) = Self::range(self);
        first..end
    }

    fn tick(&self) -> u64 {
        Self::tick(self)
    }

    fn standing(&self) -> Standing {
        Self::standing(self).clone()
    }

    fn rebuilt(&self) -> Vec<String> {
        Self::rebuilt(self).to_vec()
    }

    fn seek(&mut self, tick: u64) -> Result<(), String> {
        Self::seek(self, tick).map_err(|e| e.to_string())
    }

    fn show_fields(&mut self, shows: bool) {
        Self::show_fields(self, shows);
    }

    fn step(&mut self) -> Result<Option<Moment>, String> {
        Self::step(self).map_err(|e| e.to_string())
    }
}

/// A run that has not begun yet.
pub trait LiveSession: Send {
    /// What is seen of it, and how.
    fn picture(&self) -> &RendererConfig;

    /// The files of models that objects of the level have, by their names.
    fn files(&self) -> &[SetupFile];

    /// How mouse and keyboard move the tools; `None` where something else does.
    fn desktop(&self) -> Option<&Desktop>;

    /// Largest sustained force of a tool that the level takes \[N\], beside the limits of its pairs.
    fn force_limit(&self) -> Option<f64>;

    /// Runs it to its end. Called once.
    ///
    /// # Errors
    /// Why it did not begin.
    fn run(&mut self, stop: &AtomicBool, operator: &mut dyn Operator)
    -> Result<RunOutcome, String>;

    /// Writes what it leaves behind.
    ///
    /// # Errors
    /// Why there is nothing to show; the session is safe as far as it was recorded.
    fn finish(self: Box<Self>, outcome: &RunOutcome) -> Result<Debrief, String>;
}
