//! `config/tools/NAME.toml`: the shape of an instrument as posed capsules.
//!
//! Tool frame: origin at the tip, +z from the tip to the handle. The jaws turn about the line through `hinge` along y;
//! the left one opens towards +x, the right one towards −x, each by half of the opening angle. The file shows them closed.

use crate::check::{items, texts, unique};
use crate::colour::Colour;
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{direction, identifier, quantity, ratio, vector3};
use crate::schema::Kind;
use crate::table::{choices, table};
use microsim_geometry::{Capsule, Hinge, Joint};
use microsim_vocabulary::{Finish, LocalText, Unit, terms};
use nalgebra::Vector3;
use serde_json::Value;
use std::path::Path;

table! {
    /// The shape of an instrument.
    pub struct Tool {
        /// What it is and where its sizes come from.
        doc: String,
        /// Its name for people.
        title: LocalText,
        /// A point of the axis about which the jaws turn \[m\]; the axis is along y. Only and always with jaws.
        hinge: Option<[f64; 3]> = tool_point(),
        /// Angle between the jaws when fully open \[rad\]. Only and always with jaws.
        opening_angle: Option<f64> = jaw_angle(),
        /// Colour, sRGB.
        colour: Colour => "#b8bcc2",
        /// How its surface answers light.
        finish: Finish => "metal",
        /// How well its edges and jaws cut, from 0, blunt, to 1.
        sharpness: f64 = ratio(1.0) => 0.0,
        /// Of the tip of a jaw against what opens or closes it \[N/m\]: it bends. Without it jaws are rigid. Only with jaws.
        jaw_stiffness: Option<f64> = quantity(Unit::LengthStiffness, 1.0, 1e9),
        /// Fluid that it sends out, with its opening as the valve.
        irrigation: Option<Irrigation>,
        /// Its parts.
        capsule: Vec<ToolCapsule> [1, 32],
    }
}

table! {
    /// Fluid that a tool sends out: its pressure goes with the opening of the tool, from nothing when closed. In a lumen that surrounds
    /// the opening it fills the vessel, elsewhere it presses on what faces the jet.
    #[derive(Copy)]
    pub struct Irrigation {
        /// The opening, in the tool frame \[m\].
        position: [f64; 3] = tool_point() => [0.0, 0.0, 0.0],
        /// Where the fluid flows to, in the tool frame; from handle to tip if left out.
        direction: [f64; 3] = direction() => [0.0, 0.0, -1.0],
        /// Of the fluid at rest, tool open \[Pa\].
        pressure: f64 = quantity(Unit::Pressure, 0.0, 1e6),
        /// Of the jet \[m\].
        radius: f64 = quantity(Unit::Length, 1e-5, 0.05),
        /// How far the jet reaches \[m\].
        reach: f64 = quantity(Unit::Length, 1e-5, 0.5),
    }
}

table! {
    /// A part of an instrument: all points within `radius` of the segment from `a` to `b`.
    pub struct ToolCapsule {
        /// Its name.
        name: String = identifier(),
        /// End of its segment, in the tool frame, tool closed \[m\].
        a: [f64; 3] = tool_point(),
        /// Other end of its segment \[m\].
        b: [f64; 3] = tool_point(),
        /// Of the capsule about the segment \[m\].
        radius: f64 = quantity(Unit::Length, 1e-6, 0.05),
        /// What it moves with: the shaft, the jaw that opens towards +x, or the one towards -x.
        jaw: Jaw => "fixed",
        /// Whether it can touch tissue; a handle, far above the field, is only drawn.
        touches: bool => true,
        /// Whether its segment is a line of no return: tissue that gets over it is cut. Lines of both jaws cut where
        /// the jaws meet.
        lonor: bool => false,
        /// Where a single blade is sharp, in the tool frame, tool closed; only with `lonor`. Without it the line cuts
        /// against that of the other jaw only, and its back is blunt.
        edge: Option<[f64; 3]> = direction(),
        /// How far its line of no return lies beside its axis, in the tool frame, tool closed; only with `lonor` \[m\]. The line stays within the capsule.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lonor_offset: Option<[f64; 3]> = tool_point(),
    }
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

choices!(Jaw);

impl Tool {
    /// Its parts in its frame at an opening, from 0, closed, to 1.
    pub fn capsules_at(&self, opening: f64) -> impl Iterator<Item = Capsule> {
        self.capsule.iter().map(move |part| {
            let joint = part.joint(self.hinge, self.opening_angle);
            joint.capsule_at(&part.closed(), opening)
        })
    }
}

impl ToolCapsule {
    /// The part in the frame of the tool, tool closed.
    pub fn closed(&self) -> Capsule {
        Capsule {
            a: self.a.into(),
            b: self.b.into(),
            radius: self.radius,
        }
    }

    /// How it moves as a tool with this hinge \[m\] and angle between fully open jaws \[rad\] opens from 0 to 1. Each jaw takes half of
    /// the angle; below the hinge a right-handed turn about +y moves towards −x.
    pub fn joint(&self, hinge: Option<[f64; 3]>, opening_angle: Option<f64>) -> Joint {
        let opening = opening_angle.unwrap_or_default();
        let angle = match self.jaw {
            Jaw::Fixed => return Joint::Fixed,
            Jaw::Left => -(opening / 2.0),
            Jaw::Right => opening / 2.0,
        };
        Joint::Hinge(Hinge {
            pivot: hinge.unwrap_or_default().into(),
            axis: Vector3::y_axis(),
            angle,
        })
    }
}

/// A point of a tool \[m\].
pub(crate) fn tool_point() -> Kind {
    vector3(Unit::Length, 0.5)
}

/// The angle between jaws that are fully open \[rad\].
pub(crate) fn jaw_angle() -> Kind {
    quantity(Unit::Angle, 0.0, 90_f64.to_radians())
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
        for field in ["edge", "lonor_offset"] {
            let key = tool.key("capsule").at(*i).key(field);
            if reading.is_written(&key) {
                let expected = format!("no `{field}` without `lonor = true`");
                reading.complain(&key, &format!("`{field}`"), &expected);
            }
        }
    }
    check_offsets(reading, tool);
    let elastic = tool.key("jaw_stiffness");
    if !jaws && reading.is_written(&elastic) {
        let expected = "no `jaw_stiffness`, as there are no jaws";
        reading.complain(&elastic, "`jaw_stiffness`", expected);
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

/// Complains about lines of no return outside of their capsules: tissue would be held before it.
fn check_offsets(reading: &mut Reading, tool: &KeyPath) {
    let value = match tool == &KeyPath::root() {
        true => Some(reading.value()),
        false => reading.value_at(tool),
    };
    let outside = |part: &Value| {
        let offset = part["lonor_offset"].as_array()?;
        let squares = offset.iter().filter_map(Value::as_f64).map(|x| x * x);
        let length = squares.sum::<f64>().sqrt();
        let radius = part["radius"].as_f64()?;
        (length >= radius).then_some((length, radius))
    };
    let parts = value.into_iter().flat_map(|value| items(value, "capsule"));
    let wrong: Vec<_> = parts
        .filter_map(|(i, part)| Some((i, outside(part)?)))
        .collect();
    for (i, (length, radius)) in wrong {
        let expected = format!("less than the radius, {}", Unit::Length.describe(radius));
        let key = tool.key("capsule").at(i).key("lonor_offset");
        reading.complain(&key, &Unit::Length.describe(length), &expected);
    }
}

/// Reads a tool from a text; `file` is the name that complaints use.
pub fn read_tool(text: &str, file: &str) -> Result<Loaded<Tool>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Tool>("tool"))?;
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
