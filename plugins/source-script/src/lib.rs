//! A scripted trainee as an input source: thin over `tracking::Script`.

#![forbid(unsafe_code)]

use microsim_sdk::message::InputSample;
use microsim_sdk::{Fault, Playback, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::{Script, ScriptConfig};

/// Plays a script.
#[derive(Debug, Default)]
pub struct ScriptSource {
    playback: Playback,
}

fn samples(script: &Script) -> Result<Vec<InputSample>, Fault> {
    let played = script.motion();
    let played = played.map_err(|error| Fault::new(format!("the script: {error}")))?;
    Ok(played.samples(script.rate).collect())
}

impl Plugin for ScriptSource {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: ScriptConfig = setup.configuration()?;
        self.playback = Playback::by_device_time(&setup.name, samples(&config.script)?);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.playback.reset();
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        self.playback.play(tick);
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        self.playback.save()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        self.playback.restore(state)
    }
}

export_plugin!(ScriptSource, "../plugin.toml");
