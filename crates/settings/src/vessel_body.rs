//! Bodies of scenes and levels that name a vessel.
//!
//! What such a body, a tube, does not state itself comes from its vessel: axial stretch, radius of the lumen, toughness, thickness, opening
//! angle, region and material of each layer. It is put into the tree of the file before that is read by its schema, so it is held to the
//! same rules, and everything behind the settings sees a body that states all of it.
//!
//! Radius and thicknesses of a vessel are those at its axial stretch without pressure. A body with another stretch or a pressure states
//! sizes of its own; they are not computed here.

use crate::document::{Reading, sorted};
use crate::error::{ConfigError, ConfigErrors, KeyPath, Position};
use crate::overrides::Override;
use crate::schema::{Form, Schema};
use crate::tree::{Entry, Item, Node};
use crate::vessel::{Vessel, VesselLayer, load_vessel};
use microsim_vocabulary::Discretisation;
use std::path::Path;

/// Reads a scene or level by its schema, with what its bodies have from the vessels in a folder, and with values that take the place of some
/// in both; those that name another vessel come first. Fails at once if the text is no TOML, or a vessel cannot be used: a body without its
/// vessel lacks much, and that it has none is what is wrong.
pub(crate) fn read_bodies(
    text: &str,
    file: &str,
    schema: &Schema,
    overrides: &[Override],
    vessels: &Path,
) -> Result<Reading, ConfigErrors> {
    let mut root = Node::parse(text, file).map_err(sorted)?;
    let apply = |root: &mut Node, of_vessels: bool| {
        let chosen = overrides.iter().enumerate();
        chosen
            .filter(|(_, value)| value.is_of_key("vessel") == of_vessels)
            .try_for_each(|(index, value)| value.apply(root, index))
            .map_err(|error| ConfigErrors(vec![error]))
    };
    apply(&mut root, true)?;
    let mut errors = apply_vessels(&mut root, file, vessels);
    apply(&mut root, false)?;
    errors.extend(sizes_of_another_state(&root, file));
    let reading = Reading::of_tree(root, text, file, schema, overrides);
    match errors.is_empty() {
        true => Ok(reading),
        false => Err(reading.refuse(errors)),
    }
}

/// Puts what vessels in `folder` state into the bodies of a scene or level that name them and do not state it themselves; `file` is the
/// name that complaints use.
fn apply_vessels(root: &mut Node, file: &str, folder: &Path) -> Vec<ConfigError> {
    let mut errors = Vec::new();
    let Some(Item::List(bodies)) = root.item_mut("body") else {
        return errors;
    };
    for (b, body) in bodies.iter_mut().enumerate() {
        let Some(Node {
            at,
            item: Item::Text(name),
        }) = body.item_of("vessel")
        else {
            continue;
        };
        // What is no name has its complaint from the schema.
        if !Form::Identifier.accepts(name) {
            continue;
        }
        let (at, name) = (*at, name.clone());
        let key = KeyPath::root().key("body").at(b).key("vessel");
        let complain = |found: String, expected: String| ConfigError {
            file: file.to_owned(),
            position: Some(at),
            key: key.clone(),
            found,
            expected,
        };
        let path = folder.join(&name).with_extension("toml");
        match load_vessel(&path) {
            Ok(vessel) => {
                if let Err((found, expected)) = put(body, &vessel.settings, at) {
                    errors.push(complain(found, expected));
                }
            }
            Err(complaints) => errors.push(complain(
                format!("`{name}`, which cannot be used ({complaints})"),
                "the name of a vessel of config/vessels".to_owned(),
            )),
        }
    }
    errors
}

/// Complains about bodies with a stretch or a pressure of their own and sizes of their vessel, which are those in another state.
fn sizes_of_another_state(root: &Node, file: &str) -> Vec<ConfigError> {
    let Some(Item::List(bodies)) = root.item_of("body").map(|node| &node.item) else {
        return Vec::new();
    };
    let mut errors = Vec::new();
    for (b, body) in bodies.iter().enumerate() {
        let Some(vessel) = body.item_of("vessel") else {
            continue;
        };
        // What the vessel brought stands where it is named.
        let at = vessel.at;
        let from_vessel = |node: &Node, key: &str| node.item_of(key).is_some_and(|of| of.at == at);
        let mut sizes = Vec::new();
        if from_vessel(body, "inner_radius") {
            sizes.push("`inner_radius`".to_owned());
        }
        if let Some(Item::List(layers)) = body.item_of("layer").map(|node| &node.item) {
            let layers = layers.iter().enumerate();
            let of_vessel = layers.filter(|(_, layer)| from_vessel(layer, "thickness"));
            sizes.extend(of_vessel.map(|(l, _)| format!("`layer[{l}].thickness`")));
        }
        if sizes.is_empty() {
            continue;
        }
        for key in ["axial_stretch", "transmural_pressure"] {
            // A stretch of the vessel that an override took out is 1 from then on, which is another one too.
            let vessels = match key {
                "axial_stretch" => from_vessel(body, key),
                _ => body.item_of(key).is_none(),
            };
            if vessels {
                continue;
            }
            let state = body.item_of(key).map_or(at, |of| of.at);
            errors.push(ConfigError {
                file: file.to_owned(),
                position: Some(state),
                key: KeyPath::root().key("body").at(b).key(key),
                found: "a state of the body's own beside sizes of its vessel, which are those at the vessel's `axial_stretch` without pressure".to_owned(),
                expected: format!("the sizes in that state as well: {}", sizes.join(", ")),
            });
        }
    }
    errors
}

/// Puts a vessel into a body; the error is what was found and what was expected.
fn put(body: &mut Node, vessel: &Vessel, at: Position) -> Result<(), (String, String)> {
    for (key, of) in [
        ("axial_stretch", &vessel.axial_stretch),
        ("inner_radius", &vessel.inner_radius),
    ] {
        body.set_default(key, Item::Float(of.value), at);
    }
    if let Some(toughness) = &vessel.toughness {
        body.set_default("toughness", Item::Float(toughness.value), at);
    }
    let names: Vec<&str> = vessel
        .layer
        .iter()
        .map(|layer| layer.name.as_str())
        .collect();
    let mut regions = Vec::new();
    match body.item_mut("layer") {
        Some(Item::List(layers)) if layers.len() == vessel.layer.len() => {
            for (index, (node, layer)) in layers.iter_mut().zip(&vessel.layer).enumerate() {
                for (key, of) in [
                    ("thickness", &layer.thickness),
                    ("opening_angle", &layer.opening_angle),
                ] {
                    node.set_default(key, Item::Float(of.value), at);
                }
                node.set_default("region", Item::Integer(index as i64), at);
                regions.push(node.integer("region"));
            }
        }
        _ => {
            let found = "a vessel whose layers the body does not have".to_owned();
            let expected = format!(
                "one `layer` with its `cells` for each of: {}",
                names.join(", ")
            );
            return Err((found, expected));
        }
    }
    body.set_default("material", Item::List(Vec::new()), at);
    let Some(Item::List(materials)) = body.item_mut("material") else {
        // What is no list has its complaint from the schema.
        return Ok(());
    };
    for (layer, region) in vessel.layer.iter().zip(regions) {
        // A region that is no number has its complaint from the schema.
        let Some(region) = region else { continue };
        let own = materials
            .iter_mut()
            .find(|material| material.integer("region") == Some(region));
        match own {
            // A material with a law of its own is all of it.
            Some(own) if own.item_of("law").is_some() => {}
            Some(own) => put_material(own, layer, at),
            None => {
                let mut material = Node {
                    at,
                    item: Item::Table(Vec::new()),
                };
                material.set_default("region", Item::Integer(region), at);
                put_material(&mut material, layer, at);
                materials.push(material);
            }
        }
    }
    Ok(())
}

/// Puts the material of a layer into one that states some of it.
fn put_material(material: &mut Node, layer: &VesselLayer, at: Position) {
    material.set_default("law", Item::Text(layer.law.name().to_owned()), at);
    for (key, constant) in &layer.material {
        // The one of both that the body states.
        let other = match key.as_str() {
            "relaxation_time" => "viscosity",
            "viscosity" => "relaxation_time",
            other => other,
        };
        if material.item_of(other).is_none() {
            material.set_default(key, Item::Float(constant.value), at);
        }
    }
    if let Some(angle) = &layer.fibre_angle {
        let angle = Entry {
            key: "angle".to_owned(),
            at,
            node: Node {
                at,
                item: Item::Float(angle.value),
            },
        };
        material.set_default("fibres", Item::Table(vec![angle]), at);
    }
    // Walls hardly change their volume: tetrahedra alone would lock.
    let discretisation = Discretisation::Selective.name().to_owned();
    material.set_default("discretisation", Item::Text(discretisation), at);
}
