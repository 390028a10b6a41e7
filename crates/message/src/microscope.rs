//! The microscope, as the trainee sets it.

use crate::wire::Message;
use microsim_vocabulary::{MICROSCOPE_VIEW, Overflow};
use serde::{Deserialize, Serialize};

/// Magnification times diameter of the field \[m\]: 38, 25 and 17 mm at 5.3, 8 and 12 times (DOMAIN, section 2).
pub const MAGNIFIED_FIELD: f64 = 0.2;

/// Where the microscope looks from now on. Published by the host for the window when the trainee sets it otherwise than the level does, and an external
/// input: recorded, and fed by tick when a session is replayed. No motion of tissue or tools depends on it; a module may measure whether the trainee sees what is worked on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MicroscopeView {
    /// What lies in the middle, in the field frame \[m\].
    pub centre: [f64; 3],
    /// Diameter of the round field \[m\].
    pub field: f64,
}

impl MicroscopeView {
    /// How many times larger it is seen.
    pub fn magnification(&self) -> f64 {
        MAGNIFIED_FIELD / self.field
    }
}

impl Message for MicroscopeView {
    const KIND: &'static str = MICROSCOPE_VIEW;
    const OVERFLOW: Overflow = Overflow::DropOldest;
}
