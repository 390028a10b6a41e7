//! What a scene must fulfil beyond its single values: names, references, times that fit, probes that can be measured.

use crate::body_check::{check_bodies, check_box, check_held};
use crate::check::{items, refers, texts, unique};
use crate::document::Reading;
use crate::error::KeyPath;
use crate::method::check_method;
use crate::scene::{Feature, Quantity};
use crate::schema::Kind;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Complains about all that is wrong in a scene that was read by its schema.
pub(crate) fn check(reading: &mut Reading) {
    let root = KeyPath::root();
    for list in ["body", "probe"] {
        let names = texts(reading.value(), list, "name");
        unique(reading, &root, &names, list, "name");
    }
    check_run(reading);
    check_method(reading, &root.key("method"));
    check_bodies(reading);
    check_held(reading);
    check_probes(reading);
    check_expectations(reading);
}

fn check_run(reading: &mut Reading) {
    let run = KeyPath::root().key("run");
    let rests = reading.value()["run"]["end"] == "rest";
    let key = run.key("rest_speed");
    match (rests, reading.is_written(&key)) {
        (true, false) => reading.complain(
            &key,
            "nothing",
            "`rest_speed`, by which `end = \"rest\"` is judged",
        ),
        (false, true) => reading.complain(
            &key,
            "`rest_speed`",
            "no `rest_speed`, as the scene ends by time",
        ),
        _ => {}
    }
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
        let (directed, about) = match quantity.as_str() {
            "displacement" | "centre" | "force" => (true, false),
            "radius" | "torque" => (false, true),
            _ => (false, false),
        };
        for (name, needed, allowed) in [
            ("direction", directed, directed),
            ("axis", about, about),
            ("point", false, about),
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
        let nodes = key.key("nodes");
        if matches!(quantity.as_str(), "volume" | "smallest-volume" | "energy")
            && reading.is_written(&nodes)
        {
            let expected = format!("no `nodes`, as the {quantity} is that of the body");
            reading.complain(&nodes, "`nodes`", &expected);
        }
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
            let expected = "`scale`, as an error is no share of an expected 0";
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
