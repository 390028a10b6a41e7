//! The microscope, as the trainee sets it.

use crate::wire::Message;
use microsim_vocabulary::{MICROSCOPE_VIEW, Overflow};
use serde::{Deserialize, Serialize};

/// Magnification times diameter of the field \[m\]: 38, 25 and 17 mm at 5.3, 8 and 12 times (DOMAIN, section 2).
pub const MAGNIFIED_FIELD: f64 = 0.2;

/// Wavelength of green light \[m\].
const WAVELENGTH: f64 = 0.55e-6;
/// Numerical aperture of one path of light: a beam of 15 mm through a main lens of 250 mm. A judgement: both beams lie 22 to 25 mm apart (DOMAIN, section 2), and have to be narrower.
const APERTURE: f64 = 7.5 / 250.0;
/// What an eye resolves at the distance of distinct vision, 0.00136 rad at 250 mm \[m\].
const RESOLVED: f64 = 0.34e-3;

/// Depth that is sharp at once in a round field of this diameter \[m\], by Berek's formula λ/(2 NA²) + 0.34 mm/(NA V) (Berek 1927): diffraction, and what the eye resolves at the
/// magnification V.
pub fn depth_of_field(field: f64) -> f64 {
    let magnification = MAGNIFIED_FIELD / field;
    0.5 * WAVELENGTH / (APERTURE * APERTURE) + RESOLVED / (APERTURE * magnification)
}

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
