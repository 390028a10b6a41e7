//! `config/translator.toml`: which device drives which tool, and how its frame lies in the field.
//!
//! A device point p becomes the field point `field_offset + scale · rotation (p − origin)`; a device orientation q becomes
//! the tool's orientation `rotation · q · tool_rotation`. A device that is not listed drives the tool of its own name, with
//! its poses taken as they are.
//!
//! All devices are in hands: a sample that is beyond the limits of `hand` is left out. Each default is far above what a hand does under the microscope and far
//! below what a tracker that errs reports:
//!
//! | | default | recorded surgery | why |
//! |---|---|---|---|
//! | speed | 1 m/s | 0.17 m/s | a judgement: six times the recorded one |
//! | acceleration | 10 m/s² | 2.5 m/s² | a judgement: four times the recorded one, jitter included |
//! | turn rate | 30 rad/s | 2.5 rad/s | a judgement: twelve times the recorded one |
//! | opening rate | 17 1/s | – | a movement takes 1/9.2 s at least, the bandwidth of impulses of acceleration and deceleration of hands (Draper 1994, IEEE Trans. Syst. Man Cybern. 24:931); 1.875 of its mean speed are its largest with minimum jerk (Flash & Hogan 1985) |
//!
//! Recorded are the 3,466 samples of `assets/recordings/cataract-stylus`, by difference quotients inside its segments.

use crate::check::{texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{identifier, own_defaults, quantity, ratio, rotation, time, vector3};
use crate::schema::Kind;
use crate::table::{Setting, table};
use microsim_tracking::HandLimits;
use microsim_vocabulary::{Unit, terms};
use serde::{Deserialize, Serialize};
use std::path::Path;

table! {
    /// What the translator knows of the devices.
    pub struct Translator {
        /// A tool whose last sample is older is stale \[s\].
        stale_after: f64 = time(0.001, 10.0) => 0.1,
        /// What no hand goes beyond: samples that do are left out.
        hand: Hand => own_defaults(),
        /// Devices that do not simply drive the tool of their own name.
        device: Vec<DeviceMap> [0, 32],
    }
}

table! {
    /// What no hand goes beyond, in the device's frame, before any scale. Samples may be off by the errors stated here; those of a hand at
    /// rest are never beyond a limit for that.
    #[derive(Copy)]
    pub struct Hand {
        /// Largest speed of the tip \[m/s\].
        speed: f64 = quantity(Unit::Speed, 0.01, 1000.0) => 1.0,
        /// Largest acceleration of the tip \[m/s²\].
        acceleration: f64 = quantity(Unit::Acceleration, 0.1, 1e6) => 10.0,
        /// Largest speed of turning \[rad/s\].
        turn_rate: f64 = quantity(Unit::AngularSpeed, 0.1, 1e4) => 30.0,
        /// Largest change of the opening per time, from 0 closed to 1 open \[1/s\].
        opening_rate: f64 = quantity(Unit::Rate, 0.1, 1e4) => 17.0,
        /// Largest error of a position, jitter and rounding: a dozen times the 20 µm of a tracker made for such simulators (CatAR) \[m\].
        position_error: f64 = quantity(Unit::Length, 0.0, 0.1) => 2.5e-4,
        /// Largest error of an orientation \[rad\].
        turn_error: f64 = quantity(Unit::Angle, 0.0, 1.0) => 0.05,
        /// Largest error of an opening.
        opening_error: f64 = ratio(1.0) => 0.02,
        /// Samples elsewhere that are consistent with each other for this long count: the instrument is there \[s\].
        accept_after: f64 = time(0.001, 10.0) => 0.1,
    }
}

impl Hand {
    /// The limits as the translator compares samples with them.
    pub fn limits(&self) -> HandLimits {
        HandLimits {
            speed: self.speed,
            acceleration: self.acceleration,
            turn_rate: self.turn_rate,
            opening_rate: self.opening_rate,
            position_error: self.position_error,
            turn_error: self.turn_error,
            opening_error: self.opening_error,
            accept_after_s: self.accept_after,
        }
    }
}

table! {
    /// How one device drives one tool.
    pub struct DeviceMap {
        /// As the source names it.
        name: String = identifier(),
        /// Slot of the tool that it drives.
        tool: String = identifier(),
        /// Device point that comes to lie on `field_offset`, in the device frame \[m\].
        origin: [f64; 3] = vector3(Unit::Length, 10.0) => [0.0, 0.0, 0.0],
        /// Where that point lies in the field frame \[m\].
        field_offset: [f64; 3] = vector3(Unit::Length, 10.0) => [0.0, 0.0, 0.0],
        /// Rotation [x, y, z, w] that turns device directions into field directions.
        rotation: [f64; 4] = rotation() => [0.0, 0.0, 0.0, 1.0],
        /// Rotation [x, y, z, w] that turns tool directions into directions of the device's moving part.
        tool_rotation: [f64; 4] = rotation() => [0.0, 0.0, 0.0, 1.0],
        /// Field lengths per device length.
        scale: f64 = quantity(Unit::Ratio, 0.001, 1000.0) => 1.0,
        /// Where the opening comes from: the device, or always `closed`, `open` or this fraction.
        opening: OpeningSource => "device",
    }
}

/// Where the opening of a tool comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OpeningSource {
    /// From the device or always at an end.
    Named(OpeningName),
    /// Always this fraction of the full opening.
    Fixed(f64),
}

terms! {
    /// Openings that have a name.
    pub enum OpeningName {
        /// As the device reports it.
        Device = "device",
        /// Always 0.
        Closed = "closed",
        /// Always 1.
        Open = "open",
    }
}

impl OpeningSource {
    /// The opening that holds whatever the device reports, from 0 closed to 1 open; `None` if the device reports it.
    pub fn fixed(self) -> Option<f64> {
        match self {
            OpeningSource::Named(OpeningName::Device) => None,
            OpeningSource::Named(OpeningName::Closed) => Some(0.0),
            OpeningSource::Named(OpeningName::Open) => Some(1.0),
            OpeningSource::Fixed(opening) => Some(opening),
        }
    }
}

impl Setting for OpeningSource {
    fn kind() -> Kind {
        let names = OpeningName::NAMES.map(str::to_owned).to_vec();
        Kind::ChoiceOr(names, Box::new(ratio(1.0)))
    }
}

/// Reads the translator's file from a text; `file` is the name that complaints use.
pub fn read_translator(text: &str, file: &str) -> Result<Loaded<Translator>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Translator>("translator"))?;
    for field in ["name", "tool"] {
        let names = texts(reading.value(), "device", field);
        unique(&mut reading, &KeyPath::root(), &names, "device", field);
    }
    reading.finish()
}

/// Reads the translator's file at `path`.
pub fn load_translator(path: &Path) -> Result<Loaded<Translator>, ConfigErrors> {
    let text = load_text(
        path,
        "the map from devices to tools (config/translator.toml)",
    )?;
    read_translator(&text, &path.display().to_string())
}
