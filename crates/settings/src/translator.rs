//! `config/translator.toml`: which device drives which tool, and how its frame lies in the field.
//!
//! A device point p becomes the field point `field_offset + scale · rotation (p − origin)`; a device orientation q becomes
//! the tool's orientation `rotation · q · tool_rotation`. A device that is not listed drives the tool of its own name, with
//! its poses taken as they are.

use crate::check::{texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::schema::{Form, Key, Kind, Schema};
use microsim_vocabulary::{Unit, terms};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::Path;

/// What the translator knows of the devices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Translator {
    /// A tool whose last sample is older is stale \[s\].
    pub stale_after: f64,
    /// Devices that do not simply drive the tool of their own name.
    pub device: Vec<DeviceMap>,
}

/// How one device drives one tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceMap {
    /// As the source names it.
    pub name: String,
    /// Slot of the tool that it drives.
    pub tool: String,
    /// Device point that comes to lie on `field_offset`, in the device frame \[m\].
    pub origin: [f64; 3],
    /// Where that point lies in the field \[m\].
    pub field_offset: [f64; 3],
    /// Rotation x, y, z, w: field from device.
    pub rotation: [f64; 4],
    /// Rotation x, y, z, w: device's moving part from tool.
    pub tool_rotation: [f64; 4],
    /// Field lengths per device length.
    pub scale: f64,
    /// Where the opening of the tool comes from.
    pub opening: OpeningSource,
}

/// Where the opening of a tool comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OpeningSource {
    /// From the device or always at an end.
    Named(OpeningName),
    /// Always this share of the full opening.
    Fixed(f64),
}

terms! {
    /// Openings that have a name.
    pub enum OpeningName {
        /// As the device says.
        Device = "device",
        /// Always 0.
        Closed = "closed",
        /// Always 1.
        Open = "open",
    }
}

impl OpeningSource {
    /// The opening that holds whatever the device says, from 0 closed to 1 open; `None` if the device says it.
    pub fn fixed(self) -> Option<f64> {
        match self {
            OpeningSource::Named(OpeningName::Device) => None,
            OpeningSource::Named(OpeningName::Closed) => Some(0.0),
            OpeningSource::Named(OpeningName::Open) => Some(1.0),
            OpeningSource::Fixed(opening) => Some(opening),
        }
    }
}

/// The schema of the translator's file.
pub fn translator_schema() -> Schema {
    let point = || Kind::vector3(Unit::Length, 10.0);
    let identity = || json!([0.0, 0.0, 0.0, 1.0]);
    let names = OpeningName::NAMES.map(str::to_owned).to_vec();
    let opening = Kind::ChoiceOr(names, Box::new(Kind::quantity(Unit::Ratio, 0.0, 1.0)));
    let device = vec![
        Key::required(
            "name",
            Kind::Name(Form::Identifier),
            "As the source names it.",
        ),
        Key::required(
            "tool",
            Kind::Name(Form::Identifier),
            "Slot of the tool that it drives.",
        ),
        Key::with_default(
            "origin",
            point(),
            "Device point that comes to lie on `field_offset`, in the device frame.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "field_offset",
            point(),
            "Where that point lies in the field frame.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "rotation",
            Kind::Quaternion,
            "Rotation [x, y, z, w] that turns device directions into field directions.",
            identity(),
        ),
        Key::with_default(
            "tool_rotation",
            Kind::Quaternion,
            "Rotation [x, y, z, w] that turns tool directions into directions of the device's moving part.",
            identity(),
        ),
        Key::with_default(
            "scale",
            Kind::quantity(Unit::Ratio, 0.001, 1000.0),
            "Field lengths per device length.",
            1.0,
        ),
        Key::with_default(
            "opening",
            opening,
            "Where the opening comes from: the device, or always `closed`, `open` or this share.",
            "device",
        ),
    ];
    Schema {
        name: "translator".to_owned(),
        doc: "config/translator.toml: which device drives which tool, and how its frame lies in the field.".to_owned(),
        keys: vec![
            Key::with_default("stale_after", Kind::quantity(Unit::Time, 0.001, 10.0), "A tool whose last sample is older is stale.", 0.1),
            Key::list("device", Kind::Table(device), 32, "Devices that do not simply drive the tool of their own name."),
        ],
    }
}

/// Reads the translator's file from a text; `file` is the name that complaints use.
pub fn read_translator(text: &str, file: &str) -> Result<Loaded<Translator>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &translator_schema())?;
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
