//! A scripted trainee: per device a list of timed poses, and samples of the motion through them.
//!
//! A script moves devices, as a tracker reports them; with the identity mapping of the translator its device frame is
//! the field frame. Errors of a hand are not part of it (see [`crate::Trainee`]).
//!
//! Between two keyframes the position moves straight, by default with minimum jerk (Flash & Hogan 1985), the speed
//! profile of a human reach: s(τ) = 10τ³ − 15τ⁴ + 6τ⁵, which rests at both ends, with neither speed nor acceleration.
//! The orientation turns by slerp at the same s, the opening changes linearly with τ.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use microsim_vocabulary::Interpolation;

use crate::QuaternionError;
use crate::rotation::{checked_unit, slerp};
use microsim_message::InputSample;

/// A pose at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// When the pose is reached `[s]`, from 0 for the start of the session.
    pub time_s: f64,
    /// Position in the device frame `[m]`.
    pub position: [f64; 3],
    /// `device_from_body`: unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// 0 closed to 1 open.
    pub opening: f64,
    /// Whether the device is seen from this keyframe until the next.
    pub visible: bool,
}

/// The keyframes of one device.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptTrack {
    /// Name of the device.
    pub device: Arc<str>,
    /// At least one; each later than the one before.
    pub keyframes: Vec<Keyframe>,
}

/// A checked script.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    tracks: Vec<ScriptTrack>,
    interpolation: Interpolation,
}

/// Why tracks are not a script.
#[derive(Clone, Debug, PartialEq)]
pub struct ScriptError {
    /// The device.
    pub device: String,
    /// Index of the keyframe, from 0; `None` if the whole track is meant.
    pub keyframe: Option<usize>,
    /// What is wrong.
    pub problem: ScriptProblem,
}

/// What is wrong in a script.
#[derive(Clone, Debug, PartialEq)]
pub enum ScriptProblem {
    /// The track has no keyframe.
    Empty,
    /// The device has a track already.
    DuplicateDevice,
    /// The time is not a finite number from 0 on `[s]`.
    Time(f64),
    /// The keyframe does not come after the one before.
    TimeNotIncreasing {
        /// Time of the keyframe before `[s]`.
        before_s: f64,
        /// Time of this keyframe `[s]`.
        found_s: f64,
    },
    /// The position is not finite.
    Position,
    /// The orientation is none.
    Orientation(QuaternionError),
    /// The opening is not within 0 to 1.
    Opening(f64),
}

impl Script {
    /// Checks tracks and takes them as a script.
    ///
    /// # Errors
    /// [`ScriptError`] for the first keyframe that breaks a rule of [`Keyframe`] or [`ScriptTrack`].
    pub fn new(
        mut tracks: Vec<ScriptTrack>,
        interpolation: Interpolation,
    ) -> Result<Self, ScriptError> {
        for index in 0..tracks.len() {
            let (earlier, rest) = tracks.split_at_mut(index);
            let track = &mut rest[0];
            let error = |keyframe, problem| ScriptError {
                device: track.device.to_string(),
                keyframe,
                problem,
            };
            if earlier.iter().any(|other| other.device == track.device) {
                return Err(error(None, ScriptProblem::DuplicateDevice));
            }
            if track.keyframes.is_empty() {
                return Err(error(None, ScriptProblem::Empty));
            }
            let mut before_s = None;
            for (index, keyframe) in track.keyframes.iter_mut().enumerate() {
                check(keyframe, before_s).map_err(|problem| error(Some(index), problem))?;
                before_s = Some(keyframe.time_s);
            }
        }
        Ok(Self {
            tracks,
            interpolation,
        })
    }

    /// The tracks.
    pub fn tracks(&self) -> &[ScriptTrack] {
        &self.tracks
    }

    /// The devices, in the order of the tracks.
    pub fn devices(&self) -> impl Iterator<Item = &Arc<str>> {
        self.tracks.iter().map(|track| &track.device)
    }

    /// Time of the last keyframe `[s]`.
    pub fn duration(&self) -> f64 {
        self.tracks
            .iter()
            .filter_map(|track| track.keyframes.last())
            .map(|keyframe| keyframe.time_s)
            .fold(0.0, f64::max)
    }

    /// The sample of a device at time `t` `[s]`; `None` for a device that the script does not have.
    ///
    /// Before its first keyframe a device is not visible; after its last it stays there.
    pub fn sample(&self, device: &str, t: f64) -> Option<InputSample> {
        let track = self.tracks.iter().find(|track| &*track.device == device)?;
        Some(self.sample_of(track, t))
    }

    /// Samples at `rate_hz` `[1/s]` from time 0 on, the last one at or just after the end; at each time one of every
    /// device, in the order of the tracks.
    ///
    /// # Panics
    /// If the rate is not a finite positive number.
    pub fn samples(&self, rate_hz: f64) -> impl Iterator<Item = InputSample> {
        assert!(
            rate_hz.is_finite() && rate_hz > 0.0,
            "a script cannot be sampled at {rate_hz} Hz"
        );
        let last = (self.duration() * rate_hz).ceil() as u64;
        (0..=last).flat_map(move |index| {
            let t = index as f64 / rate_hz;
            self.tracks
                .iter()
                .map(move |track| self.sample_of(track, t))
        })
    }

    fn sample_of(&self, track: &ScriptTrack, t: f64) -> InputSample {
        let mut sample = InputSample::not_visible(&track.device, t);
        let reached = track
            .keyframes
            .partition_point(|keyframe| keyframe.time_s <= t);
        let Some(index) = reached.checked_sub(1) else {
            return sample;
        };
        let from = &track.keyframes[index];
        sample.visible = from.visible;
        match track.keyframes.get(reached) {
            Some(to) if t > from.time_s => {
                let fraction = (t - from.time_s) / (to.time_s - from.time_s);
                let reached = match self.interpolation {
                    Interpolation::MinimumJerk => minimum_jerk(fraction),
                    Interpolation::Linear => fraction,
                };
                sample.pose.position =
                    std::array::from_fn(|i| mix(from.position[i], to.position[i], reached));
                sample.pose.orientation = slerp(from.orientation, to.orientation, reached);
                sample.opening = Some(mix(from.opening, to.opening, fraction));
            }
            _ => {
                sample.pose.position = from.position;
                sample.pose.orientation = from.orientation;
                sample.opening = Some(from.opening);
            }
        }
        sample
    }
}

/// Checks one keyframe that follows another at `before_s`, and scales its orientation to norm 1.
fn check(keyframe: &mut Keyframe, before_s: Option<f64>) -> Result<(), ScriptProblem> {
    let is_time = |value: f64| value.is_finite() && value >= 0.0;
    if !is_time(keyframe.time_s) {
        return Err(ScriptProblem::Time(keyframe.time_s));
    }
    if let Some(before_s) = before_s
        && keyframe.time_s <= before_s
    {
        return Err(ScriptProblem::TimeNotIncreasing {
            before_s,
            found_s: keyframe.time_s,
        });
    }
    if !keyframe
        .position
        .iter()
        .all(|component| component.is_finite())
    {
        return Err(ScriptProblem::Position);
    }
    if !(0.0..=1.0).contains(&keyframe.opening) {
        return Err(ScriptProblem::Opening(keyframe.opening));
    }
    keyframe.orientation =
        checked_unit(keyframe.orientation).map_err(ScriptProblem::Orientation)?;
    Ok(())
}

/// Fraction of the displacement after a fraction `tau` of the time, for a reach with minimum jerk from rest to rest (Flash & Hogan
/// 1985): 10τ³ − 15τ⁴ + 6τ⁵.
pub(crate) fn minimum_jerk(tau: f64) -> f64 {
    tau * tau * tau * (10.0 + tau * (6.0 * tau - 15.0))
}

/// In this form what does not change stays the same to the last bit.
pub(crate) fn mix(from: f64, to: f64, fraction: f64) -> f64 {
    from + fraction * (to - from)
}

impl fmt::Display for ScriptError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "device \"{}\"", self.device)?;
        if let Some(keyframe) = self.keyframe {
            write!(f, ", keyframe {keyframe} (the first is 0)")?;
        }
        write!(f, ": {}", self.problem)
    }
}

impl Error for ScriptError {}

impl fmt::Display for ScriptProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "expected at least one keyframe"),
            Self::DuplicateDevice => write!(f, "it has two tracks, expected one"),
            Self::Time(time) => write!(f, "time is {time} s, expected a finite number from 0 on"),
            Self::TimeNotIncreasing { before_s, found_s } => write!(
                f,
                "time {found_s} s does not come after {before_s} s, that of the keyframe before"
            ),
            Self::Position => write!(f, "position is not finite"),
            Self::Orientation(error) => write!(f, "{error}"),
            Self::Opening(opening) => {
                write!(f, "opening is {opening}, expected 0 (closed) to 1 (open)")
            }
        }
    }
}

#[cfg(test)]
mod tests;
