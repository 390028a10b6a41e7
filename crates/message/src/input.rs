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

/// A source has nothing more to give.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputEnd {
    /// Name of the source plugin.
    pub source: String,
}

impl Message for InputEnd {
    const KIND: &'static str = "input.end";
}
