//! What the connection notes, in the log of the host.

use crate::link::Queue;
use microsim_sdk::{LogLevel, Tick};

/// Hands notes to the log.
pub fn log(tick: &mut Tick<'_>, queue: &mut Queue) {
    for (is_warning, note) in queue.notes.drain(..) {
        let level = match is_warning {
            true => LogLevel::Warn,
            false => LogLevel::Info,
        };
        tick.log(level, note);
    }
}
