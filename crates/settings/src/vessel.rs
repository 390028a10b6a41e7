//! `config/vessels/NAME.toml`: a vessel as it was measured, or as it is judged to be, each value with its source.
//!
//! A body that is a tube names one with `vessel`. What the body does not state itself comes from there: axial stretch,
//! radius of the lumen, thickness, opening angle, region and material of each layer. They are put into the tree of the file before it is read by its schema, so they are held
//! to the same rules, and everything behind the settings sees a body that states all of it.

use crate::body_check::check_constants;
use crate::check::{items, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigError, ConfigErrors, KeyPath, Position};
use crate::files::schema_of;
use crate::kinds::{dependent, identifier, quantity, size};
use crate::material::Material;
use crate::schema::{Form, Kind};
use crate::table::{Setting, Table, choices, table};
use crate::tree::{Entry, Item, Node};
use microsim_vocabulary::{Discretisation, LawName, LocalText, Unit, terms};
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

table! {
    /// A vessel.
    pub struct Vessel {
        /// What it is, and what its values are good for.
        doc: String,
        /// Its name for people.
        title: LocalText,
        /// Length where it lies over that of an excised piece without load.
        axial_stretch: VesselValue = valued(quantity(Unit::Ratio, 1.0, 3.0)),
        /// Radius of the lumen where it lies: stretched along its axis, without pressure inside, as between two clamps \[m\].
        inner_radius: VesselValue = valued(size()),
        /// Force per length of a perfectly sharp edge that cuts it (work per area) \[N/m\].
        toughness: Option<VesselValue> = valued(quantity(Unit::LengthStiffness, 1e-6, 1e6)),
        /// The layers of its wall, from the inside.
        layer: Vec<VesselLayer> [1, 16],
    }
}

table! {
    /// A layer of the wall of a vessel.
    pub struct VesselLayer {
        /// Its name.
        name: String = identifier(),
        /// Thickness where it lies \[m\].
        thickness: VesselValue = valued(size()),
        /// What is missing of a full circle when the layer is cut out and slit \[rad\]; twice the opening angle of Fung.
        opening_angle: VesselValue = valued(quantity(Unit::Angle, 0.0, 340_f64.to_radians())),
        /// The law of its material, that of a continuum.
        law: LawName,
        /// Angle of the fibres to the circles around the axis \[rad\]; only and always of a law with fibres.
        fibre_angle: Option<VesselValue> = valued(quantity(Unit::Angle, -FRAC_PI_2, FRAC_PI_2)),
        /// The numbers of its material, by their keys in a `[[body.material]]`.
        material: VesselConstants,
    }
}

table! {
    /// A value and where it comes from.
    pub struct VesselValue {
        /// The value.
        value: f64,
        /// The publication with what was measured, or the reason of the judgement.
        source: String,
        /// Whether it is `measured` (or fitted to measurements) in the source, `derived` from measured values, or a `judgement`.
        basis: Basis,
    }
}

terms! {
    /// What a value rests on.
    pub enum Basis {
        /// A measurement, or a fit to measurements, that is published.
        Measured = "measured",
        /// It follows from measured values by a computation that the source names.
        Derived = "derived",
        /// What those who wrote the file think: no measurement of this value backs it.
        Judgement = "judgement",
    }
}

choices!(Basis, LawName);

/// Values by the keys of materials.
pub type VesselConstants = BTreeMap<String, VesselValue>;

impl Setting for VesselConstants {
    fn kind() -> Kind {
        Kind::Map {
            keys: Form::Symbol,
            of: Box::new(valued(dependent("a value in the unit of the key"))),
        }
    }
}

/// A value of this kind and where it comes from.
fn valued(value: Kind) -> Kind {
    let mut keys = VesselValue::keys();
    keys[0].kind = value;
    Kind::Table(keys)
}

impl Vessel {
    /// All values, by their keys as paths.
    pub fn values(&self) -> Vec<(String, &VesselValue)> {
        let mut values = vec![
            ("axial_stretch".to_owned(), &self.axial_stretch),
            ("inner_radius".to_owned(), &self.inner_radius),
        ];
        values.extend(self.toughness.iter().map(|v| ("toughness".to_owned(), v)));
        for layer in &self.layer {
            let key = |name: &str| format!("{}.{name}", layer.name);
            values.push((key("thickness"), &layer.thickness));
            values.push((key("opening_angle"), &layer.opening_angle));
            values.extend(layer.fibre_angle.iter().map(|v| (key("fibre_angle"), v)));
            values.extend(layer.material.iter().map(|(name, v)| (key(name), v)));
        }
        values
    }
}

/// Reads a vessel from a text; `file` is the name that complaints use.
pub fn read_vessel(text: &str, file: &str) -> Result<Loaded<Vessel>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Vessel>("vessel"))?;
    let root = KeyPath::root();
    let names = texts(reading.value(), "layer", "name");
    unique(&mut reading, &root, &names, "layer", "name");
    let layers: Vec<Value> = items(reading.value(), "layer")
        .map(|(_, layer)| layer.clone())
        .collect();
    for (l, layer) in layers.iter().enumerate() {
        let key = root.key("layer").at(l);
        let names: Vec<String> = layer["material"]
            .as_object()
            .map(|constants| constants.keys().cloned().collect())
            .unwrap_or_default();
        for name in names {
            let key = key.key("material").key(&name);
            match Material::range(&name) {
                Some((unit, min, max)) => {
                    reading.refine(&key.key("value"), &quantity(unit, min, max));
                }
                None => reading.complain(
                    &key,
                    &format!("`{name}`"),
                    "a key of a [[body.material]] that is a quantity",
                ),
            }
        }
        if let Some(law) = layer["law"].as_str() {
            check_constants(&mut reading, &key, law);
        }
    }
    reading.finish()
}

/// Reads the vessel at `path`.
pub fn load_vessel(path: &Path) -> Result<Loaded<Vessel>, ConfigErrors> {
    let text = load_text(path, "a vessel (config/vessels/NAME.toml)")?;
    read_vessel(&text, &path.display().to_string())
}

/// Puts what vessels in `folder` state into the bodies of a scene or level that name them and do not state it themselves; `file` is the
/// name that complaints use.
pub(crate) fn apply_vessels(root: &mut Node, file: &str, folder: &Path) -> Vec<ConfigError> {
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
