//! The microscope: magnification and the place in the middle, by keys.

use eframe::egui::{Event, InputState, Key};
use microsim_message::{MAGNIFIED_FIELD, MicroscopeView};
use microsim_settings::View;

/// Least and most magnification of surgical microscopes (DOMAIN, section 2).
const RANGE: [f64; 2] = [4.0, 40.0];
/// What a press of a key multiplies the magnification with.
const STEP: f64 = 1.25;
/// What a press of a key shifts the plane of focus by, in diameters of the field.
const FOCUS: f64 = 0.02;
/// Keys that shift the middle, to the right and up \[diameters of the field\].
const SHIFTS: [(Key, [f64; 2]); 4] = [
    (Key::L, [0.05, 0.0]),
    (Key::J, [-0.05, 0.0]),
    (Key::I, [0.0, 0.05]),
    (Key::K, [0.0, -0.05]),
];

/// The microscope over a level.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    of_level: View,
    view: View,
    /// Whether right and left are exchanged in the picture.
    mirrored: bool,
}

impl Scope {
    /// As the level sets it.
    pub fn new(of_level: View, mirrored: bool) -> Self {
        Self {
            of_level,
            view: of_level,
            mirrored,
        }
    }

    /// What it shows.
    pub fn view(&self) -> View {
        self.view
    }

    /// How many times larger it shows it.
    pub fn magnification(&self) -> f64 {
        self.message().magnification()
    }

    fn message(&self) -> MicroscopeView {
        MicroscopeView {
            centre: self.view.centre,
            field: self.view.field,
        }
    }

    /// Sets it as the keys ask; what is to be recorded, if they ask for anything.
    pub fn set(&mut self, input: &InputState) -> Option<MicroscopeView> {
        let before = self.view;
        for event in &input.events {
            if let Event::Key {
                key, pressed: true, ..
            } = event
            {
                self.press(*key);
            }
        }
        (self.view != before).then(|| self.message())
    }

    /// Multiplies the magnification, within what microscopes have.
    pub fn magnify(&mut self, by: f64) {
        let [least, most] = RANGE;
        let magnification = (MAGNIFIED_FIELD / self.view.field * by).clamp(least, most);
        self.view.field = MAGNIFIED_FIELD / magnification;
    }

    /// Shifts the middle by parts of the field, to the right and up in the picture.
    pub fn shift(&mut self, by: [f64; 2]) {
        let [right, up] = by;
        let along_x = if self.mirrored { -right } else { right };
        self.view.centre[0] += along_x * self.view.field;
        self.view.centre[1] += up * self.view.field;
    }

    /// Raises the plane of focus towards the eye, by a part of the field.
    fn focus(&mut self, by: f64) {
        // The eye leans from +z towards −y.
        let (sin, cos) = (libm::sin(self.view.tilt), libm::cos(self.view.tilt));
        self.view.centre[1] -= by * self.view.field * sin;
        self.view.centre[2] += by * self.view.field * cos;
    }

    /// Sets it as a key asks.
    pub fn press(&mut self, key: Key) {
        match key {
            Key::Plus | Key::Equals => self.magnify(STEP),
            Key::Minus => self.magnify(1.0 / STEP),
            Key::U => self.focus(FOCUS),
            Key::O => self.focus(-FOCUS),
            Key::Num0 | Key::Home => self.view = self.of_level,
            key => {
                if let Some((_, by)) = SHIFTS.iter().find(|(of, _)| *of == key) {
                    self.shift(*by);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 25 mm are seen eight times larger (DOMAIN, section 2); keys stay within what microscopes have, and one of them leads back.
    #[test]
    fn keys_set_the_microscope_within_its_range() {
        let of_level = View {
            field: 0.025,
            centre: [0.0, 1e-3, 0.0],
            tilt: 0.5,
        };
        let mut scope = Scope::new(of_level, false);
        assert!((scope.magnification() - 8.0).abs() < 1e-12);
        scope.press(Key::Plus);
        scope.press(Key::L);
        assert!((scope.magnification() - 10.0).abs() < 1e-12);
        assert!(
            (scope.view().centre[0] - 1e-3).abs() < 1e-12,
            "a twentieth of 20 mm"
        );
        (0..20).for_each(|_| scope.press(Key::Plus));
        assert!((scope.magnification() - 40.0).abs() < 1e-9);
        (0..40).for_each(|_| scope.press(Key::Minus));
        assert!((scope.magnification() - 4.0).abs() < 1e-9);
        scope.press(Key::Home);
        assert_eq!(scope.view(), of_level);

        // A fiftieth of 25 mm along the line of sight.
        scope.press(Key::U);
        let raised = scope.view().centre;
        let along = (raised[1] - 1e-3).hypot(raised[2]);
        assert!((along - 5e-4).abs() < 1e-12 && raised[1] < 1e-3 && raised[2] > 0.0);
        scope.press(Key::O);
        assert!(scope.view().centre[2].abs() < 1e-12, "and back");

        // In a mirrored picture what lies to the right has a smaller x; up stays up.
        let mut scope = Scope::new(of_level, true);
        scope.press(Key::L);
        scope.press(Key::I);
        let [x, y, _] = scope.view().centre;
        assert!((x + 1.25e-3).abs() < 1e-12 && (y - 2.25e-3).abs() < 1e-12);
    }
}
