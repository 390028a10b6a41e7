//! What films need of a station: a place for their pictures.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// What became of the pictures as one file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Video {
    /// This one.
    Made(PathBuf),
    /// The machine has no program that makes one.
    NoProgram,
    /// That program failed.
    Failed(String),
    /// It was stopped before.
    Stopped,
}

/// What there is of a film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Filmed {
    /// Where the pictures lie.
    pub folder: PathBuf,
    /// Their number.
    pub pictures: u32,
    /// All of them as one file.
    pub video: Video,
}

/// Where the pictures of a film go.
pub trait Film: Send {
    /// Takes the next picture, in PNG.
    ///
    /// # Errors
    /// Why it cannot be written; those before are there.
    fn add(&mut self, png: &[u8]) -> Result<(), String>;

    /// Makes one file of all of them, unless it is stopped.
    fn finish(self: Box<Self>, is_stopped: &AtomicBool) -> Filmed;
}

/// A station that takes films.
pub trait Films {
    /// A place for the film of a session.
    ///
    /// # Errors
    /// Why nothing can be written there.
    fn film(&self, session: &Path) -> Result<Box<dyn Film>, String>;
}
