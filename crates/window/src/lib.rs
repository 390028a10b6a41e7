//! The operator's window: choosing a module and a level, training under the microscope, and what came of it, in German and English.
//!
//! [`open`] shows it until it is closed. What it trains with is a [`Station`]: who trains, what there is to train, and runs that are recorded; the window
//! itself reads no file and writes none.
//!
//! - `station`: what a station gives.
//! - `choice`: what is chosen of it.
//! - `live`: a run in a thread of its own, paced by the wall clock. The window takes the newest finished snapshot; nothing in the run depends on
//!   whether and when it is drawn.
//! - `threads`: computing goes before drawing; `memory` that was freed goes back to the system.
//! - `pace`: how well it follows the wall clock, and how long motions take to the picture; `account`: what the log states of both.
//! - `hands`: mouse and keyboard as wishes for the tools.
//! - `steering`: gamepads and SpaceMice as wishes and keys.
//! - `pedal`: keys of a foot switch.
//! - `scope`: the microscope, by keys.
//! - `field`: the picture, drawn by the crate `render` into a texture that `blit` copies into the window.
//! - `desk`: which screen is shown: `launcher`, `training` with `panels` beside the picture, `debrief` with `plot`, `replay`, `records`.
//! - `launcher`: modules and levels as `cards`, with pictures of a `gallery`, of [`LevelPictures`].
//! - `replay`: a recorded session, with `console` around its picture and `timeline` below it; `player` computes it in a thread of its own,
//!   with the states `nearby` in memory.
//! - `device`: the graphics device under the window, had back where the driver loses it.
//!   `references` are runs beside which it is shown, of which `ghost` draws the tools; a `film` is made of it, ordered in its `film_row`; `films` go to the station.
//! - `canvas`: the place of a picture on a screen.
//! - `records`: trainees and results, of a [`Ledger`]: `attempts`, `learning`, `courses`, `person`, in `rows`.
//! - `appearance`: the settings screen.
//! - `editor`: numbers of a level, with units and ranges, and a copy of it with others, of [`LevelCopies`]; `number_words` explains them in German.
//! - `upkeep`: courses and the store as a whole, with `work` that goes on beside the window's thread.
//! - `look`: colours and sizes; `text`: all texts.
//!
//! Not here: physics, scores, files, the command line. What is drawn is never longer than what a level gave: a window that is slow shows fewer pictures.

#![allow(
    unsafe_code,
    reason = "asks the allocator of the C library to give memory back"
)]

mod account;
mod appearance;
mod attempts;
mod blit;
mod canvas;
mod cards;
mod choice;
mod console;
mod copies;
mod courses;
mod debrief;
mod desk;
mod device;
mod editor;
mod field;
mod film;
mod film_row;
mod films;
mod gallery;
mod ghost;
mod hands;
mod launcher;
mod learning;
mod ledger;
mod left_films;
mod level_pictures;
mod live;
mod look;
mod memory;
mod nearby;
mod number_words;
mod pace;
mod panels;
mod pedal;
mod person;
mod player;
mod plot;
mod records;
mod references;
mod replay;
mod rows;
mod scope;
mod shortcut;
mod station;
mod steering;
#[cfg(test)]
mod tests;
mod text;
mod threads;
mod timeline;
mod training;
mod upkeep;
mod views;
mod work;

pub use copies::{Changes, LevelCopies};
pub use desk::{Opening, WindowError, open};
pub use films::{Film, Filmed, Films, Video};
pub use ghost::{GhostTool, Track};
pub use ledger::{
    Attempt, Change, ComparedRow, Comparison, CourseEntry, CourseLevel, CourseProgress, CourseStep,
    Debrief, Done, Job, Learning, Ledger, Participant, Percentile, Person, Role, Selection,
    StandingRow, StepState, Work,
};
pub use level_pictures::{LevelPictures, PictureFile};
pub use live::SHOWN;
pub use references::{Motion, ReadTrack, Reference, References};
pub use station::{
    Catalogue, Choice, Computation, LevelEntry, LiveSession, ModuleEntry, Recording, Station,
    ToolEntry, TraineeEntry,
};
