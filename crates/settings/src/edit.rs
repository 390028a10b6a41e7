//! The numbers of a level that a copy of it may have otherwise: properties of tissue and contact, limits, parameters of metrics and of the module, each
//! with its unit, range and value. Places, sizes and meshes are not among them: what depends on them, marks and clamps for example, would no longer fit.

use crate::body::{Body, Coupling, Load};
use crate::contact::ContactPair;
use crate::document::Loaded;
use crate::error::KeyPath;
use crate::level::{KnownMetric, Level, Limit, MetricParameters, Physics};
use crate::level_check::limit_kind;
use crate::manifest::Manifest;
use crate::material::{Material, Plasticity};
use crate::schema::{Key, Kind};
use crate::table::Table;
use microsim_vocabulary::{LocalText, QuantityError, Unit};
use serde_json::Value;

/// What a number belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NumberGroup {
    /// What bodies are made of.
    Tissue,
    /// How they touch tools and each other.
    Contact,
    /// What is demanded.
    Limit,
    /// How metrics are computed.
    Metrics,
    /// What the module declares.
    Module,
}

/// A number of a level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelNumber {
    /// Where it stands.
    pub key: KeyPath,
    /// What it belongs to.
    pub group: NumberGroup,
    /// The body, contact or metric that it is of; empty for what a level has once.
    pub subject: LocalText,
    /// Its name in the file.
    pub name: String,
    /// What it means, in English, as the schema has it.
    pub doc: String,
    /// Its unit.
    pub unit: Unit,
    /// Smallest and largest value, in SI; an infinite one is none.
    pub range: [f64; 2],
    /// Whether it is a whole number without a unit.
    pub is_whole: bool,
    /// Its value, in SI.
    pub value: f64,
    /// That value as the file has it, or as a file could have it.
    pub text: String,
}

/// Why a text is no value of a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WrongNumber {
    /// It does not begin with a number, or is none that a computer can hold.
    NotANumber,
    /// Its decimal sign is a comma.
    DecimalComma,
    /// It has no unit.
    NoUnit,
    /// Its unit is of something else, or unknown.
    OtherUnit,
    /// It is not whole.
    NotWhole,
    /// It lies below the smallest or above the largest value.
    OutOfRange,
}

impl LevelNumber {
    /// The value of a text, in SI.
    ///
    /// # Errors
    /// Why the level cannot have it.
    pub fn read(&self, text: &str) -> Result<f64, WrongNumber> {
        let text = text.trim();
        let value = match self.is_whole {
            true => match (text.parse::<i64>(), text.parse::<f64>()) {
                (Ok(whole), _) => whole as f64,
                (_, Ok(number)) if number.is_finite() => return Err(WrongNumber::NotWhole),
                _ => return Err(WrongNumber::NotANumber),
            },
            false => self.unit.parse(text).map_err(|error| match error {
                QuantityError::NoUnit => WrongNumber::NoUnit,
                QuantityError::WrongUnit(None) if crate::read::has_decimal_comma(text) => {
                    WrongNumber::DecimalComma
                }
                QuantityError::WrongUnit(_) => WrongNumber::OtherUnit,
                QuantityError::NotANumber | QuantityError::NotFinite => WrongNumber::NotANumber,
            })?,
        };
        let [min, max] = self.range;
        match (min..=max).contains(&value) {
            true => Ok(value),
            false => Err(WrongNumber::OutOfRange),
        }
    }

    /// The range for people: both ends, or the one that there is; empty without.
    pub fn range_text(&self) -> String {
        let words = |value: f64| match self.is_whole {
            true => format!("{value}"),
            false => self.unit.describe(value),
        };
        let [min, max] = self.range;
        match (min.is_finite(), max.is_finite()) {
            (true, true) => format!("{} … {}", words(min), words(max)),
            (true, false) => format!("≥ {}", words(min)),
            (false, true) => format!("≤ {}", words(max)),
            (false, false) => String::new(),
        }
    }

    /// The units that it may be written in.
    pub fn units(&self) -> Vec<&'static str> {
        match (self.is_whole, self.unit) {
            (true, _) | (_, Unit::Count) => Vec::new(),
            (_, unit) => unit.symbols().collect(),
        }
    }
}

/// Keys of tables that number something else than a property.
const NO_PROPERTY: [&str; 3] = ["region", "from", "to"];
/// The numbers of a body that are properties of its tissue.
const OF_BODY: [&str; 3] = ["drag", "toughness", "brittleness"];
/// The number of the physics that is one of contact.
const OF_HAND: [&str; 1] = ["hand_force"];

/// What numbers may be of, with the keys of its table.
fn tables() -> [(NumberGroup, Vec<Key>); 8] {
    let among = |keys: Vec<Key>, names: &[&str]| {
        let wanted = keys.into_iter();
        wanted
            .filter(|key| names.contains(&&key.name[..]))
            .collect::<Vec<Key>>()
    };
    let numeric = |keys: Vec<Key>| {
        let wanted = keys.into_iter();
        wanted
            .filter(|key| bounds(&key.kind).is_some() && !NO_PROPERTY.contains(&&key.name[..]))
            .collect::<Vec<Key>>()
    };
    [
        (NumberGroup::Tissue, among(Body::keys(), &OF_BODY)),
        (NumberGroup::Tissue, numeric(Material::keys())),
        (NumberGroup::Tissue, numeric(Plasticity::keys())),
        (NumberGroup::Tissue, numeric(Coupling::keys())),
        (NumberGroup::Tissue, numeric(Load::keys())),
        (NumberGroup::Contact, numeric(ContactPair::keys())),
        (NumberGroup::Contact, among(Physics::keys(), &OF_HAND)),
        (NumberGroup::Metrics, numeric(MetricParameters::keys())),
    ]
}

/// The values of a limit.
const OF_LIMIT: [&str; 4] = ["min", "max", "full", "zero"];

/// Names of all numbers that a level may have, but for those that modules declare.
pub fn number_names() -> Vec<String> {
    let mut names: Vec<String> = tables()
        .into_iter()
        .flat_map(|(_, keys)| keys.into_iter().map(|key| key.name))
        .chain(OF_LIMIT.map(str::to_owned))
        .collect();
    names.sort();
    names.dedup();
    names
}

/// Unit, smallest and largest value of a kind, and whether it is whole.
fn bounds(kind: &Kind) -> Option<(Unit, [f64; 2], bool)> {
    match kind {
        Kind::Quantity { unit, min, max } => Some((*unit, [*min, *max], false)),
        Kind::Integer { min, max } => Some((Unit::Count, [*min as f64, *max as f64], true)),
        _ => None,
    }
}

/// Collects the numbers of a level.
struct Collector<'a> {
    level: &'a Loaded<Level>,
    found: Vec<LevelNumber>,
}

impl Collector<'_> {
    /// The numbers of a table that have a value.
    fn add(&mut self, at: &KeyPath, table: &Value, of: (NumberGroup, &LocalText), keys: &[Key]) {
        for key in keys {
            let value = table.get(&key.name).and_then(Value::as_f64);
            let Some((value, (unit, range, is_whole))) = value.zip(bounds(&key.kind)) else {
                continue;
            };
            let path = at.key(&key.name);
            let written = self.level.document.written(&path);
            let mut number = LevelNumber {
                group: of.0,
                subject: of.1.clone(),
                name: key.name.clone(),
                doc: key.doc.clone(),
                text: match is_whole {
                    true => format!("{value}"),
                    false => unit.describe(value),
                },
                key: path,
                unit,
                range,
                is_whole,
                value,
            };
            // A number in SI stands there without its unit.
            if let Some(written) = written.filter(|text| number.read(text).is_ok()) {
                number.text = written;
            }
            self.found.push(number);
        }
    }
}

fn list<'a>(value: &'a Value, name: &str) -> impl Iterator<Item = (usize, &'a Value)> {
    value
        .get(name)
        .and_then(Value::as_array)
        .into_iter()
        .flatten()
        .enumerate()
}

fn same(text: &str) -> LocalText {
    LocalText::new(text.to_owned(), text.to_owned())
}

/// The numbers of a level of this module that have a value, in the order of the file's tables; `title` names metrics for people.
pub fn level_numbers(
    level: &Loaded<Level>,
    manifest: &Manifest,
    known_metrics: &[KnownMetric<'_>],
    title: &dyn Fn(&str) -> Option<LocalText>,
) -> Vec<LevelNumber> {
    let value = level.document.value();
    let root = KeyPath::root();
    let [
        body,
        material,
        plasticity,
        coupling,
        load,
        contact,
        hand,
        metrics,
    ] = tables();
    let mut all = Collector {
        level,
        found: Vec::new(),
    };
    for (b, of) in list(value, "body") {
        let at = root.key("body").at(b);
        let name = of["name"].as_str().unwrap_or_default();
        all.add(&at, of, (body.0, &same(name)), &body.1);
        for (m, of) in list(of, "material") {
            let at = at.key("material").at(m);
            let subject = match of["region"].as_u64() {
                Some(region) => LocalText::new(
                    format!("{name}, Bereich {region}"),
                    format!("{name}, region {region}"),
                ),
                None => same(name),
            };
            all.add(&at, of, (material.0, &subject), &material.1);
            let flow = &of["plasticity"];
            let of = (plasticity.0, &subject);
            all.add(&at.key("plasticity"), flow, of, &plasticity.1);
        }
        for (name_of_list, (group, keys)) in [("coupling", &coupling), ("load", &load)] {
            for (k, of) in list(of, name_of_list) {
                let at = at.key(name_of_list).at(k);
                let subject = match name_of_list {
                    "coupling" => LocalText::new(
                        format!("{name}, Bereiche {} und {}", of["from"], of["to"]),
                        format!("{name}, regions {} and {}", of["from"], of["to"]),
                    ),
                    _ => LocalText::new(format!("{name}, Last"), format!("{name}, load")),
                };
                // A default may be of another kind of coupling, and refused where it is written.
                let is_written = |key: &&Key| {
                    let path = at.key(&key.name);
                    name_of_list != "coupling" || level.document.is_written(&path)
                };
                let keys: Vec<Key> = keys.iter().filter(is_written).cloned().collect();
                all.add(&at, of, (*group, &subject), &keys);
            }
        }
    }
    for (k, of) in list(value, "contact") {
        let pair = &level.settings.contact[k];
        let subject = match pair.itself {
            true => LocalText::new(
                format!("{} mit sich selbst", pair.body),
                format!("{} with itself", pair.body),
            ),
            false => same(&format!("{} – {}", pair.partner(), pair.body)),
        };
        let at = root.key("contact").at(k);
        all.add(&at, of, (contact.0, &subject), &contact.1);
    }
    let whole = same("");
    all.add(
        &root.key("physics"),
        &value["physics"],
        (hand.0, &whole),
        &hand.1,
    );
    for (k, of) in list(value, "limit") {
        let id = of["metric"].as_str().unwrap_or_default();
        let own = manifest.metric.iter().find(|metric| metric.id == id);
        let known = known_metrics.iter().find(|metric| metric.id == id);
        let Some(unit) = own.map(|m| m.unit).or(known.map(|m| m.unit)) else {
            continue;
        };
        let keys = Limit::keys().into_iter();
        let keys = keys.filter(|key| OF_LIMIT.contains(&&key.name[..]));
        let keys = keys.map(|key| Key {
            kind: limit_kind(unit),
            ..key
        });
        let subject = own.map(|m| m.title.clone()).or_else(|| title(id));
        let subject = subject.unwrap_or_else(|| same(id));
        let at = root.key("limit").at(k);
        let keys: Vec<Key> = keys.collect();
        all.add(&at, of, (NumberGroup::Limit, &subject), &keys);
    }
    all.add(
        &root.key("metrics"),
        &value["metrics"],
        (metrics.0, &whole),
        &metrics.1,
    );
    let keys = manifest.module_keys();
    let of = (NumberGroup::Module, &whole);
    all.add(&root.key("module"), &value["module"], of, &keys);
    all.found
}
