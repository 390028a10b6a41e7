//! The keys of what touches: pairs, rigid things, tools of scenes.

use crate::body_schema::{point, size, size3};
use crate::rigid::RigidShape;
use crate::schema::{Form, Key, Kind};
use crate::tool::{capsule_keys, jaw_keys, sharpness_key};
use microsim_vocabulary::Finish;
use microsim_vocabulary::Unit;
use serde_json::json;

/// The list of pairs.
pub(crate) fn contact_list() -> Key {
    Key::list(
        "contact",
        Kind::Table(contact_keys()),
        256,
        "Which body touches what: exactly one of `tool`, `rigid`, `with` (another body) and `self`; all others pass through each other.",
    )
}

/// The list of what cuts what.
pub(crate) fn cut_list() -> Key {
    let name = || Kind::Name(Form::Identifier);
    Key::list(
        "cut",
        Kind::Table(vec![
            Key::required("body", name(), "Name of the body."),
            Key::required("tool", name(), "The tool, one with a line of no return."),
        ]),
        64,
        "Which tool cuts which body. Where the two also touch, tissue is pushed away until it gets over a line of no return; where they do not, the lines go through it.",
    )
}

/// The list of rigid things.
pub(crate) fn rigid_list() -> Key {
    Key::list(
        "rigid",
        Kind::Table(rigid_keys()),
        64,
        "Rigid things that stand.",
    )
}

/// The list of a scene's tools.
pub(crate) fn tool_list() -> Key {
    Key::list(
        "tool",
        Kind::Table(tool_keys()),
        8,
        "Tools and how they move.",
    )
}

fn contact_keys() -> Vec<Key> {
    let name = || Kind::Name(Form::Identifier);
    vec![
        Key::required("body", name(), "Name of the body."),
        Key::optional("tool", name(), "The tool that touches it."),
        Key::optional("rigid", name(), "The rigid thing that it touches."),
        Key::optional("with", name(), "The other body that it touches."),
        Key::with_default(
            "self",
            Kind::Bool,
            "Whether the body touches itself, where it is folded.",
            false,
        ),
        Key::with_default(
            "friction",
            Kind::quantity(Unit::Ratio, 0.0, 10.0),
            "Coefficient of Coulomb friction, for sticking and for sliding.",
            0.0,
        ),
        Key::with_default(
            "end_planes",
            Kind::Bool,
            "For the open ends of two vessels, and only with `with`: whether nodes beyond the plane of the other end are led back along its axis.",
            false,
        ),
        Key::optional(
            "force_limit",
            Kind::quantity(Unit::Force, 0.0, 1e3),
            "Size of the force from which on time is counted.",
        ),
    ]
}

fn rigid_keys() -> Vec<Key> {
    vec![
        Key::required("name", Kind::Name(Form::Identifier), "Its name."),
        Key::required(
            "shape",
            Kind::choice(&RigidShape::NAMES),
            "Its form, in its own frame: a `plane` with everything below z = 0, a `box`, a `tray` that is open towards +z, a `clamp` of two plates that face each other along x, a `cylinder` along z.",
        ),
        Key::optional(
            "half_size",
            size3(),
            "Half of each side: of a box, of the inner space of a tray, of a plate of a clamp, and only there.",
        ),
        Key::optional(
            "rounding",
            Kind::quantity(Unit::Length, 0.0, 1.0),
            "Radius of the edges of a box, tray or clamp, and only there; 0 if left out.",
        ),
        Key::optional(
            "wall",
            size(),
            "Thickness of floor and walls of a tray, and only there.",
        ),
        Key::optional(
            "gap",
            size(),
            "Between the plates of a clamp, and only there.",
        ),
        Key::optional("radius", size(), "Of a cylinder, and only there."),
        Key::optional("length", size(), "Of a cylinder, and only there."),
        Key::with_default(
            "position",
            point(),
            "Of its centre.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "orientation",
            Kind::Quaternion,
            "Rotation [x, y, z, w] from its own frame.",
            json!([0.0, 0.0, 0.0, 1.0]),
        ),
        Key::with_default("colour", Kind::Colour, "Colour, sRGB.", "#9aa4ae"),
        Key::with_default(
            "finish",
            Kind::choice(&Finish::NAMES),
            "How its surface answers light.",
            "matte",
        ),
    ]
}

fn tool_keys() -> Vec<Key> {
    let keys = Kind::List {
        of: Box::new(Kind::Table(motion_keys())),
        min: 1,
        max: 10_000,
    };
    let mut all = vec![
        Key::required("name", Kind::Name(Form::Identifier), "Its name."),
        Key::optional(
            "model",
            Kind::Name(Form::Identifier),
            "Name of a file in the folder `tools` beside that of the scene, without its extension; left out with capsules of its own.",
        ),
        Key::list(
            "capsule",
            Kind::Table(capsule_keys()),
            32,
            "Its parts, and only without a `model`.",
        ),
    ];
    all.extend(jaw_keys());
    all.push(sharpness_key());
    all.push(Key::required(
        "motion",
        keys,
        "Where it is, by ascending time: linear between two keys, still before the first and after the last.",
    ));
    all
}

fn motion_keys() -> Vec<Key> {
    vec![
        Key::required(
            "time",
            Kind::quantity(Unit::Time, 0.0, 6e3),
            "Time since the start; later than that of the key before.",
        ),
        Key::required("position", point(), "Of the tool's origin, its tip."),
        Key::optional(
            "orientation",
            Kind::Quaternion,
            "Rotation [x, y, z, w] that turns tool directions into those of the scene; unturned if there is no axis either.",
        ),
        Key::optional(
            "axis",
            Kind::Direction,
            "Axis of that rotation; with `angle`, and instead of `orientation`.",
        ),
        Key::optional(
            "angle",
            Kind::quantity(Unit::Angle, -1e3, 1e3),
            "Right-handed angle about `axis`.",
        ),
        Key::with_default(
            "opening",
            Kind::quantity(Unit::Ratio, 0.0, 1.0),
            "From 0 closed to 1 open.",
            0.0,
        ),
    ]
}
