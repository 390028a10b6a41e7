//! What pairs, obstacles and tools of scenes must fulfil beyond their single values.

use crate::check::{items, refers, texts, unique};
use crate::document::Reading;
use crate::error::KeyPath;
use crate::tool::check_jaws;
use microsim_vocabulary::{Discretisation, Unit};
use serde_json::Value;

/// Sizes of obstacles: which shape needs them, and which may have them.
const SIZES: [(&str, &[&str], bool); 6] = [
    ("half_size", &["box", "tray", "clamp"], true),
    ("rounding", &["box", "tray", "clamp"], false),
    ("wall", &["tray"], true),
    ("gap", &["clamp"], true),
    ("radius", &["cylinder"], true),
    ("length", &["cylinder"], true),
];

/// Complains about a cell size without cells; `table` is the one with the broad phase.
pub(crate) fn check_broad_phase(reading: &mut Reading, table: &KeyPath, search: &Value) {
    let key = table.key("cell_size");
    if reading.is_written(&key) && *search != "spatial-hash" {
        reading.complain(
            &key,
            "`cell_size`",
            "no `cell_size`, which is of `broad_phase = \"spatial-hash\"`",
        );
    }
}

/// Complains about obstacles whose sizes do not fit their shape.
pub(crate) fn check_rigid(reading: &mut Reading) {
    for (i, shape) in texts(reading.value(), "rigid", "shape") {
        let obstacle = KeyPath::root().key("rigid").at(i);
        for (size, of, needed) in SIZES {
            let key = obstacle.key(size);
            match (of.contains(&shape.as_str()), reading.is_written(&key)) {
                (true, false) if needed => {
                    reading.complain(&key, "nothing", &format!("`{size}`, which a {shape} needs"));
                }
                (false, true) => reading.complain(
                    &key,
                    &format!("`{size}`"),
                    &format!("no `{size}`, as the obstacle is a {shape}"),
                ),
                _ => {}
            }
        }
        let value = reading.value()["rigid"][i].clone();
        let rounding = value["rounding"].as_f64().unwrap_or_default();
        // Walls are boxes too: what is thinnest bounds the rounding.
        let sides = value["half_size"].as_array().into_iter().flatten();
        let sides = sides.filter_map(Value::as_f64);
        let thinnest = sides
            .chain(value["wall"].as_f64().map(|wall| 0.5 * wall))
            .fold(f64::INFINITY, f64::min);
        if rounding > thinnest {
            let expected = format!(
                "at most half of the thinnest side, {}",
                Unit::Length.describe(thinnest)
            );
            reading.complain(
                &obstacle.key("rounding"),
                &Unit::Length.describe(rounding),
                &expected,
            );
        }
    }
}

/// Complains about pairs that are none: nobody or several on the other side, unknown names, the same two again.
pub(crate) fn check_contacts(reading: &mut Reading) {
    let known = ["tool", "rigid", "body"].map(|list| texts(reading.value(), list, "name"));
    let [tools, rigid, bodies] = &known;
    for (field, item, known) in [
        ("tool", "a tool", tools),
        ("rigid", "an obstacle", rigid),
        ("body", "a body", bodies),
        ("with", "a body", bodies),
    ] {
        let known: Vec<&str> = known.iter().map(|(_, name)| name.as_str()).collect();
        for (i, name) in texts(reading.value(), "contact", field) {
            let key = KeyPath::root().key("contact").at(i).key(field);
            refers(reading, &key, &name, item, &known);
        }
    }
    let pairs: Vec<(usize, Value)> = items(reading.value(), "contact")
        .filter(|(_, pair)| !pair.is_null())
        .map(|(i, pair)| (i, pair.clone()))
        .collect();
    let mut seen: Vec<[String; 3]> = Vec::new();
    for (i, pair) in &pairs {
        let key = KeyPath::root().key("contact").at(*i);
        let mut partners: Vec<&str> = ["tool", "rigid", "with"]
            .into_iter()
            .filter(|field| reading.is_written(&key.key(field)))
            .collect();
        if pair["self"] == true {
            partners.push("self");
        }
        match partners.as_slice() {
            [_] => {}
            [] => reading.complain(
                &key,
                "a body that touches nothing",
                "one of `tool`, `rigid`, `with` and `self = true`",
            ),
            several => {
                let quoted: Vec<String> = several.iter().map(|p| format!("`{p}`")).collect();
                reading.complain(
                    &key,
                    &quoted.join(" and "),
                    "one of them: a pair has two sides",
                );
            }
        }
        if pair["end_planes"] == true && !partners.contains(&"with") {
            reading.complain(
                &key.key("end_planes"),
                "`end_planes`",
                "no `end_planes`, which are those of two vessels",
            );
        }
        check_response(reading, &key, pair);
        check_grip(reading, &key, pair);
        let (body, with) = (pair["body"].as_str(), pair["with"].as_str());
        if body.is_some() && body == with {
            let found = format!("`{}` itself", body.unwrap_or_default());
            reading.complain(&key.key("with"), &found, "another body, or `self = true`");
        }
        let Some(body) = body else { continue };
        let partner = partners.first().copied().unwrap_or_default();
        let other = pair[partner].as_str().unwrap_or_default();
        // Two bodies are the same pair from either side.
        let (one, two) = match partner == "with" && other < body {
            true => (other, body),
            false => (body, other),
        };
        let names = [partner, one, two].map(str::to_owned);
        if !partner.is_empty() && seen.contains(&names) {
            reading.complain(&key, "the same pair a second time", "each pair once");
        }
        seen.push(names);
    }
}

/// Complains about a stiffness or depth that the response of a pair has not, or lacks.
fn check_response(reading: &mut Reading, pair: &KeyPath, value: &Value) {
    let response = value["response"].as_str().unwrap_or_default().to_owned();
    let is_penalty = response == "penalty";
    let stiffness = pair.key("stiffness");
    match (is_penalty, reading.is_written(&stiffness)) {
        (true, false) => {
            reading.complain(&stiffness, "nothing", "`stiffness`, which a penalty needs")
        }
        (false, true) => reading.complain(
            &stiffness,
            "`stiffness`",
            "no `stiffness`, which is that of a penalty",
        ),
        _ => {}
    }
    let depth = pair.key("depth");
    if response == "constraint" && reading.is_written(&depth) {
        reading.complain(
            &depth,
            "`depth`",
            "no `depth`: a constraint is found along the whole step",
        );
    }
    let friction = value["friction"].as_f64().unwrap_or_default();
    if !["constraint", ""].contains(&response.as_str()) && friction > 0.0 {
        reading.complain(
            &pair.key("friction"),
            "friction",
            &format!("no friction, which `{response}` does not know"),
        );
    }
}

/// Complains about a box grip of what has no jaws.
fn check_grip(reading: &mut Reading, pair: &KeyPath, value: &Value) {
    let key = pair.key("grip");
    if value["grip"] != "box" {
        return;
    }
    let Some(tool) = value["tool"].as_str() else {
        reading.complain(
            &key,
            "`box`",
            "`box` with `tool` alone, whose jaws hold the body",
        );
        return;
    };
    let tools = texts(reading.value(), "tool", "name");
    let place = tools.iter().find(|(_, name)| name == tool).map(|(i, _)| *i);
    let of = place.map(|i| &reading.value()["tool"][i]);
    // The jaws of a model stand in its own file.
    let has_lines = of.is_none_or(|of| {
        let line = |jaw: &str| {
            items(of, "capsule").any(|(_, part)| part["jaw"] == jaw && part["lonor"] == true)
        };
        !of["model"].is_null() || (line("left") && line("right"))
    });
    if !has_lines {
        let expected = format!(
            "`friction`, as `{tool}` has no line of no return in each of two jaws: there is no box between them"
        );
        reading.complain(&key, "`box`", &expected);
    }
}

/// Complains about tissue that is to get over a line to which contact does not let it.
fn check_triggers(reading: &mut Reading) {
    let mut wrong = Vec::new();
    for (i, cut) in items(reading.value(), "cut").filter(|(_, cut)| cut["trigger"] == "penetration")
    {
        let of_both = |pair: &&Value| pair["body"] == cut["body"] && pair["tool"] == cut["tool"];
        let pair = items(reading.value(), "contact")
            .map(|(_, pair)| pair)
            .find(of_both);
        let reason = match pair {
            None => "`force`: the two do not touch each other, and the lines go through the body",
            Some(pair) if pair["response"] == "constraint" => {
                "`force`: contact by `constraint` lets no tissue into the capsule, so none comes to its line"
            }
            Some(_) => continue,
        };
        wrong.push((KeyPath::root().key("cut").at(i).key("trigger"), reason));
    }
    for (key, reason) in wrong {
        reading.complain(&key, "`penetration`", reason);
    }
}

/// Complains about cuts of obstacles, which are rigid.
fn check_rigid_cuts(reading: &mut Reading) {
    let rigid = texts(reading.value(), "rigid", "name");
    for (i, name) in texts(reading.value(), "cut", "body") {
        if rigid.iter().any(|(_, obstacle)| *obstacle == name) {
            let key = KeyPath::root().key("cut").at(i).key("body");
            let expected = "a body: what is rigid has no elements that could be divided";
            reading.complain(&key, &format!("the obstacle `{name}`"), expected);
        }
    }
}

/// Complains about cuts by or of what is not there, and about the same two again.
pub(crate) fn check_cuts(reading: &mut Reading) {
    check_rigid_cuts(reading);
    check_triggers(reading);
    for (field, item) in [("tool", "a tool"), ("body", "a body")] {
        let known = texts(reading.value(), field, "name");
        let known: Vec<&str> = known.iter().map(|(_, name)| name.as_str()).collect();
        let rigid = texts(reading.value(), "rigid", "name");
        let named = texts(reading.value(), "cut", field);
        for (i, name) in named {
            if field == "body" && rigid.iter().any(|(_, obstacle)| *obstacle == name) {
                continue;
            }
            let key = KeyPath::root().key("cut").at(i).key(field);
            refers(reading, &key, &name, item, &known);
        }
    }
    check_cut_bodies(reading);
    let cuts: Vec<(usize, Value)> = items(reading.value(), "cut")
        .map(|(i, cut)| (i, cut.clone()))
        .collect();
    for (at, (i, cut)) in cuts.iter().enumerate() {
        let same = |earlier: &Value| {
            ["body", "tool"]
                .iter()
                .all(|side| earlier[side] == cut[side])
        };
        if cuts[..at].iter().any(|(_, earlier)| same(earlier)) {
            let key = KeyPath::root().key("cut").at(*i);
            reading.complain(&key, "the same pair a second time", "each pair once");
        }
    }
}

/// Complains about bodies that are cut, or tear, with a discretisation that is not.
fn check_cut_bodies(reading: &mut Reading) {
    let mut wrong = Vec::new();
    for (b, body) in items(reading.value(), "body") {
        let cut = items(reading.value(), "cut").any(|(_, cut)| cut["body"] == body["name"]);
        let tears = items(body, "material").any(|(_, m)| !m["tear_strain"].is_null());
        for (m, material) in items(body, "material").filter(|_| cut || tears) {
            let name = material["discretisation"].as_str().unwrap_or_default();
            if Discretisation::from_name(name).is_some_and(Discretisation::is_quadratic) {
                let key = KeyPath::root().key("body").at(b).key("material").at(m);
                wrong.push((
                    key.key("discretisation"),
                    format!("`{name}` of a body that is cut or tears"),
                ));
            }
        }
    }
    for (key, found) in wrong {
        let expected = "another one, as the eight parts of a quadratic tetrahedron belong together: `selective` or `edge-smoothed`";
        reading.complain(&key, &found, expected);
    }
}

/// Complains about tools of a scene with no shape or two, and with motions that do not go forward.
pub(crate) fn check_scene_tools(reading: &mut Reading) {
    let tools: Vec<(usize, Value)> = items(reading.value(), "tool")
        .map(|(i, tool)| (i, tool.clone()))
        .collect();
    for (i, tool) in &tools {
        let key = KeyPath::root().key("tool").at(*i);
        let capsules = reading.is_written(&key.key("capsule"));
        match (reading.is_written(&key.key("model")), capsules) {
            (false, false) => reading.complain(
                &key,
                "a tool without a shape",
                "`model`, or capsules of its own",
            ),
            (true, true) => {
                reading.complain(&key.key("capsule"), "`capsule` and `model`", "one of them")
            }
            _ => {}
        }
        if reading.is_written(&key.key("model")) {
            for field in ["hinge", "opening_angle", "sharpness", "irrigation"] {
                let key = key.key(field);
                if reading.is_written(&key) {
                    let expected = format!("no `{field}`, which the model has");
                    reading.complain(&key, &format!("`{field}`"), &expected);
                }
            }
        } else {
            let names = texts(tool, "capsule", "name");
            unique(reading, &key, &names, "capsule", "name");
            check_jaws(reading, &key);
        }
        check_tool_motion(reading, &key, tool);
    }
}

fn check_tool_motion(reading: &mut Reading, tool: &KeyPath, value: &Value) {
    let mut latest = f64::NEG_INFINITY;
    for (k, at) in items(value, "motion") {
        let key = tool.key("motion").at(k);
        if let Some(time) = at["time"].as_f64() {
            if time <= latest {
                let expected = format!(
                    "a time after that of the key before, {}",
                    Unit::Time.describe(latest)
                );
                reading.complain(&key.key("time"), &Unit::Time.describe(time), &expected);
            }
            latest = time;
        }
        let [orientation, axis, angle] =
            ["orientation", "axis", "angle"].map(|field| reading.is_written(&key.key(field)));
        if axis != angle {
            let (there, missing) = if axis {
                ("axis", "angle")
            } else {
                ("angle", "axis")
            };
            reading.complain(
                &key.key(there),
                &format!("`{there}` without `{missing}`"),
                "both or neither",
            );
        }
        if orientation && (axis || angle) {
            reading.complain(
                &key.key("orientation"),
                "`orientation` besides `axis` and `angle`",
                "one of them",
            );
        }
    }
}
