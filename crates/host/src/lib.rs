//! The host: loading, life cycle, clocks, containment of faults, record and replay. It knows no physics and no GPU.
//!
//! - [`plan`]: what a run loads and computes, and why; decided first.
//! - [`installation`]: plugins, modules and levels below a folder.
//! - [`assemble`]: makes a plan from a module, a level and an input (`input`: what its source is given).
//! - [`loader`]: objects of plugins, from libraries that are checked before their code runs.
//! - [`guest`]: plugins in a process of their own.
//! - [`engine`]: the deterministic loop and its running hash.
//! - [`listen`]: a source alone, without a module.
//! - [`run`]: a run at the edge: wall clock, controls, recording, pictures.
//! - [`record`], [`replay`]: what stands in a session, and recomputing it.
//! - [`playback`]: the same, forth and back, for a viewer.

#![allow(
    unsafe_code,
    reason = "the parallel loop is called through a C function"
)]

pub mod assemble;
mod assets;
pub mod engine;
mod error;
pub mod fault;
pub mod guest;
mod input;
pub mod installation;
mod installed;
mod library;
pub mod listen;
pub mod loader;
pub mod parallel;
pub mod picture;
pub mod plan;
pub mod playback;
pub mod record;
mod recorder;
pub mod replay;
pub mod request;
pub mod run;
mod span;
mod subscriptions;

pub use engine::{Checkpoint, Engine, Feed};
pub use fault::Failure;
