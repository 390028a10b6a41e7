//! `config/tools/NAME.toml`: the shape of an instrument as posed capsules.
//!
//! Tool frame: origin at the tip, +z from the tip to the handle. The jaws turn about the line through `hinge` along y;
//! the left one opens towards +x, the right one towards −x, each by half of the opening angle. The file shows them closed.

use crate::check::{items, texts, unique};
use crate::colour::Colour;
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::schema::{Form, Key, Kind, Schema};
use microsim_vocabulary::{Finish, LocalText, Unit, terms};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The shape of an instrument.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// What it is and where its sizes come from.
    pub doc: String,
    /// For people: its name.
    pub title: LocalText,
    /// A point of the axis about which the jaws turn, in the tool frame \[m\]; only with jaws.
    pub hinge: Option<[f64; 3]>,
    /// Angle between the jaws when fully open \[rad\]; only with jaws.
    pub opening_angle: Option<f64>,
    /// Colour.
    pub colour: Colour,
    /// How its surface answers light.
    pub finish: Finish,
    /// From 0, blunt, to 1: how well its edges and jaws cut.
    pub sharpness: f64,
    /// Its parts.
    pub capsule: Vec<ToolCapsule>,
}

/// A part of an instrument: all points within `radius` of the segment from `a` to `b`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolCapsule {
    /// Its name.
    pub name: String,
    /// End of the segment, in the tool frame, closed \[m\].
    pub a: [f64; 3],
    /// Other end of the segment \[m\].
    pub b: [f64; 3],
    /// \[m\]
    pub radius: f64,
    /// What it moves with.
    pub jaw: Jaw,
    /// Whether it can touch tissue; a handle, far above the field, is only drawn.
    pub touches: bool,
    /// Whether its segment is a line of no return: tissue that gets over it is cut (dissertation 4.4).
    pub lonor: bool,
    /// Where a single blade is sharp, in the tool frame, closed; `None` for one that cuts against the other jaw only.
    pub edge: Option<[f64; 3]>,
}

terms! {
    /// What a part of an instrument moves with.
    pub enum Jaw {
        /// With the shaft.
        Fixed = "fixed",
        /// With the jaw that opens towards +x.
        Left = "left",
        /// With the jaw that opens towards −x.
        Right = "right",
    }
}

impl Jaw {
    /// The turn of a part about +y through the hinge \[rad\] when the jaws are open by `opening` \[rad\], half of which
    /// each of them takes; `None` for a part of the shaft. Below the hinge a right-handed turn about +y moves towards −x.
    pub fn angle(self, opening: f64) -> Option<f64> {
        match self {
            Self::Fixed => None,
            Self::Left => Some(-(opening / 2.0)),
            Self::Right => Some(opening / 2.0),
        }
    }
}

/// The keys of a part.
pub(crate) fn capsule_keys() -> Vec<Key> {
    vec![
        Key::required("name", Kind::Name(Form::Identifier), "Its name."),
        Key::required(
            "a",
            point(),
            "End of its segment, in the tool frame, tool closed.",
        ),
        Key::required("b", point(), "Other end of its segment."),
        Key::required(
            "radius",
            Kind::quantity(Unit::Length, 1e-6, 0.05),
            "Of the capsule about the segment.",
        ),
        Key::with_default(
            "jaw",
            Kind::choice(&Jaw::NAMES),
            "What it moves with: the shaft, the jaw that opens towards +x, or the one towards -x.",
            "fixed",
        ),
        Key::with_default(
            "touches",
            Kind::Bool,
            "Whether it can touch tissue; a handle, far above the field, is only drawn.",
            true,
        ),
        Key::with_default(
            "lonor",
            Kind::Bool,
            "Whether its segment is a line of no return: tissue that gets over it is cut. Lines of both jaws cut where the jaws meet.",
            false,
        ),
        Key::optional(
            "edge",
            Kind::Direction,
            "Where a single blade is sharp, in the tool frame, tool closed; only with `lonor`. Without it the line cuts against that of the other jaw only, and its back is blunt.",
        ),
    ]
}

/// How sharp a tool is.
pub(crate) fn sharpness_key() -> Key {
    Key::with_default(
        "sharpness",
        Kind::quantity(Unit::Ratio, 0.0, 1.0),
        "How well its edges and jaws cut, from 0, blunt, to 1.",
        0.0,
    )
}

/// The keys of the hinge.
pub(crate) fn jaw_keys() -> [Key; 2] {
    [
        Key::optional(
            "hinge",
            point(),
            "A point of the axis about which the jaws turn; the axis is along y. Only and always with jaws.",
        ),
        Key::optional(
            "opening_angle",
            Kind::quantity(Unit::Angle, 0.0, 90_f64.to_radians()),
            "Angle between the jaws when fully open. Only and always with jaws.",
        ),
    ]
}

fn point() -> Kind {
    Kind::vector3(Unit::Length, 0.5)
}

/// The schema of a tool.
pub fn tool_schema() -> Schema {
    let parts = Kind::List {
        of: Box::new(Kind::Table(capsule_keys())),
        min: 1,
        max: 32,
    };
    let [hinge, opening_angle] = jaw_keys();
    Schema {
        name: "tool".to_owned(),
        doc: "config/tools/NAME.toml: the shape of an instrument. Tool frame: origin at the tip, +z from tip to handle.".to_owned(),
        keys: vec![
            Key::required("doc", Kind::Text, "What it is and where its sizes come from."),
            Key::required("title", Kind::LocalText, "Its name for people."),
            hinge,
            opening_angle,
            Key::with_default("colour", Kind::Colour, "Colour, sRGB.", "#b8bcc2"),
            Key::with_default("finish", Kind::choice(&Finish::NAMES), "How its surface answers light.", "metal"),
            sharpness_key(),
            Key::required("capsule", parts, "Its parts."),
        ],
    }
}

/// Complains about a hinge without jaws, about jaws without one, and about edges of what does not cut, in the tool at `tool`.
pub(crate) fn check_jaws(reading: &mut Reading, tool: &KeyPath) {
    let value = match tool == &KeyPath::root() {
        true => Some(reading.value()),
        false => reading.value_at(tool),
    };
    let jaws = value.is_some_and(|value| {
        items(value, "capsule")
            .any(|(_, part)| matches!(part["jaw"].as_str(), Some("left" | "right")))
    });
    let parts: Vec<(usize, bool)> = value.map_or_else(Vec::new, |value| {
        let parts = items(value, "capsule");
        parts.map(|(i, part)| (i, part["lonor"] == true)).collect()
    });
    for (i, _) in parts.iter().filter(|(_, lonor)| !lonor) {
        let key = tool.key("capsule").at(*i).key("edge");
        if reading.is_written(&key) {
            reading.complain(&key, "`edge`", "no `edge` without `lonor = true`");
        }
    }
    for field in ["hinge", "opening_angle"] {
        let key = tool.key(field);
        match (jaws, reading.is_written(&key)) {
            (true, false) => {
                reading.complain(&key, "nothing", &format!("`{field}`, which jaws need"))
            }
            (false, true) => reading.complain(
                &key,
                &format!("`{field}`"),
                &format!("no `{field}`, as there are no jaws"),
            ),
            _ => {}
        }
    }
}

/// Reads a tool from a text; `file` is the name that complaints use.
pub fn read_tool(text: &str, file: &str) -> Result<Loaded<Tool>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &tool_schema())?;
    let root = KeyPath::root();
    let names = texts(reading.value(), "capsule", "name");
    unique(&mut reading, &root, &names, "capsule", "name");
    check_jaws(&mut reading, &root);
    reading.finish()
}

/// Reads the tool at `path`.
pub fn load_tool(path: &Path) -> Result<Loaded<Tool>, ConfigErrors> {
    let text = load_text(path, "the shape of a tool (config/tools/NAME.toml)")?;
    read_tool(&text, &path.display().to_string())
}
