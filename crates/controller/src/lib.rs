//! Gamepads and SpaceMice: what whoever holds one asks of an instrument.
//!
//! - `code`: numbers that the kernel has for axes and buttons; `event`: its records from bytes.
//! - `range`: raw values of axes as deflections; `response`: the dead zone, and how fast a motion is beyond it.
//! - `device`: what a device is, by what it has; `layout`: which of its axes and buttons do what.
//! - `report`: the records of a device as states that hold until the next one.
//! - `motion`: what states ask for over time, whoever asks how often for it.
//! - `capabilities`: what the system publishes of a device; `probe`: the ranges and values of its axes.
//! - `controllers`: the devices that are there, each read in a thread of its own.
//!
//! All but the last two are pure. Not here: instruments, the field of the microscope, pictures.

#![allow(
    unsafe_code,
    reason = "in `probe`: the kernel writes into memory whose address it is given; a crate that does so would bring seven others"
)]

mod capabilities;
mod code;
mod controllers;
mod device;
mod event;
mod layout;
mod motion;
mod probe;
mod range;
mod report;
mod response;

pub use controllers::{Controllers, Presence, Seen};
pub use device::Kind;
pub use layout::Press;
pub use motion::Motion;
