//! A scripted trainee as an input source: thin over `tracking::Script`.

use microsim_sdk::message::{InputEnd, InputSample, Pose, decode_bytes, encode};
use microsim_sdk::{Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings as settings;
use microsim_tracking::{Interpolation, Keyframe, Playback, Sample, Script, ScriptTrack};
use serde::Deserialize;

/// The script, checked and in SI units.
#[derive(Debug, Deserialize)]
struct Config {
    script: settings::Script,
}

/// Plays a script.
#[derive(Debug, Default)]
pub struct ScriptSource {
    name: String,
    playback: Playback,
    ended: bool,
}

fn samples(script: &settings::Script) -> Result<Vec<Sample>, Fault> {
    let tracks = script.tool.iter().map(|tool| ScriptTrack {
        device: tool.name.as_str().into(),
        keyframes: tool.key.iter().map(keyframe).collect(),
    });
    let interpolation = match script.interpolation {
        settings::Interpolation::MinimumJerk => Interpolation::MinimumJerk,
        settings::Interpolation::Linear => Interpolation::Linear,
    };
    let played = Script::new(tracks.collect(), interpolation);
    let played = played.map_err(|error| Fault::new(format!("the script: {error}")))?;
    Ok(played.samples(script.rate).collect())
}

fn keyframe(key: &settings::ScriptKey) -> Keyframe {
    Keyframe {
        time_s: key.t,
        hold_s: 0.0,
        position: key.position,
        orientation: key.orientation,
        opening: key.opening,
        visible: key.visible,
    }
}

impl Plugin for ScriptSource {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: Config = serde_json::from_value(setup.config.clone())?;
        self.name = setup.name.clone();
        self.playback = Playback::new(samples(&config.script)?);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.playback.seek(0);
        self.ended = false;
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        for sample in self.playback.due(tick.time()) {
            tick.publish(&InputSample {
                device: sample.device.to_string(),
                device_time: sample.time_s,
                visible: sample.visible,
                pose: Pose {
                    position: sample.position,
                    orientation: sample.orientation,
                },
                opening: sample.opening,
            });
        }
        if self.playback.is_over() && !self.ended {
            self.ended = true;
            tick.publish(&InputEnd {
                source: self.name.clone(),
            });
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.playback.position(), self.ended))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (position, ended) = decode_bytes(state)?;
        self.playback.seek(position);
        self.ended = ended;
        Ok(())
    }
}

export_plugin!(ScriptSource, "../plugin.toml");
