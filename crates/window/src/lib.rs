//! The operator's window: choosing a module and a level, training under the microscope, and what came of it, in German and English.
//!
//! [`open`] shows it until it is closed. What it trains with is a [`Station`]: who trains, what there is to train, and runs that are recorded; the window
//! itself reads no file and writes none.
//!
//! - `station`: what a station gives.
//! - `live`: a run in a thread of its own, paced by the wall clock. The window takes the newest finished snapshot; nothing in the run depends on
//!   whether and when it is drawn.
//! - `hands`: mouse and keyboard as wishes for the tools.
//! - `scope`: the microscope, by keys.
//! - `field`: the picture, drawn by the crate `render` into a texture.
//! - `desk`: which screen is shown: `launcher`, `training` with `panels` beside the picture, `debrief` with `plot`.
//! - `look`: colours and sizes; `text`: all texts.
//!
//! Not here: physics, scores, files, the command line. What is drawn is never longer than what a level gave: a window that is slow shows fewer pictures.

#![forbid(unsafe_code)]

mod debrief;
mod desk;
mod field;
mod hands;
mod launcher;
mod live;
mod look;
mod panels;
mod plot;
mod scope;
mod station;
#[cfg(test)]
mod tests;
mod text;
mod training;

pub use desk::{Opening, WindowError, open};
pub use station::{
    Catalogue, Choice, Debrief, LevelEntry, LiveSession, ModuleEntry, Station, ToolEntry,
    TraineeEntry,
};
