//! From a script as its file says it.

use super::{Interpolation, Keyframe, Script, ScriptError, ScriptTrack};
use microsim_settings as settings;

impl Script {
    /// The script of a file.
    ///
    /// # Errors
    /// [`ScriptError`] where keyframes do not make a motion; what a checked file says does.
    pub fn from_settings(script: &settings::Script) -> Result<Self, ScriptError> {
        let tracks = script.tool.iter().map(|tool| ScriptTrack {
            device: tool.name.as_str().into(),
            keyframes: tool.key.iter().map(keyframe).collect(),
        });
        let interpolation = match script.interpolation {
            settings::Interpolation::MinimumJerk => Interpolation::MinimumJerk,
            settings::Interpolation::Linear => Interpolation::Linear,
        };
        Self::new(tracks.collect(), interpolation)
    }
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
