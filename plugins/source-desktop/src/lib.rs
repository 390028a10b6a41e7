//! Mouse and keyboard as an input source: thin over `tracking::DesktopHand`. The window asks for motions of each tool; every tick has a sample of each.

#![forbid(unsafe_code)]

use microsim_sdk::message::{DesktopInput, decode_bytes, encode};
use microsim_sdk::{Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::DesktopConfig;
use microsim_tracking::{DesktopHand, DesktopHandState};

/// The hands at mouse and keyboard.
#[derive(Debug, Default)]
pub struct DesktopSource {
    hands: Vec<DesktopHand>,
}

impl Plugin for DesktopSource {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: DesktopConfig = setup.configuration()?;
        self.hands = config.hands();
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.hands.iter_mut().for_each(DesktopHand::reset);
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        for input in tick.messages::<DesktopInput>()? {
            let hand = self.hands.iter_mut().find(|hand| hand.tool() == input.tool);
            if let Some(hand) = hand {
                hand.ask(&input);
            }
        }
        let (dt, now) = (tick.length(), tick.time());
        for hand in &mut self.hands {
            let sample = hand.advance(dt, now);
            tick.publish(&sample);
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        let states: Vec<DesktopHandState> = self.hands.iter().map(DesktopHand::state).collect();
        encode(&states)
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), Fault> {
        let states: Vec<DesktopHandState> = decode_bytes(saved)?;
        if states.len() != self.hands.len() {
            return Err(Fault::new("the saved state has other tools"));
        }
        for (hand, state) in self.hands.iter_mut().zip(states) {
            hand.restore(state);
        }
        Ok(())
    }
}

export_plugin!(DesktopSource, "../plugin.toml");
