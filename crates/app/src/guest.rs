//! `microsim guest`: the process of a plugin that the installation did not bring.

use crate::output::{Exit, Problem};
use crate::run::ENDING;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Serves the run that has started this process.
pub fn guest() -> Result<Exit, Problem> {
    // They are for the run, which ends its guests in its own order.
    let ignored = Arc::new(AtomicBool::new(false));
    for signal in ENDING {
        signal_hook::flag::register(signal, Arc::clone(&ignored))?;
    }
    microsim_host::guest::serve()?;
    Ok(Exit::Done)
}
