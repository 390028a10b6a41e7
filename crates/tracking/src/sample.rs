//! One reading of one device.

use std::sync::Arc;

/// One measurement of a device, in its own frame and by its own clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The device's name (shared, because a recording has a million samples of few devices).
    pub device: Arc<str>,
    /// Time of the measurement by the device's clock `[s]`.
    pub time_s: f64,
    /// Whether the device was seen. If not, position, orientation and opening mean nothing.
    pub visible: bool,
    /// Position in the device frame `[m]`.
    pub position: [f64; 3],
    /// `device_from_body`: unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
    /// How far the handle is open, 0 closed to 1 open; `None` if the device does not measure it.
    pub opening: Option<f64>,
}

impl Sample {
    /// The sample of a device that was not seen at `time_s` `[s]`.
    pub fn not_visible(device: Arc<str>, time_s: f64) -> Self {
        Self {
            device,
            time_s,
            visible: false,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            opening: None,
        }
    }
}
