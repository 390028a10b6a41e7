//! `config/vessels/NAME.toml`: a vessel as it was measured, or as it is judged to be, each value with its source.
//!
//! What is not here: how a body has these values.

use crate::body_check::check_constants;
use crate::check::{items, texts, unique};
use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{axial_stretch, dependent, identifier, opening_angle, quantity, size};
use crate::material::Material;
use crate::schema::{Form, Kind};
use crate::table::{Setting, Table, choices, table};
use microsim_vocabulary::{LawName, LocalText, Unit, terms};
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
        /// Its length where it lies over that of its natural state, in which each layer is cut out, slit, and has no stress.
        axial_stretch: VesselValue = valued(axial_stretch()),
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
        /// What is missing of a full circle when the layer is cut out and slit, and has no stress \[rad\]; twice the opening angle of Fung.
        opening_angle: VesselValue = valued(opening_angle()),
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
