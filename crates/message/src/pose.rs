//! Poses as plain data.

use serde::{Deserialize, Serialize};

/// Position \[m\] and orientation (unit quaternion x, y, z, w) in a frame that the field's name or doc states.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position \[m\].
    pub position: [f64; 3],
    /// Orientation: unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

impl Default for Pose {
    fn default() -> Self {
        Self {
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
        }
    }
}
