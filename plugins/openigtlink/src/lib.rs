//! Trackers that speak OpenIGTLink as an input source. Threads of its own wait for bytes (module `link`); what comes is turned into samples (module `conversation`), which
//! the next tick publishes. The codec is the crate `igtl`.
//!
//! With `clock = "device"` the peer's clock decides in which tick a sample counts (module `paced`): the same motion then gives the same run, however long its bytes take.
//!
//! A sample has the tracker's time, or that of its arrival where the tracker sends none; the tick in which it is published is recorded with it. What comes live cannot be taken up again from a
//! checkpoint; a recorded session replays without this plugin.

#![forbid(unsafe_code)]

mod conversation;
mod link;
mod paced;

use link::Link;
use microsim_sdk::message::InputTiming;
use microsim_sdk::{Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::{LinkClock, OpenIgtLink};
use paced::Paced;
use std::time::Instant;

/// Samples of trackers.
#[derive(Debug, Default)]
pub struct TrackerSource {
    link: Option<Link>,
    /// Where the clock of the peer decides.
    paced: Option<Paced>,
}

impl Plugin for TrackerSource {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: OpenIgtLink = setup.configuration()?;
        let silence = config.silence;
        self.paced = (config.clock == LinkClock::Device).then(|| Paced::new(&setup.name, silence));
        self.link = Some(Link::open(config).map_err(Fault::new)?);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        if let Some(link) = &self.link {
            link.take();
        }
        if let Some(paced) = &mut self.paced {
            paced.reset();
        }
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let Some(link) = &self.link else {
            return Err(Fault::new("not initialised"));
        };
        if let Some(paced) = &mut self.paced {
            return paced.process(link, tick);
        }
        let mut arrived = link.take();
        arrived.log(tick);
        if !arrived.samples.is_empty() || arrived.dropped > 0 {
            let now = Instant::now();
            let wait = |at: &Instant| now.saturating_duration_since(*at).as_secs_f64();
            tick.publish(&InputTiming {
                waits: arrived.samples.iter().map(|(at, _)| wait(at)).collect(),
                dropped: arrived.dropped,
            });
        }
        for (_, sample) in &arrived.samples {
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
