//! Ticks that wait for a peer: each sample counts in the tick in which its time lies, counted from the first one. A tick is complete once a sample
//! from behind it has come, or the peer has closed the connection. What a run gives then depends on the samples alone.

use crate::link::Link;
use microsim_sdk::message::{InputEnd, InputSample};
use microsim_sdk::{Fault, Tick};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Longest wait for a peer to begin.
const LONGEST_START: Duration = Duration::from_secs(60);
/// Between two looks.
const PAUSE: Duration = Duration::from_micros(200);

/// The samples that are not due yet.
#[derive(Debug)]
pub struct Paced {
    name: String,
    silence: Duration,
    waiting: VecDeque<InputSample>,
    has_begun: bool,
    has_ended: bool,
}

impl Paced {
    pub fn new(name: &str, silence: f64) -> Self {
        Self {
            name: name.to_owned(),
            silence: Duration::from_secs_f64(silence),
            waiting: VecDeque::new(),
            has_begun: false,
            has_ended: false,
        }
    }

    pub fn reset(&mut self) {
        *self = Self::new(&self.name, self.silence.as_secs_f64());
    }

    /// Publishes what is due by the end of the tick, and the end of the input with the last of it.
    pub fn process(&mut self, link: &Link, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let end = tick.time();
        let start = Instant::now();
        let mut is_over = self.has_ended;
        while !is_over
            && self
                .waiting
                .back()
                .is_none_or(|last| last.device_time <= end)
        {
            let mut arrived = link.take();
            arrived.log(tick);
            let has_come = !arrived.samples.is_empty();
            self.has_begun |= has_come;
            self.waiting
                .extend(arrived.samples.into_iter().map(|(_, sample)| sample));
            is_over = arrived.ended && !has_come;
            if has_come || is_over {
                continue;
            }
            // A connection that is silent for longer is closed, which is the end.
            let longest = match self.has_begun {
                true => 2 * self.silence + Duration::from_secs(1),
                false => LONGEST_START,
            };
            if start.elapsed() > longest {
                let what = match self.has_begun {
                    true => "the peer whose clock decides has stopped sending",
                    false => "no sample came within a minute, and the clock of the peer decides",
                };
                return Err(Fault::new(what));
            }
            std::thread::sleep(PAUSE);
        }
        while self
            .waiting
            .front()
            .is_some_and(|next| next.device_time <= end)
        {
            if let Some(sample) = self.waiting.pop_front() {
                tick.publish(&sample);
            }
        }
        if is_over && self.waiting.is_empty() && !self.has_ended {
            self.has_ended = true;
            tick.publish(&InputEnd {
                source: self.name.clone(),
            });
        }
        Ok(())
    }
}
