//! What a scene must fulfil beyond its single values: names, references, times that fit, probes that can be measured.

use crate::body_check::{check_bodies, check_box, check_held};
use crate::check::{items, refers, texts, unique};
use crate::contact_check::{
    check_broad_phase, check_contacts, check_cuts, check_rigid, check_scene_tools,
};
use crate::document::Reading;
use crate::document::{Loaded, load_text};
use crate::error::ConfigErrors;
use crate::error::KeyPath;
use crate::files::schema_of;
use crate::method::check_method;
use crate::overrides::Override;
use crate::scene::Scene;
use crate::scene::{Feature, Quantity};
use crate::schema::Kind;
use crate::vessel_body::read_bodies;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::Path;

/// Reads a scene from a text, with values that take the place of some in it; `file` is the name that complaints use. Vessels that bodies
/// name are read from the folder `vessels` beside that of the file.
pub fn read_scene(
    text: &str,
    file: &str,
    overrides: &[Override],
) -> Result<Loaded<Scene>, ConfigErrors> {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    read_scene_with(text, file, overrides, &folder.join("../vessels"))
}

/// The same with the vessels in a folder.
pub fn read_scene_with(
    text: &str,
    file: &str,
    overrides: &[Override],
    vessels: &Path,
) -> Result<Loaded<Scene>, ConfigErrors> {
    let schema = schema_of::<Scene>("scene");
    let mut reading = read_bodies(text, file, &schema, overrides, vessels)?;
    check(&mut reading);
    reading.finish()
}

/// Reads the scene at `path`.
pub fn load_scene(path: &Path, overrides: &[Override]) -> Result<Loaded<Scene>, ConfigErrors> {
    let text = load_text(path, "a scene (config/scenes/NAME.toml)")?;
    read_scene(&text, &path.display().to_string(), overrides)
}

/// Complains about all that is wrong in a scene that was read by its schema.
fn check(reading: &mut Reading) {
    let root = KeyPath::root();
    let names = texts(reading.value(), "probe", "name");
    unique(reading, &root, &names, "probe", "name");
    check_names(reading);
    check_run(reading);
    check_method(reading, &root.key("method"));
    check_bodies(reading);
    check_held(reading);
    check_scene_tools(reading);
    check_rigid(reading);
    check_contacts(reading);
    check_cuts(reading);
    check_probes(reading);
    check_expectations(reading);
}

/// Bodies, tools and obstacles: pairs and probes name them, so no two have the same name.
fn check_names(reading: &mut Reading) {
    let mut taken: Vec<String> = Vec::new();
    for list in ["body", "tool", "rigid"] {
        for (i, name) in texts(reading.value(), list, "name") {
            if taken.contains(&name) {
                let key = KeyPath::root().key(list).at(i).key("name");
                reading.complain(
                    &key,
                    &format!("`{name}` a second time"),
                    "a name that no other body, tool or obstacle has",
                );
            }
            taken.push(name);
        }
    }
}

fn check_run(reading: &mut Reading) {
    let run = KeyPath::root().key("run");
    let rests = reading.value()["run"]["end"] == "rest";
    let key = run.key("rest_speed");
    match (rests, reading.is_written(&key)) {
        (true, false) => reading.complain(
            &key,
            "nothing",
            "`rest_speed`, by which `end = \"rest\"` is decided",
        ),
        (false, true) => reading.complain(
            &key,
            "`rest_speed`",
            "no `rest_speed`, as the scene does not end at rest",
        ),
        _ => {}
    }
    if reading.value()["run"]["end"] == "divergence"
        && reading.value()["run"]["containment"] == true
    {
        reading.complain(
            &run.key("containment"),
            "a scene that is to diverge",
            "no `containment`, which rolls bodies back that do",
        );
    }
    let search = reading.value()["run"]["broad_phase"].clone();
    check_broad_phase(reading, &run, &search);
}

fn check_probes(reading: &mut Reading) {
    let bodies = texts(reading.value(), "body", "name");
    let bodies: Vec<&str> = bodies.iter().map(|(_, name)| name.as_str()).collect();
    for (i, body) in texts(reading.value(), "probe", "body") {
        let key = KeyPath::root().key("probe").at(i);
        refers(reading, &key.key("body"), &body, "a body", &bodies);
        check_box(reading, &key.key("nodes"));
    }
    for (i, quantity) in texts(reading.value(), "probe", "quantity") {
        let key = KeyPath::root().key("probe").at(i);
        let (directed, about, paired) = match quantity.as_str() {
            "displacement" | "centre" | "force" => (true, false, false),
            "contact-force" | "gap" => (true, false, true),
            "crossings" | "grip" => (false, false, true),
            "radius" | "torque" => (false, true, false),
            _ => (false, false, false),
        };
        for (name, needed, allowed) in [
            ("direction", directed, directed),
            ("axis", about, about),
            ("point", false, about),
            ("with", paired, paired),
        ] {
            let key = key.key(name);
            match (reading.is_written(&key), needed, allowed) {
                (false, true, _) => {
                    let expected = format!("`{name}`, which a {quantity} needs");
                    reading.complain(&key, "nothing", &expected);
                }
                (true, _, false) => {
                    let expected = format!("no `{name}`, which a {quantity} does not have");
                    reading.complain(&key, &format!("`{name}`"), &expected);
                }
                _ => {}
            }
        }
        check_with(reading, &key, &quantity);
        let nodes = key.key("nodes");
        if matches!(
            quantity.as_str(),
            "volume"
                | "smallest-volume"
                | "energy"
                | "contact-force"
                | "grip"
                | "crossings"
                | "pieces"
        ) && reading.is_written(&nodes)
        {
            let expected = format!("no `nodes`, as the {quantity} is that of the body");
            reading.complain(&nodes, "`nodes`", &expected);
        }
    }
}

/// The other side of a probe is there, and a contact-force is that of a pair.
fn check_with(reading: &mut Reading, key: &KeyPath, quantity: &str) {
    let text = |name: &str| {
        let value = reading.value_at(&key.key(name));
        value.and_then(|value| value.as_str()).map(str::to_owned)
    };
    let (Some(body), Some(with)) = (text("body"), text("with")) else {
        return;
    };
    if !matches!(quantity, "contact-force" | "grip") {
        let bodies = texts(reading.value(), "body", "name");
        let bodies: Vec<&str> = bodies.iter().map(|(_, name)| name.as_str()).collect();
        refers(reading, &key.key("with"), &with, "a body", &bodies);
        return;
    }
    let touches = items(reading.value(), "contact").any(|(_, pair)| {
        let own = pair["body"] == body.as_str();
        let other = ["tool", "rigid", "with"]
            .iter()
            .any(|field| pair[field] == with.as_str());
        let turned = pair["body"] == with.as_str() && pair["with"] == body.as_str();
        (own && other) || turned
    });
    if !touches {
        let expected = format!("a tool, obstacle or body that `{body}` touches by a [[contact]]");
        reading.complain(&key.key("with"), &format!("`{with}`"), &expected);
    }
}

/// Values are read in the unit of what is expected.
fn check_expectations(reading: &mut Reading) {
    let probes = texts(reading.value(), "probe", "name");
    let names: Vec<&str> = probes.iter().map(|(_, name)| name.as_str()).collect();
    let quantity = |reading: &Reading, probe: &str| -> Option<Quantity> {
        let (index, _) = probes.iter().find(|(_, name)| name == probe)?;
        typed(&reading.value()["probe"][*index]["quantity"])
    };
    let expectations: Vec<Value> = items(reading.value(), "expect")
        .map(|(_, e)| e.clone())
        .collect();
    for (i, expect) in expectations.iter().enumerate() {
        let key = KeyPath::root().key("expect").at(i);
        let Some(probe) = expect["probe"].as_str() else {
            continue;
        };
        refers(reading, &key.key("probe"), probe, "a probe", &names);
        let feature: Option<Feature> = typed(&expect["what"]);
        let unit = quantity(reading, probe)
            .zip(feature)
            .map(|(q, f)| f.unit(q));
        // Without a unit something else is wrong already.
        let Some(unit) = unit else { continue };
        let any = Kind::quantity(unit, f64::NEG_INFINITY, f64::INFINITY);
        let value = reading.refine(&key.key("value"), &any);
        let scale = reading.refine(&key.key("scale"), &Kind::quantity(unit, 0.0, f64::INFINITY));
        if value.and_then(|v| v.as_f64()) == Some(0.0) && !reading.is_written(&key.key("scale")) {
            let expected = "`scale`, as no error is relative to an expected 0";
            reading.complain(&key.key("scale"), "nothing", expected);
        }
        if scale.and_then(|s| s.as_f64()) == Some(0.0) {
            reading.complain(&key.key("scale"), "0", "a scale above 0");
        }
    }
}

/// A choice as its type.
fn typed<T: DeserializeOwned>(value: &Value) -> Option<T> {
    serde_json::from_value(value.clone()).ok()
}
