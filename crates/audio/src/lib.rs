//! What a run is heard by: touch, cuts, tears, too much force.
//!
//! - `tone`: the tones, computed; no files.
//! - `cue`: which messages of a run have which tone.
//! - `mixer`: tones that are played at once, as samples.
//! - `player`: the samples to an audio server (PulseAudio, or PipeWire, which speaks its protocol).
//!
//! All but `player` are pure. Nothing in a run depends on any of it.

#![forbid(unsafe_code)]

mod cue;
mod mixer;
mod player;
mod tone;

pub use cue::Cues;
pub use mixer::Mixer;
pub use player::Player;
pub use tone::{RATE, Tone};
