//! What the window needs of the station at which it is opened.

use crate::ledger::{Debrief, Ledger};
use microsim_host::run::{Operator, RunOutcome};
use microsim_message::{LocalText, SetupFile};
use microsim_settings::{Desktop, RendererConfig};
use std::sync::atomic::AtomicBool;

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
    /// Its levels, from the first.
    pub levels: Vec<LevelEntry>,
}

/// A level.
#[derive(Clone, Debug)]
pub struct LevelEntry {
    /// Its number, from 1.
    pub number: u32,
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

/// What is to be trained, and by whom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Module.
    pub module: String,
    /// Level, from 1.
    pub level: u32,
    /// Id of the trainee.
    pub trainee: Option<String>,
}

/// A place to train at.
pub trait Station: Ledger {
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
}

/// A run that has not begun yet.
pub trait LiveSession: Send {
    /// What is seen of it, and how.
    fn picture(&self) -> &RendererConfig;

    /// The files of models that objects of the level have, by their names.
    fn files(&self) -> &[SetupFile];

    /// How mouse and keyboard move the tools; `None` where something else does.
    fn desktop(&self) -> Option<&Desktop>;

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
