//! The keys of a level.

use crate::body_schema::{body_keys, point, size, size3};
use crate::contact_schema::{contact_list, cut_list, rigid_list};
use crate::level::ShapeName;
use crate::manifest::Manifest;
use crate::method::{accuracy_keys, method_keys, tuned_keys};
use crate::schema::{Form, Key, Kind, Schema};
use microsim_vocabulary::Finish;
use microsim_vocabulary::Unit;
use serde_json::json;

/// The schema of a level; of the module whose manifest is given, or of any.
pub fn level_schema(manifest: Option<&Manifest>) -> Schema {
    let module = match manifest {
        Some(manifest) => Key::table(
            "module",
            manifest.module_keys(),
            "What the module's manifest declares.",
        ),
        None => {
            let of = Box::new(Kind::Dependent(
                "a value of the kind that the module's manifest declares".to_owned(),
            ));
            let open = Kind::Map {
                keys: Form::Symbol,
                of,
            };
            Key::with_default(
                "module",
                open,
                "What the module's manifest declares.",
                json!({}),
            )
        }
    };
    Schema {
        name: "level".to_owned(),
        doc: "modules/NAME/levels/level<N>.toml: one level of a training module.".to_owned(),
        keys: vec![
            Key::required("title", Kind::LocalText, "Its name for people."),
            Key::required(
                "summary",
                Kind::LocalText,
                "What changes and why it is harder, in a sentence for people.",
            ),
            Key::required(
                "clock",
                Kind::Table(clock_keys()),
                "The two clocks of a run.",
            ),
            Key::table("view", view_keys(), "What the microscope shows."),
            Key::list(
                "tool",
                Kind::Table(tool_keys()),
                8,
                "The tools that take part.",
            ),
            Key::list(
                "object",
                Kind::Table(object_keys()),
                256,
                "Virtual objects.",
            ),
            Key::list("body", Kind::Table(body_keys()), 64, "Tetrahedral bodies."),
            rigid_list(),
            contact_list(),
            cut_list(),
            Key::optional(
                "physics",
                Kind::Table(physics_keys()),
                "What drives all bodies; needed if and only if there are bodies.",
            ),
            Key::optional(
                "method",
                Kind::Table(method_keys()),
                "How the bodies are advanced; needed if and only if there are bodies.",
            ),
            Key::optional(
                "accuracy",
                Kind::Table(accuracy_keys()),
                "What is stated of the motion of the bodies; `microsim tune` looks for the cheapest way to keep it.",
            ),
            Key::optional(
                "tuned",
                Kind::Table(tuned_keys()),
                "What `microsim tune` chose and measured.",
            ),
            Key::list(
                "limit",
                Kind::Table(limit_keys()),
                64,
                "What is demanded; a level is passed if every limit is kept.",
            ),
            Key::table(
                "metrics",
                metrics_keys(),
                "Parameters of the metrics that need motion alone.",
            ),
            module,
        ],
    }
}

fn clock_keys() -> Vec<Key> {
    vec![
        Key::required(
            "tick",
            Kind::quantity(Unit::Time, 0.001, 0.05),
            "Time between two ticks, a whole number of microseconds.",
        ),
        Key::with_default(
            "steps",
            Kind::Integer { min: 1, max: 1000 },
            "Steps of the solver in a tick.",
            1,
        ),
    ]
}

pub(crate) fn view_keys() -> Vec<Key> {
    vec![
        Key::with_default(
            "field",
            Kind::quantity(Unit::Length, 0.001, 0.2),
            "Diameter of the round field of view.",
            0.025,
        ),
        Key::with_default(
            "centre",
            point(),
            "Point in the middle of the picture, in the field frame.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "tilt",
            Kind::quantity(Unit::Angle, 0.0, 80_f64.to_radians()),
            "Angle between the line of sight and straight down, turned towards the trainee.",
            0.0,
        ),
    ]
}

fn tool_keys() -> Vec<Key> {
    vec![
        name("Slot that sources and the translator name, for example `right`."),
        Key::required(
            "model",
            Kind::Name(Form::Identifier),
            "Name of a file in config/tools, without its extension.",
        ),
    ]
}

fn object_keys() -> Vec<Key> {
    vec![
        name("Its name, or the beginning of its names if there is a `count`."),
        Key::optional(
            "count",
            Kind::Integer { min: 1, max: 256 },
            "Makes that many equal objects, named NAME-1, NAME-2 and so on.",
        ),
        Key::required("shape", Kind::choice(&ShapeName::NAMES), "Its form."),
        Key::optional(
            "radius",
            size(),
            "Of a sphere, capsule or ring, and only there; of a ring to the middle of its tube.",
        ),
        Key::optional(
            "tube",
            size(),
            "Of a ring, and only there: radius of its tube. The ring lies around its z axis.",
        ),
        Key::optional(
            "length",
            size(),
            "Of a capsule, and only there: between the centres of its ends, along its z axis.",
        ),
        Key::optional(
            "half_size",
            size3(),
            "Of a box, and only there: half of each side.",
        ),
        Key::with_default(
            "position",
            point(),
            "Of its centre, in the frame of the parent.",
            json!([0.0, 0.0, 0.0]),
        ),
        Key::with_default(
            "orientation",
            Kind::Quaternion,
            "Rotation [x, y, z, w] from its own frame to that of the parent.",
            json!([0.0, 0.0, 0.0, 1.0]),
        ),
        Key::optional(
            "parent",
            Kind::Name(Form::Identifier),
            "Object in whose frame its pose is given; the field frame if left out.",
        ),
        colour(),
        finish("matte"),
        Key::with_default(
            "active",
            Kind::Bool,
            "Whether it is there from the start.",
            true,
        ),
    ]
}

fn physics_keys() -> Vec<Key> {
    vec![Key::with_default(
        "gravity",
        Kind::vector3(Unit::Acceleration, 100.0),
        "Acceleration of free fall, in the field frame.",
        json!([0.0, 0.0, -9.81]),
    )]
}

fn limit_keys() -> Vec<Key> {
    let value = || Kind::Dependent("a value in the metric's unit".to_owned());
    vec![
        Key::required(
            "metric",
            Kind::Name(Form::Identifier),
            "Id of the metric: one that every level has, or one of the module.",
        ),
        Key::optional(
            "min",
            value(),
            "Smallest value that passes, in the metric's unit.",
        ),
        Key::optional(
            "max",
            value(),
            "Largest value that passes, in the metric's unit.",
        ),
        Key::optional(
            "full",
            value(),
            "Value from which on the score is 100; needs `zero`.",
        ),
        Key::optional(
            "zero",
            value(),
            "Value from which on the score is 0; needs `full`.",
        ),
        Key::required("source", Kind::Text, "Where the limit comes from."),
        Key::with_default(
            "provisional",
            Kind::Bool,
            "Whether it still has to be set from measurements.",
            true,
        ),
        Key::optional(
            "reason",
            Kind::Name(Form::Identifier),
            "The module's reason that a result names if it is not kept; the metric's id if left out.",
        ),
    ]
}

fn metrics_keys() -> Vec<Key> {
    let speed = || Kind::quantity(Unit::Speed, 1e-6, 1.0);
    vec![
        Key::with_default("idle_speed", speed(), "Below it a tool is idle.", 0.0001),
        Key::with_default(
            "movement_speed",
            speed(),
            "Its upward crossings count as movements, with a hysteresis of half of it.",
            0.001,
        ),
        Key::with_default(
            "smoothing",
            Kind::quantity(Unit::Time, 0.0, 1.0),
            "Standard deviation of the Gaussian that smooths positions before idle time, movements and bimanual metrics.",
            0.05,
        ),
        Key::with_default(
            "resample_rate",
            Kind::quantity(Unit::Frequency, 60.0, 1000.0),
            "Rate at which segments are sampled evenly.",
            60.0,
        ),
        Key::with_default(
            "gap",
            Kind::quantity(Unit::Time, 0.001, 10.0),
            "A longer time without a valid pose splits the motion in two segments.",
            0.1,
        ),
        Key::optional(
            "shortest_path",
            Kind::quantity(Unit::Length, 0.0, 10.0),
            "Length of the shortest sensible path, for economy; left out if the module knows it or there is none.",
        ),
    ]
}

fn name(doc: &str) -> Key {
    Key::required("name", Kind::Name(Form::Identifier), doc)
}

fn colour() -> Key {
    Key::with_default("colour", Kind::Colour, "Colour, sRGB.", "#c8c8c8")
}

fn finish(default: &str) -> Key {
    Key::with_default(
        "finish",
        Kind::choice(&Finish::NAMES),
        "How its surface answers light.",
        default,
    )
}
