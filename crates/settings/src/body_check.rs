//! What bodies must fulfil beyond their single values: what their generator, law and form need is there, and nothing else.

use crate::body::MAX_ELEMENTS;
use crate::check::items;
use crate::document::Reading;
use crate::error::KeyPath;
use crate::schema::Kind;
use microsim_vocabulary::{Discretisation, LawName, Unit};
use serde_json::Value;
use std::collections::BTreeSet;

/// A key with those who may have it, and those who need it.
struct Rule {
    key: &'static str,
    of: &'static [&'static str],
    needed: &'static [&'static str],
}

const fn needed(key: &'static str, of: &'static [&'static str]) -> Rule {
    Rule {
        key,
        of,
        needed: of,
    }
}

const fn allowed(key: &'static str, of: &'static [&'static str]) -> Rule {
    Rule {
        key,
        of,
        needed: &[],
    }
}

/// Keys of the generators.
const GENERATOR: [Rule; 16] = [
    needed("size", &["block"]),
    needed("cells", &["block"]),
    allowed("vessel", &["tube"]),
    needed("inner_radius", &["tube"]),
    Rule {
        key: "layer",
        of: &["block", "tube"],
        needed: &["tube"],
    },
    needed("length", &["tube"]),
    needed("around", &["tube"]),
    needed("along", &["tube"]),
    allowed("axis", &["tube"]),
    allowed("arc", &["tube"]),
    allowed("arc_start", &["tube"]),
    allowed("axial_stretch", &["tube"]),
    allowed("transmural_pressure", &["tube"]),
    allowed("split", &["block", "tube"]),
    needed("file", &["file"]),
    allowed("scale", &["file"]),
];

/// The laws of continua.
const CONTINUUM: &[&str] = &LawName::NAMES;

/// The laws of continua with fibres.
const FIBRES: &[&str] = &[
    LawName::TransverselyIsotropic.name(),
    LawName::HolzapfelGasserOgden.name(),
    LawName::HolzapfelGasserOgdenIsochoric.name(),
];

/// Keys that all forms of springs have, and a continuum has not, and the reverse; those of single laws that may be left out.
const LAW: [Rule; 3] = [
    allowed("fibres", FIBRES),
    allowed("discretisation", CONTINUUM),
    allowed("form", &["springs"]),
];

/// Keys of the forms of springs; a continuum counts as a form here.
const FORM: [Rule; 11] = [
    needed("youngs_modulus", &["fitted", "continuum"]),
    needed("poisson_ratio", &["fitted", "continuum"]),
    needed("stretch_modulus", &["scaled"]),
    allowed("area_modulus", &["scaled"]),
    allowed("volume_modulus", &["scaled"]),
    needed("length_stiffness", &["plain", "normalised"]),
    allowed("area_stiffness", &["plain", "normalised"]),
    allowed("volume_stiffness", &["plain", "normalised"]),
    allowed("length_damping", &["plain", "normalised"]),
    allowed("area_damping", &["plain", "normalised"]),
    allowed("volume_damping", &["plain", "normalised"]),
];

/// Complains about bodies that have no one place of rest, under a method that looks for it.
pub(crate) fn check_held(reading: &mut Reading) {
    if reading.value()["method"]["name"] != "quasi-static" {
        return;
    }
    let held = |(_, clamp): (usize, &Value)| clamp["release"].is_null();
    // What it touches may hold it; whether it does, is found when it is solved.
    let touches = |body: &Value| {
        items(reading.value(), "contact")
            .any(|(_, pair)| pair["body"] == body["name"] || pair["with"] == body["name"])
    };
    let loose: Vec<usize> = items(reading.value(), "body")
        .filter(|(_, body)| !items(body, "clamp").any(held) && !touches(body))
        .map(|(b, _)| b)
        .collect();
    for b in loose {
        let key = KeyPath::root().key("body").at(b).key("clamp");
        // A clamp that is wrong has its complaint already.
        if !reading.is_written(&key.at(0))
            || reading.value_at(&key.at(0)).is_some_and(|c| !c.is_null())
        {
            reading.complain(
                &key,
                "no clamp that stays closed",
                "one at least: quasi-static looks for the one place of rest, and a loose body has none; or another method",
            );
        }
    }
}

/// Complains about all that is wrong in the bodies of a file.
pub(crate) fn check_bodies(reading: &mut Reading) {
    let bodies: Vec<Value> = items(reading.value(), "body")
        .map(|(_, b)| b.clone())
        .collect();
    for (b, body) in bodies.iter().enumerate() {
        let key = KeyPath::root().key("body").at(b);
        if let Some(generator) = body["generator"].as_str() {
            let whose = format!("a body from a {generator}");
            apply(reading, &key, &GENERATOR, generator, &whose);
            match body["file"].as_str() {
                // A file that is named wrongly has its complaint already.
                None if reading.is_written(&key.key("file")) => {}
                file => check_fill(reading, &key, file.map(is_surface)),
            }
            if generator != "block" && reading.is_written(&key.key("arc_start")) {
                needs(reading, &key, "arc_start", "arc");
            }
            if reading.is_written(&key.key("filling")) {
                needs(reading, &key, "filling", "fill");
            }
            check_size(reading, &key, body);
        }
        for (r, _) in items(body, "refine") {
            check_refine(reading, &key.key("refine").at(r));
        }
        for (m, material) in items(body, "material") {
            let key = key.key("material").at(m);
            check_material(reading, &key, material);
            check_fibres(reading, &key, body, material);
        }
        check_regions(reading, &key, body);
        for (c, clamp) in items(body, "clamp") {
            let key = key.key("clamp").at(c);
            check_nodes(reading, &key.key("nodes"), true);
            check_motion(reading, &key, clamp);
        }
        for (l, _) in items(body, "load") {
            let key = key.key("load").at(l);
            check_nodes(reading, &key.key("surface"), false);
            let written = ["pressure", "traction"].map(|k| reading.is_written(&key.key(k)));
            match written {
                [true, true] => reading.complain(&key, "a pressure and a traction", "one of them"),
                [false, false] => {
                    reading.complain(&key, "a load without value", "`pressure` or `traction`")
                }
                _ => {}
            }
        }
        for (s, _) in items(body, "start") {
            check_nodes(reading, &key.key("start").at(s).key("nodes"), false);
        }
        for (c, coupling) in items(body, "coupling") {
            let regions = ["from", "to"].map(|end| coupling[end].as_u64());
            if regions[0].is_some() && regions[0] == regions[1] {
                let key = key.key("coupling").at(c).key("to");
                reading.complain(&key, "the same region", "another region than `from`");
            }
            check_coupling(reading, &key.key("coupling").at(c), coupling);
        }
    }
}

/// A coupling holds, slides or clings; one that clings takes at least the energy that it stores at its strength.
fn check_coupling(reading: &mut Reading, key: &KeyPath, coupling: &Value) {
    const KINDS: [&str; 3] = ["break_distance", "friction", "strength"];
    let written: Vec<&str> = KINDS
        .into_iter()
        .filter(|kind| reading.is_written(&key.key(kind)))
        .collect();
    if let [first, second, ..] = written[..] {
        let found = format!("`{second}` besides `{first}`");
        let expected = "one of `break_distance` (holds), `friction` (slides) and `strength` with `energy` (clings)";
        reading.complain(&key.key(second), &found, expected);
        return;
    }
    if reading.is_written(&key.key("shear_strength")) {
        needs(reading, key, "shear_strength", "friction");
    }
    match ["strength", "energy"].map(|name| reading.is_written(&key.key(name))) {
        [true, false] => needs(reading, key, "strength", "energy"),
        [false, true] => needs(reading, key, "energy", "strength"),
        _ => {}
    }
    let value = |name: &str| coupling[name].as_f64();
    if let (Some(stiffness), Some(strength), Some(energy)) =
        (value("stiffness"), value("strength"), value("energy"))
    {
        let stored = 0.5 * strength * strength / stiffness;
        if energy < stored {
            let found = Unit::LengthStiffness.describe(energy);
            let expected = format!(
                "{} or more, what is stored at the strength: strength^2/(2 stiffness)",
                Unit::LengthStiffness.describe(stored)
            );
            reading.complain(&key.key("energy"), &found, &expected);
        }
    }
}

/// A part to be refined is a region, or within a radius of a point, segment or plane.
fn check_refine(reading: &mut Reading, key: &KeyPath) {
    let written = |name: &str| reading.is_written(&key.key(name));
    let (region, point) = (written("region"), written("point"));
    let (to, normal, radius) = (written("to"), written("normal"), written("radius"));
    if region {
        for name in ["point", "to", "normal", "radius"] {
            hold(reading, key, name, false, false, "a region to be refined");
        }
    } else if !(point || to || normal || radius) {
        let expected =
            "`point` with `radius` (and `to` for a segment, `normal` for a plane), or `region`";
        reading.complain(key, "no part of the body", expected);
    } else {
        for name in ["point", "radius"] {
            hold(reading, key, name, true, true, "a place to be refined");
        }
    }
    if to && normal {
        let found = "`to` and `normal`";
        reading.complain(
            &key.key("normal"),
            found,
            "one of them: a segment or a plane",
        );
    }
}

/// A generated body of a sensible number of elements: six in each cell.
fn check_size(reading: &mut Reading, key: &KeyPath, body: &Value) {
    let count = |value: &Value| value.as_f64().unwrap_or(1.0);
    let (name, cells) = match body["generator"].as_str() {
        Some("block") => (
            "cells",
            items(body, "cells").map(|(_, n)| count(n)).product::<f64>(),
        ),
        Some("tube") => {
            let through: f64 = items(body, "layer").map(|(_, l)| count(&l["cells"])).sum();
            let ring = count(&body["around"]) * count(&body["along"]);
            ("around", through * ring)
        }
        _ => return,
    };
    let elements = 6.0 * cells;
    if elements > MAX_ELEMENTS as f64 {
        let expected = format!("fewer cells: {MAX_ELEMENTS} tetrahedra at most");
        reading.complain(&key.key(name), &format!("{elements} tetrahedra"), &expected);
    }
}

/// Whether the ending of a file is that of a surface.
fn is_surface(file: &str) -> bool {
    let file = file.to_ascii_lowercase();
    file.ends_with(".obj") || file.ends_with(".stl")
}

fn check_fill(reading: &mut Reading, body: &KeyPath, surface: Option<bool>) {
    let key = body.key("fill");
    match (surface, reading.is_written(&key)) {
        (Some(true), false) => reading.complain(
            &key,
            "nothing",
            "`fill`, the size of the cells that fill a closed surface",
        ),
        (Some(false), true) => reading.complain(
            &key,
            "`fill`",
            "no `fill`, as the file holds tetrahedra already",
        ),
        (None, true) => reading.complain(&key, "`fill`", "no `fill` without a file to be filled"),
        _ => {}
    }
}

/// Holds the keys of a table to its rules; `which` is the generator, law or form.
fn apply(reading: &mut Reading, table: &KeyPath, rules: &[Rule], which: &str, whose: &str) {
    for rule in rules {
        let [own, needed] = [rule.of, rule.needed].map(|of| of.contains(&which));
        hold(reading, table, rule.key, own, needed, whose);
    }
}

/// Holds a key of a table to what it is to `whose`: its `own`, which may be `needed`, or not there.
fn hold(reading: &mut Reading, table: &KeyPath, name: &str, own: bool, needed: bool, whose: &str) {
    let key = table.key(name);
    match (own, reading.is_written(&key)) {
        (true, false) if needed => {
            reading.complain(&key, "nothing", &format!("`{name}`, which {whose} needs"));
        }
        (false, true) => {
            let expected = format!("no `{name}`, which {whose} does not have");
            reading.complain(&key, &format!("`{name}`"), &expected);
        }
        _ => {}
    }
}

/// Holds what the layer of a vessel at `layer` states of its material to its law, that of a continuum.
pub(crate) fn check_constants(reading: &mut Reading, layer: &KeyPath, law: &str) {
    let whose = format!("the law {law}");
    let material = layer.key("material");
    hold(reading, &material, "density", true, true, "a material");
    check_parameters(reading, &material, law, &whose);
    apply(reading, &material, &FORM, "continuum", &whose);
    let fibrous = FIBRES.contains(&law);
    hold(reading, layer, "fibre_angle", fibrous, true, &whose);
}

/// Holds the parameters of laws to the law of a material.
fn check_parameters(reading: &mut Reading, material: &KeyPath, law: &str, whose: &str) {
    let own = LawName::from_name(law).map_or(&[][..], LawName::parameters);
    let of_laws = LawName::ALL.into_iter().flat_map(LawName::parameters);
    let keys: BTreeSet<&str> = of_laws.map(|(key, _)| *key).collect();
    for name in keys {
        let own = own.iter().any(|(key, _)| *key == name);
        hold(reading, material, name, own, true, whose);
    }
}

fn needs(reading: &mut Reading, table: &KeyPath, one: &str, other: &str) {
    if !reading.is_written(&table.key(other)) {
        let expected = format!("`{other}` as well");
        reading.complain(&table.key(one), &format!("`{one}` alone"), &expected);
    }
}

fn check_material(reading: &mut Reading, key: &KeyPath, material: &Value) {
    reading.advise(
        &key.key("poisson_ratio"),
        "0.5 is incompressible, so take 0.49 with discretisation = \"selective\" or \"patch-pressure\"",
    );
    reading.advise(
        &key.key("youngs_modulus"),
        "what has no stiffness holds no shape; soft tissue has 1 kPa to 1 MPa",
    );
    let Some(law) = material["law"].as_str() else {
        return;
    };
    let whose = format!("the law {law}");
    check_parameters(reading, key, law, &whose);
    apply(reading, key, &LAW, law, &whose);
    let form = match law {
        "springs" => material["form"].as_str().unwrap_or("scaled"),
        _ => "continuum",
    };
    let whose = match law {
        "springs" => format!("the form {form} of springs"),
        _ => format!("the law {law}"),
    };
    apply(reading, key, &FORM, form, &whose);
    check_plasticity(reading, key, material, law);

    for (name, plain, normalised) in [
        ("length_stiffness", Unit::LengthStiffness, Unit::Energy),
        ("area_stiffness", Unit::AreaStiffness, Unit::Energy),
        ("volume_stiffness", Unit::VolumeStiffness, Unit::Energy),
        ("length_damping", Unit::LengthDamping, Unit::Action),
        ("area_damping", Unit::AreaDamping, Unit::Action),
        ("volume_damping", Unit::VolumeDamping, Unit::Action),
    ] {
        let unit = match form {
            "plain" => plain,
            "normalised" => normalised,
            _ => continue,
        };
        reading.refine(&key.key(name), &Kind::quantity(unit, 0.0, f64::INFINITY));
    }
    let poisson = material["poisson_ratio"].as_f64();
    if form == "fitted" && poisson.is_some_and(|poisson| poisson < 0.0) {
        let found = "a negative Poisson's ratio of fitted springs";
        reading.complain(
            &key.key("poisson_ratio"),
            found,
            "0 or more; below 0.25 they keep 0.25",
        );
    }

    let viscosity = key.key("viscosity");
    if reading.is_written(&viscosity) {
        if reading.is_written(&key.key("relaxation_time")) {
            let found = "`viscosity` and `relaxation_time`";
            reading.complain(&viscosity, found, "one of them");
        } else if matches!(form, "plain" | "normalised") {
            let found = format!("a viscosity of {form} springs, which have no modulus");
            reading.complain(&viscosity, &found, "`relaxation_time`");
        }
    }
}

/// Springs flow at a rate, and continua where flow leaves the pressure as it is.
fn check_plasticity(reading: &mut Reading, material_key: &KeyPath, material: &Value, law: &str) {
    let key = material_key.key("plasticity");
    if !reading.is_written(&key) {
        return;
    }
    let is_springs = law == "springs";
    hold(
        reading,
        &key,
        "creep_rate",
        true,
        is_springs,
        "the flow of springs",
    );
    hold(
        reading,
        &key,
        "yield_growth",
        !is_springs,
        false,
        "the flow of springs",
    );
    let discretisation = material["discretisation"].as_str();
    let split = discretisation.and_then(Discretisation::from_name);
    let split = split.filter(|discretisation| discretisation.is_split());
    let of_trace = LawName::from_name(law).filter(|law| !law.is_volumetric_of_j());
    if let (Some(split), Some(law)) = (split, of_trace) {
        let found = format!(
            "plastic flow of the law {} with the discretisation {}",
            law.name(),
            split.name()
        );
        let expected = "tetrahedra, edge-smoothed, node-smoothed or quadratic, or a law with a pressure of the volume alone: flow preserves the volume, not the pressure of this law, which the discretisation carries apart";
        reading.complain(&key, &found, expected);
    }
}

/// Fibre directions are given in one manner, and those of a generated body are given.
fn check_fibres(reading: &mut Reading, material_key: &KeyPath, body: &Value, material: &Value) {
    let key = material_key.key("fibres");
    if !reading.is_written(&key) {
        let from_file = body["generator"] == "file";
        if families(material) > 0 && !from_file {
            let expected = "`fibres`, as only a mesh file has directions of its own";
            reading.complain(&key, "nothing", expected);
        }
        return;
    }
    let names = ["direction", "angle", "axis", "point", "second_direction"];
    let [direction, angle, axis, point, second] =
        names.map(|name| reading.is_written(&key.key(name)));
    let two = families(material) == 2;
    if direction == angle {
        let found = match direction {
            true => "a direction and an angle",
            false => "neither a direction nor an angle",
        };
        reading.complain(&key, found, "one of `direction` and `angle`");
    } else if direction && (axis || point) {
        reading.complain(
            &key,
            "an axis beside a direction",
            "`angle` with it, or none",
        );
    } else if angle && !axis && body["generator"] != "tube" {
        let expected = "`axis` as well: only a tube has one of its own";
        reading.complain(&key.key("angle"), "`angle` alone", expected);
    } else if direction && two && !second {
        let expected = "`second_direction` as well: the law has two families of fibres";
        reading.complain(&key, "one direction", expected);
    } else if second && !(direction && two) {
        let expected = "it beside `direction`, of a law with two families of fibres";
        reading.complain(&key.key("second_direction"), "`second_direction`", expected);
    }
}

/// How many families of fibres the law of a material has.
fn families(material: &Value) -> usize {
    let law = material["law"].as_str().and_then(LawName::from_name);
    law.map_or(0, LawName::families)
}

/// Each region has one material; that without a region is for the rest.
fn check_regions(reading: &mut Reading, body: &KeyPath, value: &Value) {
    let regions: Vec<Option<u64>> = items(value, "material")
        .map(|(_, material)| material["region"].as_u64())
        .collect();
    for (m, region) in regions.iter().enumerate() {
        if regions[..m].contains(region) {
            let key = body.key("material").at(m);
            let found = match region {
                Some(region) => format!("a second material of region {region}"),
                None => "a second material without a region".to_owned(),
            };
            reading.complain(&key, &found, "one material per region");
        }
    }
}

/// A selection is at most one of a box, a shell and a node; `needed` is set where one of them has to be there.
fn check_nodes(reading: &mut Reading, key: &KeyPath, needed: bool) {
    check_box(reading, key);
    let written: Vec<&str> = ["min", "shell", "nearest"]
        .into_iter()
        .filter(|selection| reading.is_written(&key.key(selection)))
        .collect();
    match written.as_slice() {
        [] if needed && !reading.is_written(&key.key("max")) => reading.complain(
            key,
            "every node",
            "some of them: `min` and `max`, `shell` or `nearest`",
        ),
        [_, second, ..] => {
            let found = format!("`{second}` besides `{}`", written[0]);
            reading.complain(&key.key(second), &found, "one kind of selection here");
        }
        _ => {}
    }
}

/// The corners of a box come together, and in order; the distances of a shell too.
pub(crate) fn check_box(reading: &mut Reading, key: &KeyPath) {
    let [min, max] = ["min", "max"].map(|corner| key.key(corner));
    match (reading.is_written(&min), reading.is_written(&max)) {
        (true, false) => needs(reading, key, "min", "max"),
        (false, true) => needs(reading, key, "max", "min"),
        _ => {}
    }
    let value = |path: &KeyPath| reading.value_at(path).cloned().unwrap_or_default();
    let (low, high) = (value(&min), value(&max));
    let outside = (0..3).any(|axis| {
        let corners = low[axis].as_f64().zip(high[axis].as_f64());
        corners.is_some_and(|(low, high)| low > high)
    });
    let radius = key.key("shell").key("radius");
    let distances = value(&radius);
    let turned = distances[0]
        .as_f64()
        .zip(distances[1].as_f64())
        .is_some_and(|(low, high)| low > high);
    if outside {
        reading.complain(
            &max,
            "a region that is empty",
            "no coordinate of `max` below that of `min`",
        );
    }
    if turned {
        reading.complain(
            &radius,
            "a shell that is empty",
            "the smaller distance first",
        );
    }
}

/// Times ascend, and what lets go does not move on.
fn check_motion(reading: &mut Reading, key: &KeyPath, clamp: &Value) {
    let times: Vec<(usize, f64)> = items(clamp, "motion")
        .filter_map(|(k, at)| Some((k, at["time"].as_f64()?)))
        .collect();
    for pair in times.windows(2) {
        if pair[1].1 <= pair[0].1 {
            let found = Unit::Time.describe(pair[1].1);
            let key = key.key("motion").at(pair[1].0).key("time");
            reading.complain(&key, &found, "a time after that of the key before");
        }
    }
    let last = times.last().map(|(_, time)| *time);
    let release = clamp["release"].as_f64();
    if let Some((release, last)) = release.zip(last).filter(|(release, last)| release < last) {
        let found = Unit::Time.describe(release);
        let expected = format!(
            "a time that is not before the last key of the motion, {}",
            Unit::Time.describe(last)
        );
        reading.complain(&key.key("release"), &found, &expected);
    }
}
