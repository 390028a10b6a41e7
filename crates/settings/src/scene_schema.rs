//! The keys of a scene.

use crate::body_schema::{body_keys, nodes_keys, point};
use crate::contact_schema::{contact_list, cut_list, rigid_list, tool_list};
use crate::level_schema::view_keys;
use crate::method::{accuracy_keys, method_keys, tuned_keys};
use crate::scene::{End, Feature, Quantity};
use crate::schema::{Form, Key, Kind, Schema};
use microsim_vocabulary::Unit;
use serde_json::json;

/// The schema of a scene.
pub fn scene_schema() -> Schema {
    let bodies = Kind::List {
        of: Box::new(Kind::Table(body_keys())),
        min: 1,
        max: 64,
    };
    Schema {
        name: "scene".to_owned(),
        doc: "config/scenes/NAME.toml: physics alone, as demonstration, test and benchmark."
            .to_owned(),
        keys: vec![
            Key::required("title", Kind::LocalText, "Its name for people."),
            Key::required(
                "summary",
                Kind::LocalText,
                "What it shows, in a sentence for people.",
            ),
            Key::required("run", Kind::Table(run_keys()), "How long, in which steps."),
            Key::optional(
                "view",
                Kind::Table(view_keys()),
                "What pictures show; all bodies as they lie at the start without it.",
            ),
            Key::required(
                "method",
                Kind::Table(method_keys()),
                "How the bodies are advanced.",
            ),
            Key::required("body", bodies, "Tetrahedral bodies."),
            tool_list(),
            rigid_list(),
            contact_list(),
            cut_list(),
            Key::list(
                "probe",
                Kind::Table(probe_keys()),
                64,
                "What is watched: a number each, sampled into the series.",
            ),
            Key::list(
                "expect",
                Kind::Table(expect_keys()),
                64,
                "What must come out, and where that is known from.",
            ),
            Key::optional(
                "accuracy",
                Kind::Table(accuracy_keys()),
                "What is stated of the result; `microsim tune` looks for the cheapest way to keep it.",
            ),
            Key::optional(
                "tuned",
                Kind::Table(tuned_keys()),
                "What `microsim tune` chose and measured.",
            ),
        ],
    }
}

fn run_keys() -> Vec<Key> {
    let time = |min, max| Kind::quantity(Unit::Time, min, max);
    vec![
        Key::required(
            "duration",
            time(1e-6, 6e3),
            "Simulated time; with `end = \"rest\"` the longest.",
        ),
        Key::required(
            "step",
            time(1e-9, 600.0),
            "Step of the solver; shortened so that a whole number fits between two samples.",
        ),
        Key::with_default(
            "sample",
            time(1e-9, 600.0),
            "Time between two samples of the series; a longer step takes its place.",
            0.001,
        ),
        Key::with_default(
            "frame",
            time(1e-9, 6e3),
            "Time between two exported meshes (--vtu); a longer sample takes its place.",
            0.02,
        ),
        Key::with_default(
            "end",
            Kind::choice(&End::NAMES),
            "When it ends: after its `duration`, or when it has come to `rest`.",
            "time",
        ),
        Key::optional(
            "rest_speed",
            Kind::quantity(Unit::Speed, 1e-12, 1.0),
            "It rests when no node moved faster than this over a whole sample; with `end = \"rest\"`, and only there.",
        ),
        Key::with_default(
            "gravity",
            Kind::vector3(Unit::Acceleration, 100.0),
            "Acceleration of free fall.",
            json!([0.0, 0.0, -9.81]),
        ),
        Key::with_default(
            "containment",
            Kind::Bool,
            "Whether a body that diverges is rolled back and computed again with shorter steps; without it the run ends there.",
            false,
        ),
    ]
}

fn probe_keys() -> Vec<Key> {
    vec![
        Key::required("name", Kind::Name(Form::Identifier), "Its name."),
        Key::required("body", Kind::Name(Form::Identifier), "The body."),
        Key::with_default(
            "nodes",
            Kind::Table(nodes_keys()),
            "Nodes of the body: all, or those that fulfil everything that is said.",
            json!({}),
        ),
        Key::required(
            "quantity",
            Kind::choice(&Quantity::NAMES),
            "What of them: mean `displacement`, that of the `centre` of mass, mean change of the `radius`, largest `distance` from rest, `force` or `torque` with which clamps hold those that they hold now, relative change of the body's `volume`, `smallest-volume` of an element as a share of that at rest, total `energy`; `contact-force` of the other side, `grip`, the force with which both jaws of a tool squeeze it between them, `gap` to the other body, share of nodes `inside` what the body touches and the `depth` of the deepest, `crossings` of edges of its surface and the other body's with triangles; number of `pieces` that the body has come apart into.",
        ),
        Key::optional(
            "direction",
            Kind::Direction,
            "Of a displacement, centre, force, contact-force or gap, and only there.",
        ),
        Key::optional(
            "with",
            Kind::Name(Form::Identifier),
            "The other side: a tool, rigid thing or body of a contact-force, a tool of a grip, a body of a gap or of crossings, and only there.",
        ),
        Key::optional(
            "point",
            point(),
            "A point of the axis of a radius or torque, in the body's frame; its origin if left out.",
        ),
        Key::optional(
            "axis",
            Kind::Direction,
            "Axis of a radius or torque, and only there.",
        ),
    ]
}

fn expect_keys() -> Vec<Key> {
    let value = || Kind::Dependent("a value in the unit of what is expected".to_owned());
    vec![
        Key::required("probe", Kind::Name(Form::Identifier), "Name of the probe."),
        Key::required(
            "what",
            Kind::choice(&Feature::NAMES),
            "What of its series: the value `at-end`, the `largest`, the `spread` from smallest to largest, the `first-peak` or its `first-peak-time`, the `frequency` with which it crosses its middle.",
        ),
        Key::required("value", value(), "The right value."),
        Key::required(
            "tolerance",
            Kind::quantity(Unit::Ratio, 1e-15, 10.0),
            "Largest error that is right, as a share of `scale`.",
        ),
        Key::optional(
            "scale",
            value(),
            "What errors are a share of; the size of `value` if left out.",
        ),
        Key::with_default(
            "settle",
            Kind::quantity(Unit::Time, 0.0, 600.0),
            "A first peak counts when the curve has stayed below it for this time.",
            0.05,
        ),
        Key::required(
            "source",
            Kind::Text,
            "Where value and tolerance come from, in a sentence.",
        ),
    ]
}
