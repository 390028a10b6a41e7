//! `config/desktop.toml`: instruments that are moved by mouse and keyboard.

use crate::document::{Loaded, Reading, load_text};
use crate::error::ConfigErrors;
use crate::files::schema_of;
use crate::kinds::{quantity, ratio, time};
use crate::table::table;
use microsim_tracking::{DesktopHand, DesktopLimits, HandAngles};
use microsim_vocabulary::Unit;
use serde::{Deserialize, Serialize};
use std::path::Path;

table! {
    /// How mouse and keyboard move the tools. The tip follows the pointer as it moves in the picture, so that a field seen at twice the magnification takes twice
    /// the motion of the hand.
    #[derive(Copy)]
    pub struct Desktop {
        /// Fastest motion of a tip \[m/s\].
        speed: f64 = quantity(Unit::Speed, 1e-3, 0.5) => 0.08,
        /// Most acceleration of a tip \[m/s²\]; `hand` of config/translator.toml has the limit beyond which samples are left out.
        acceleration: f64 = quantity(Unit::Acceleration, 0.1, 8.0) => 4.0,
        /// By how much the tip is behind the pointer at a steady motion \[s\].
        lag: f64 = time(0.005, 0.5) => 0.04,
        /// Fastest turn \[rad/s\].
        turn_rate: f64 = quantity(Unit::AngularSpeed, 0.1, 20.0) => 2.0,
        /// From closed to open and back: openings per second \[1/s\].
        opening_rate: f64 = quantity(Unit::Rate, 0.1, 10.0) => 2.0,
        /// Opening of a tool that nobody closes.
        opening: f64 = ratio(1.0) => 0.8,
        /// Azimuth of the handles from straight towards the trainee, to the left for the left hand, to the right for the right one \[rad\].
        azimuth: f64 = quantity(Unit::Angle, 0.0, 90_f64.to_radians()) => 20_f64.to_radians(),
        /// Elevation of the handles above the plane of the field \[rad\].
        elevation: f64 = quantity(Unit::Angle, 0.0, 90_f64.to_radians()) => 0.0,
        /// Where the tips begin: from the middle of the field towards the trainee, in diameters of the field.
        distance: f64 = ratio(1.0) => 0.35,
        /// Each to its side, in diameters of the field.
        side: f64 = ratio(1.0) => 0.15,
        /// What a notch of the wheel, or a press of a key, moves a tip, in diameters of the field.
        step: f64 = quantity(Unit::Ratio, 1e-4, 0.1) => 0.01,
    }
}

/// What the source of mouse and keyboard is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesktopConfig {
    /// The file of the station or the installation.
    pub desktop: Desktop,
    /// The tools of the level, in its order.
    pub tools: Vec<String>,
    /// The middle of the field \[m\].
    pub centre: [f64; 3],
    /// Diameter of the field \[m\].
    pub field: f64,
}

impl DesktopConfig {
    /// The hands before anybody moves them, one per tool: the first to the left of the middle, the second to the right; a single one to the right.
    pub fn hands(&self) -> Vec<DesktopHand> {
        let Desktop {
            speed,
            acceleration,
            lag,
            turn_rate,
            opening_rate,
            ..
        } = self.desktop;
        let limits = DesktopLimits {
            speed,
            acceleration,
            lag,
            turn_rate,
            opening_rate,
        };
        let [x, y, z] = self.centre;
        let place = |(index, tool): (usize, &String)| {
            let side = if index == 0 && self.tools.len() > 1 {
                -1.0
            } else {
                1.0
            };
            let tip = [
                x + side * self.desktop.side * self.field,
                y - self.desktop.distance * self.field,
                z,
            ];
            let angles = HandAngles {
                azimuth: side * self.desktop.azimuth,
                elevation: self.desktop.elevation,
                roll: 0.0,
            };
            DesktopHand::new(tool, limits, tip, angles, self.desktop.opening)
        };
        self.tools.iter().enumerate().map(place).collect()
    }
}

/// Reads the file of mouse and keyboard from a text; `file` is the name that complaints use.
pub fn read_desktop(text: &str, file: &str) -> Result<Loaded<Desktop>, ConfigErrors> {
    Reading::new(text, file, &schema_of::<Desktop>("desktop"))?.finish()
}

/// Reads the file of mouse and keyboard at `path`.
pub fn load_desktop(path: &Path) -> Result<Loaded<Desktop>, ConfigErrors> {
    let text = load_text(
        path,
        "the settings of mouse and keyboard (config/desktop.toml)",
    )?;
    read_desktop(&text, &path.display().to_string())
}
