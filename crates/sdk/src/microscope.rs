//! The microscope over a level: what is in its field, and what it shows sharply.
//!
//! Here: geometry of the view, as the trainee has set it last. Not here: pictures (crate `render`), metrics (the module).

use crate::message::{MAGNIFIED_FIELD, MicroscopeView, depth_of_field};
use crate::{Fault, Tick};
use microsim_settings::View;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// The microscope as it is set now. Whatever a module saves of its state has to have it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Microscope {
    /// In the middle of the picture, in focus, field frame \[m\].
    centre: [f64; 3],
    /// Diameter of the round field \[m\].
    field: f64,
    /// By how much the line of sight leans from +z towards −y \[rad\].
    tilt: f64,
}

impl Microscope {
    /// As a level sets it.
    pub fn new(view: View) -> Self {
        Self {
            centre: view.centre,
            field: view.field,
            tilt: view.tilt,
        }
    }

    /// Follows the trainee: messages of the tick. The module subscribes to `microscope.view`.
    ///
    /// # Errors
    /// If a message cannot be read.
    pub fn update(&mut self, tick: &Tick<'_>) -> Result<(), Fault> {
        if let Some(MicroscopeView { centre, field }) = tick.latest()? {
            (self.centre, self.field) = (centre, field);
        }
        Ok(())
    }

    /// How many times larger the field is seen.
    pub fn magnification(&self) -> f64 {
        MAGNIFIED_FIELD / self.field
    }

    /// Whether a point of the field frame \[m\] lies in the round field, seen along the axis: the perspective of a lens at 250 mm moves what is 5 mm above the plane of focus by 2 % of
    /// its distance from the middle.
    pub fn shows(&self, point: [f64; 3]) -> bool {
        let [right, up, _] = self.in_view(point);
        libm::hypot(right, up) <= 0.5 * self.field
    }

    /// Whether a point of the field frame \[m\] is within the depth that is sharp, which pictures of high quality show as such.
    pub fn is_sharp(&self, point: [f64; 3]) -> bool {
        let [.., towards_eye] = self.in_view(point);
        towards_eye.abs() <= 0.5 * depth_of_field(self.field)
    }

    /// A point by its distances from the focus to the right, up in the picture and towards the eye \[m\].
    fn in_view(&self, point: [f64; 3]) -> [f64; 3] {
        let off = Vector3::from(point) - Vector3::from(self.centre);
        let (sin, cos) = libm::sincos(self.tilt);
        [off.x, off.y * cos + off.z * sin, off.z * cos - off.y * sin]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn microscope(tilt: f64) -> Microscope {
        Microscope::new(View {
            field: 0.02,
            centre: [1e-3, 0.0, 2e-3],
            tilt,
        })
    }

    /// A field of 20 mm reaches 10 mm from its middle; seen at 60° a length along y appears half as long, one along x as long as it is, one along the line of sight as a point.
    #[test]
    fn the_field_is_round_about_the_line_of_sight() {
        let above = microscope(0.0);
        assert!(above.shows([10.9e-3, 0.0, 5e-3]) && !above.shows([11.1e-3, 0.0, 2e-3]));
        let at_60 = microscope(60_f64.to_radians());
        assert!(at_60.shows([1e-3, 19.9e-3, 2e-3]) && !at_60.shows([1e-3, 20.1e-3, 2e-3]));
        let (sin, cos) = (libm::sin(60_f64.to_radians()), 0.5);
        let along = |length: f64| [1e-3, -length * sin, 2e-3 + length * cos];
        assert!(at_60.shows(along(0.05)), "it goes towards the eye");
    }

    /// By hand, at 10 times: 0.55 µm/(2 · 0.03²) + 0.34 mm/(0.03 · 10) = 0.3056 + 1.1333 mm, half of it to each side, along the line of sight; at 40 times 0.3056 + 0.2833 mm.
    #[test]
    fn what_is_sharp_gets_thinner_with_the_magnification() {
        let mut microscope = microscope(60_f64.to_radians());
        assert!((microscope.magnification() - 10.0).abs() < 1e-12);
        assert!((depth_of_field(microscope.field) - 1.4389e-3).abs() < 1e-7);
        let (sin, cos) = (libm::sin(60_f64.to_radians()), 0.5);
        let along = |length: f64| [5e-3, -length * sin, 2e-3 + length * cos];
        for side in [-1.0, 1.0] {
            assert!(microscope.is_sharp(along(side * 0.71e-3)));
            assert!(!microscope.is_sharp(along(side * 0.73e-3)));
        }
        microscope.field = 0.005;
        assert!((depth_of_field(microscope.field) - 0.5889e-3).abs() < 1e-7);
    }
}
