//! The store: trainees, groups, courses, sessions and results in one embedded SQLite file; the only SQL of the workspace.
//!
//! Plain values go in and come out. Not here: reading session files, printing, clocks and randomness; times and ids are the caller's.
//!
//! - [`Store`]: the file. Write-ahead log, `synchronous = FULL`, foreign keys, one transaction for each change, waiting for other processes for
//!   at most ten seconds. [`VERSION`] is that of the tables: earlier ones are migrated in one transaction beside a copy, later ones refused.
//! - [`Trainee`], [`Course`], [`Session`], [`PopulationRecord`]: what is in it. [`Filter`] finds sessions, [`Progress`] is how far somebody is.
//! - [`Document`]: all of it, for export and import, also of a damaged file as far as it can be read.
//! - [`StoreError`]: what can be wrong with a store, each by its kind.
//!
//! # Names
//! Sessions hold the [`Id`] of a trainee, 128 random bits; the name stands in the store alone, is the same for no two trainees, and may be any text that
//! is not blank and not an id. Names are shown and exported by others, who make them harmless there.
//!
//! # Roles
//! [`Role`] is a label for lists. There are no passwords, and whoever can write the file can do all of it, so no command asks for a role.
//!
//! # What a session and its result are
//! One row, as there is one of each. When a run ended by the wall clock does not stand in its session, so it is not in the store: everything of a
//! session can be read again from its file ([`Store::rebuild`]), but for pictures and checkpoints that lie elsewhere. A run notes itself before it
//! begins ([`Pending`]), so that one that was killed between the end of its session and its entry is entered by the next command.
//!
//! # What stays after an erasure
//! Rows are overwritten in the file (`secure_delete`) and the log is emptied. Exports that were made before, backups and copies of earlier versions
//! ([`Store::copies`]) are files of their own.

#![forbid(unsafe_code)]

mod course;
mod document;
mod erase;
mod error;
mod export;
mod group;
mod id;
mod near;
mod population;
mod query;
mod rows;
mod salvage;
mod schema;
mod session;
mod store;
mod trainee;

pub use course::{Course, Enrolled, Progress, Step, StepProgress};
pub use document::{
    CourseEntry, DOCUMENT_FORMAT, Document, Group, Imported, SessionEntry, Unlocked,
};
pub use erase::Erasure;
pub use error::StoreError;
pub use id::Id;
pub use population::PopulationRecord;
pub use query::{Filter, NamedSession};
pub use schema::VERSION;
pub use session::{Measured, Metric, Pending, Session, Verdict};
pub use store::Store;
pub use trainee::{Found, ListedTrainee, Role, Trainee};
