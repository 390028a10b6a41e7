//! What input sources publish: samples in the device's own frame.

use crate::pose::Pose;
use crate::wire::Message;
use microsim_vocabulary::MotionLimit;
use serde::{Deserialize, Serialize};

/// One sample of one tracked instrument. An external input: recorded, and fed by tick when a session is replayed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputSample {
    /// Name of the device, as the source gives it.
    pub device: String,
    /// The device's own clock \[s\].
    pub device_time: f64,
    /// Whether the device sees the instrument now; if not, the pose means nothing.
    pub visible: bool,
    /// Pose in the device's frame.
    pub pose: Pose,
    /// Opening, 0 closed … 1 open; `None` for a device that does not measure it.
    pub opening: Option<f64>,
}

impl InputSample {
    /// The sample of a device that does not see the instrument at `device_time` \[s\].
    pub fn not_visible(device: &str, device_time: f64) -> Self {
        Self {
            device: device.to_owned(),
            device_time,
            visible: false,
            pose: Pose::default(),
            opening: None,
        }
    }
}

impl Message for InputSample {
    const KIND: &'static str = "input.sample";
}

/// A sample that no hand makes: published by the translator, which leaves it out. For those who record; the tool that it would have moved
/// is not tracked at its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImplausibleSample {
    /// Tool slot of the level.
    pub tool: String,
    /// Name of the device.
    pub device: String,
    /// Time of the sample by the device's clock \[s\].
    pub device_time: f64,
    /// What of its motion is beyond the limits of a hand; of a sample that goes on from another one that was left out, what that one was.
    pub limit: MotionLimit,
    /// The value, in the limit's unit.
    pub value: f64,
    /// The limit itself, in the same unit.
    pub bound: f64,
}

impl Message for ImplausibleSample {
    const KIND: &'static str = "input.implausible";
}

/// How long the samples of a tick had waited in a live source, and what it had to drop: measured by the clock of this machine, so no two runs have the same.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InputTiming {
    /// From the arrival of each sample to the tick that publishes it \[s\].
    pub waits: Vec<f64>,
    /// Samples that found no place in the queue since the last tick.
    pub dropped: u64,
}

impl Message for InputTiming {
    const KIND: &'static str = "input.timing";
}

/// What the markers of an instrument have shown at one time. Published by the translator where instruments with markers are configured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MarkerTracking {
    /// The device that the markers make up.
    pub device: String,
    /// Time of the markers by the device's clock \[s\].
    pub device_time: f64,
    /// Root mean square residual of the fit \[m\]; `None` where there is no pose.
    pub residual: Option<f64>,
    /// Markers that are not seen.
    pub missing: u32,
    /// Markers that are seen as one point with another.
    pub merged: u32,
    /// Points that have the name of another marker.
    pub permuted: u32,
    /// Points that are no marker.
    pub unknown: u32,
    /// Why there is no pose, one sentence.
    pub loss: Option<String>,
}

impl Message for MarkerTracking {
    const KIND: &'static str = "input.markers";
}

/// What mouse, keyboard and controllers ask of one tool, since the last such message of it. Published by the host for the window in front of which the trainee sits,
/// and an external input: recorded, and fed by tick when a session is replayed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DesktopInput {
    /// Tool slot of the level.
    pub tool: String,
    /// By how much its tip is to move in the field frame \[m\].
    pub shift: [f64; 3],
    /// By how much it is to turn: azimuth and elevation of its handle, roll about its shaft \[rad\].
    pub turn: [f64; 3],
    /// The opening that it is to have from now on, 0 closed … 1 open; `None` leaves what was asked before.
    pub opening: Option<f64>,
}

impl Message for DesktopInput {
    const KIND: &'static str = "input.desktop";
}

/// A source has nothing more to give.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputEnd {
    /// Name of the source plugin.
    pub source: String,
}

impl Message for InputEnd {
    const KIND: &'static str = "input.end";
}
