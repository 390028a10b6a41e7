//! Trackers that speak OpenIGTLink as an input source. Threads of its own wait for bytes (module `link`); what comes is turned into samples (module `conversation`), which
//! the next tick publishes. The codec is the crate `igtl`.
//!
//! A sample has the tracker's time, or that of its arrival where the tracker sends none; the tick in which it is published is recorded with it. What comes live cannot be taken up again from a
//! checkpoint; a recorded session replays without this plugin.

#![forbid(unsafe_code)]

mod conversation;
mod link;

use link::Link;
use microsim_sdk::{Fault, LogLevel, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::OpenIgtLink;

/// Samples of trackers.
#[derive(Debug, Default)]
pub struct TrackerSource {
    link: Option<Link>,
}

impl Plugin for TrackerSource {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: OpenIgtLink = setup.configuration()?;
        self.link = Some(Link::open(config).map_err(Fault::new)?);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        if let Some(link) = &self.link {
            link.take();
        }
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let Some(link) = &self.link else {
            return Err(Fault::new("not initialised"));
        };
        let arrived = link.take();
        for (is_warning, note) in arrived.notes {
            let level = match is_warning {
                true => LogLevel::Warn,
                false => LogLevel::Info,
            };
            tick.log(level, note);
        }
        for sample in &arrived.samples {
            tick.publish(sample);
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    fn restore(&mut self, _: &[u8]) -> Result<(), Fault> {
        Err(Fault::new("what comes live cannot be taken up again"))
    }

    fn stop(&mut self) -> Result<(), Fault> {
        match self.link.take().map(Link::close) {
            None | Some(true) => Ok(()),
            Some(false) => Err(Fault::new("a thread of the connection panicked")),
        }
    }
}

export_plugin!(TrackerSource, "../plugin.toml");
