//! What the level editor needs of a station: the numbers of a level, and a copy of it with others.

use crate::choice::Choice;
use microsim_settings::{KeyPath, LevelNumber};
use std::path::PathBuf;

/// Numbers that are others, with what stands there instead.
pub type Changes = Vec<(KeyPath, String)>;

/// Copies of levels, which are variants of them.
pub trait LevelCopies {
    /// The numbers of a level that a copy may have otherwise.
    ///
    /// # Errors
    /// Why the level cannot be read.
    fn numbers(&self, choice: &Choice) -> Result<Vec<LevelNumber>, String>;

    /// What is wrong with a level that has these numbers; nothing if it is one.
    fn complaints(&self, choice: &Choice, changes: &Changes) -> Vec<String>;

    /// Writes a level with these numbers as a variant of this name; its file. What is there is never replaced.
    ///
    /// # Errors
    /// Why there is no such file: the name, a number, the place.
    fn store_copy(&self, choice: &Choice, name: &str, changes: &Changes)
    -> Result<PathBuf, String>;
}
