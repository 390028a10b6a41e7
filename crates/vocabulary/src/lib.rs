//! The closed sets of names that files, messages, reports and the numerics have in common, each with its meaning, and the
//! units of quantities.
//!
//! A set is declared once, by [`terms!`]: an enum whose variants carry the name that files and messages write and a
//! sentence of documentation. Reading, writing, lists of choices and schemas all come from that declaration ([`Term`]).
//! What is not here: anything that computes, and any term that a single crate uses.

#![forbid(unsafe_code)]

mod mechanics;
mod platform;
mod results;
mod term;
mod text;
mod unit;

pub use mechanics::{CellSplit, Discretisation, Filling, LawName, MethodName, Remedy};
pub use platform::{
    DebugView, EyeLayout, Finish, Interpolation, MICROSCOPE_VIEW, MotionLimit, Overflow, PedalKey,
    PictureQuality, PluginKind, ToolStatus,
};
pub use results::{Category, Direction};
pub use term::{Term, UnknownTerm};
pub use text::{Language, LocalText};
pub use unit::{QuantityError, Unit};
