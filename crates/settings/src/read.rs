//! Reads a tree by a schema: the values in SI with the defaults filled in, and every complaint about them.

use crate::error::{ConfigError, KeyPath, Position};
use crate::schema::{Form, Key, Kind, Presence, enumerate};
use crate::tree::{Item, Node};
use microsim_vocabulary::{QuantityError, Unit};
use serde_json::{Map, Value};

/// How far the length of a quaternion may be from 1: what four digits after the point leave.
const QUATERNION_LENGTH_TOLERANCE: f64 = 1e-3;

/// Keys that have had another name, before and now.
const RENAMED: [(&str, &str); 3] = [
    ("settle", "fall_time"),
    ("share", "fraction"),
    ("shares", "fractions"),
];

/// Keys that are gone, and what is now instead.
const REMOVED: [(&str, &str); 1] = [(
    "session.directory",
    "no such key any more: sessions lie in the data folder of the user, which `microsim doctor` shows and --data or MICROSIM_DATA change",
)];

/// Collects complaints about one file.
pub(crate) struct Reader<'a> {
    pub file: &'a str,
    pub errors: Vec<ConfigError>,
}

impl Reader<'_> {
    /// The value of a node, or `None` after a complaint.
    pub fn value(&mut self, node: &Node, kind: &Kind, path: &KeyPath) -> Option<Value> {
        match (kind, &node.item) {
            (Kind::Text, Item::Text(text)) if !text.trim().is_empty() => Some(text.clone().into()),
            (Kind::Name(form), Item::Text(text)) if form.accepts(text) => Some(text.clone().into()),
            (Kind::Bool, Item::Bool(truth)) => Some((*truth).into()),
            (Kind::Integer { min, max }, Item::Integer(n)) if (min..=max).contains(&n) => {
                Some((*n).into())
            }
            (Kind::Quantity { unit, min, max }, _) => {
                self.quantity(node, *unit, (*min, *max), kind, path)
            }
            (
                Kind::Vector {
                    unit,
                    len,
                    min,
                    max,
                },
                Item::List(nodes),
            ) if nodes.len() == *len => {
                let component = Kind::quantity(*unit, *min, *max);
                let values: Vec<Option<Value>> = nodes
                    .iter()
                    .enumerate()
                    .map(|(i, node)| self.value(node, &component, &path.at(i)))
                    .collect();
                values
                    .into_iter()
                    .collect::<Option<Vec<Value>>>()
                    .map(Value::Array)
            }
            (Kind::Quaternion, _) => self.quaternion(node, path),
            (Kind::Direction, _) => self.direction(node, path),
            (Kind::Choice(values), Item::Text(text)) => {
                if values.contains(text) {
                    return Some(text.clone().into());
                }
                let hint = did_you_mean(text, values.iter().map(String::as_str));
                self.complain(node.at, path, node.describe(), kind.expected() + &hint);
                None
            }
            (Kind::ChoiceOr(values, _), Item::Text(text)) if values.contains(text) => {
                Some(text.clone().into())
            }
            (Kind::ChoiceOr(_, other), Item::Integer(_) | Item::Float(_)) => {
                self.value(node, other, path)
            }
            (Kind::Colour, Item::Text(text)) if is_colour(text) => {
                Some(text.to_ascii_lowercase().into())
            }
            (Kind::LocalText, Item::Table(_)) => self.table(node, &local_text_keys(), path),
            (Kind::EnglishText, Item::Table(_)) => {
                let mut texts = self.table(node, &english_text_keys(), path)?;
                if texts["de"].is_null() {
                    texts["de"] = texts["en"].clone();
                }
                Some(texts)
            }
            (Kind::Table(keys), Item::Table(_)) => self.table(node, keys, path),
            (Kind::List { of, min, max }, Item::List(nodes))
                if (min..=max).contains(&&nodes.len()) =>
            {
                // An element that is wrong leaves a hole, so that the others keep their index for the later checks.
                let values = nodes
                    .iter()
                    .enumerate()
                    .map(|(i, node)| self.value(node, of, &path.at(i)).unwrap_or(Value::Null));
                Some(Value::Array(values.collect()))
            }
            (Kind::Map { keys, of }, Item::Table(_)) => self.map(node, *keys, of, path),
            (Kind::Dependent(_), _) => self.raw(node, kind, path),
            _ => {
                self.complain(node.at, path, node.describe(), kind.expected());
                None
            }
        }
    }

    /// A table with known keys. Wrong values are left out; they have been complained about.
    pub fn table(&mut self, node: &Node, keys: &[Key], path: &KeyPath) -> Option<Value> {
        let Item::Table(entries) = &node.item else {
            self.complain(node.at, path, node.describe(), "a table".to_owned());
            return None;
        };
        for entry in entries {
            if !keys.iter().any(|key| key.name == entry.key) {
                self.unknown_key(entry.at, &entry.key, keys, path);
            }
        }
        let mut table = Map::new();
        for key in keys {
            let path = path.key(&key.name);
            let value = match entries.iter().find(|entry| entry.key == key.name) {
                Some(entry) => self.value(&entry.node, &key.kind, &path),
                None => self.absent(node, key, &path),
            };
            if let Some(value) = value {
                table.insert(key.name.clone(), value);
            }
        }
        Some(Value::Object(table))
    }

    /// Notes what is wrong at a place.
    pub fn complain(&mut self, at: Position, path: &KeyPath, found: String, expected: String) {
        self.errors.push(ConfigError {
            file: self.file.to_owned(),
            position: Some(at),
            key: path.clone(),
            found,
            expected,
        });
    }

    /// What stands for a key that is not there.
    fn absent(&mut self, table: &Node, key: &Key, path: &KeyPath) -> Option<Value> {
        match (&key.presence, &key.kind) {
            (Presence::Required, kind) => {
                let expected = format!("{}: {}", kind.expected(), key.doc);
                self.complain(table.at, path, "nothing".to_owned(), expected);
                None
            }
            (Presence::Optional, _) => None,
            (Presence::Default(_), Kind::Table(keys)) => {
                let empty = Node {
                    at: table.at,
                    item: Item::Table(Vec::new()),
                };
                self.table(&empty, keys, path)
            }
            (Presence::Default(value), _) => Some(value.clone()),
        }
    }

    fn unknown_key(&mut self, at: Position, name: &str, keys: &[Key], path: &KeyPath) {
        let path = path.key(name);
        let whole = path.to_string();
        if let Some((_, instead)) = REMOVED.iter().find(|(key, _)| *key == whole) {
            let found = "a key of earlier versions".to_owned();
            return self.complain(at, &path, found, (*instead).to_owned());
        }
        let names: Vec<&str> = keys.iter().map(|key| key.name.as_str()).collect();
        let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let quoted: Vec<&str> = quoted.iter().map(String::as_str).collect();
        let renamed = RENAMED
            .iter()
            .find(|(old, new)| *old == name && names.contains(new));
        let hint = match renamed {
            Some((_, new)) => format!(" (it is `{new}` now)"),
            None => did_you_mean(name, names.iter().copied()),
        };
        let known = match keys {
            [] => "no key here".to_owned(),
            _ => enumerate(&quoted, "or"),
        };
        self.complain(at, &path, "an unknown key".to_owned(), known + &hint);
    }

    fn quantity(
        &mut self,
        node: &Node,
        unit: Unit,
        (min, max): (f64, f64),
        kind: &Kind,
        path: &KeyPath,
    ) -> Option<Value> {
        let parsed = match &node.item {
            Item::Integer(number) => Ok(*number as f64),
            Item::Float(number) if number.is_finite() => Ok(*number),
            Item::Text(text) => unit.parse(text).map_err(|error| match error {
                QuantityError::NoUnit => format!("{} without a unit", node.describe()),
                QuantityError::WrongUnit(Some(other)) => {
                    format!("{} ({})", node.describe(), other.noun())
                }
                QuantityError::WrongUnit(None) if has_decimal_comma(text) => {
                    format!("{} (its decimal sign is no point)", node.describe())
                }
                QuantityError::WrongUnit(None) => format!("{} (unknown unit)", node.describe()),
                QuantityError::NotANumber | QuantityError::NotFinite => node.describe(),
            }),
            _ => Err(node.describe()),
        };
        match parsed {
            Ok(value) if (min..=max).contains(&value) => Some(value.into()),
            Ok(_) => {
                self.complain(node.at, path, node.describe(), kind.expected());
                None
            }
            Err(found) => {
                self.complain(node.at, path, found, kind.expected());
                None
            }
        }
    }

    fn quaternion(&mut self, node: &Node, path: &KeyPath) -> Option<Value> {
        let length = |q: &[f64; 4]| q.iter().map(|c| c * c).sum::<f64>().sqrt();
        match numbers::<4>(node) {
            Some(q) if (length(&q) - 1.0).abs() <= QUATERNION_LENGTH_TOLERANCE => {
                Some(q.map(|c| c / length(&q)).to_vec().into())
            }
            Some(q) => {
                let found = format!("a rotation of length {}", length(&q));
                self.complain(node.at, path, found, Kind::Quaternion.expected());
                None
            }
            None => {
                self.complain(node.at, path, node.describe(), Kind::Quaternion.expected());
                None
            }
        }
    }

    fn direction(&mut self, node: &Node, path: &KeyPath) -> Option<Value> {
        let numbers = numbers::<3>(node);
        // Divided by the largest component first, so that the square of a small or large one stays in range.
        let largest = numbers.map_or(0.0, |d| d.iter().fold(0.0, |m: f64, c| m.max(c.abs())));
        match numbers {
            Some(direction) if largest > 0.0 => {
                let scaled = direction.map(|c| c / largest);
                let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
                Some(scaled.map(|c| c / length).to_vec().into())
            }
            found => {
                let found = found.map_or(node.describe(), |_| "a direction of length 0".into());
                self.complain(node.at, path, found, Kind::Direction.expected());
                None
            }
        }
    }

    fn map(&mut self, node: &Node, form: Form, of: &Kind, path: &KeyPath) -> Option<Value> {
        let Item::Table(entries) = &node.item else {
            return None;
        };
        let mut table = Map::new();
        for entry in entries {
            let path = path.key(&entry.key);
            if !form.accepts(&entry.key) {
                let found = format!("the key `{}`", entry.key);
                self.complain(entry.at, &path, found, Kind::Name(form).expected());
            } else if let Some(value) = self.value(&entry.node, of, &path) {
                table.insert(entry.key.clone(), value);
            }
        }
        Some(Value::Object(table))
    }

    /// A value as it stands, for a kind that is known only later.
    fn raw(&mut self, node: &Node, kind: &Kind, path: &KeyPath) -> Option<Value> {
        match &node.item {
            Item::Text(text) => Some(text.clone().into()),
            Item::Integer(number) => Some((*number).into()),
            Item::Float(number) if number.is_finite() => Some((*number).into()),
            Item::Bool(truth) => Some((*truth).into()),
            Item::List(nodes) => {
                let values = nodes.iter().enumerate();
                let values: Option<Vec<Value>> = values
                    .map(|(i, node)| self.raw(node, kind, &path.at(i)))
                    .collect();
                values.map(Value::Array)
            }
            Item::Float(_) | Item::Date(_) | Item::Table(_) => {
                self.complain(node.at, path, node.describe(), kind.expected());
                None
            }
        }
    }
}

/// The keys of a text in both languages.
pub(crate) fn local_text_keys() -> [Key; 2] {
    [
        Key::required("de", Kind::Text, "The text in German."),
        Key::required("en", Kind::Text, "The text in English."),
    ]
}

/// The keys of a text that may be in English alone.
pub(crate) fn english_text_keys() -> [Key; 2] {
    let [mut german, english] = local_text_keys();
    german.presence = Presence::Optional;
    german.doc = "The text in German; the English one stands for it if it is left out.".to_owned();
    [german, english]
}

/// A list of exactly N finite numbers.
fn numbers<const N: usize>(node: &Node) -> Option<[f64; N]> {
    let Item::List(nodes) = &node.item else {
        return None;
    };
    let values: Option<Vec<f64>> = nodes
        .iter()
        .map(|node| match node.item {
            Item::Integer(number) => Some(number as f64),
            Item::Float(number) => Some(number).filter(|n| n.is_finite()),
            _ => None,
        })
        .collect();
    values?.try_into().ok()
}

fn is_colour(text: &str) -> bool {
    text.len() == 7
        && text
            .strip_prefix('#')
            .is_some_and(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()))
}

/// Whether a text begins as a number does that is written with a comma, as in German.
pub(crate) fn has_decimal_comma(text: &str) -> bool {
    let is_sign = |c: char| c == '+' || c == '-';
    let digits = text.trim().trim_start_matches(is_sign);
    let rest = digits.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let fraction = rest.strip_prefix(',');
    rest.len() < digits.len()
        && fraction.is_some_and(|f| f.starts_with(|c: char| c.is_ascii_digit()))
}

/// " (did you mean `x`?)" for the nearest of the known names, if one is near.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    // Up to two slips in three letters still read as the same word; a name of one or two letters has too little in common.
    let allowed = match name.chars().count() {
        0..3 => return String::new(),
        letters => 1 + letters / 3,
    };
    known
        .map(|word| (edit_distance(name, word), word))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, word)| format!(" (did you mean `{word}`?)"))
        .unwrap_or_default()
}

/// Levenshtein distance in characters, `-` and `_` taken as equal.
fn edit_distance(a: &str, b: &str) -> usize {
    let letters = |text: &str| -> Vec<char> { text.replace('-', "_").chars().collect() };
    // Longer names are not typing errors of ours; this also bounds the work.
    let (a, b) = (letters(a), letters(b));
    if a.len().abs_diff(b.len()) > 8 {
        return a.len().max(b.len());
    }
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let change = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_offered() {
        let known = ["title", "tick", "steps", "idle_speed"];
        let hint = |name| did_you_mean(name, known.into_iter());
        assert_eq!(hint("titel"), " (did you mean `title`?)");
        assert_eq!(hint("idle-speed"), " (did you mean `idle_speed`?)");
        assert_eq!(hint("step"), " (did you mean `steps`?)");
        assert_eq!(hint("gravity"), "");
        assert_eq!(hint("ti"), "");
    }

    /// Distances counted by hand.
    #[test]
    fn edit_distance_counts_single_changes() {
        for (a, b, distance) in [
            ("", "", 0),
            ("abc", "abc", 0),
            ("abc", "", 3),
            ("kitten", "sitting", 3),
            ("ab", "ba", 2),
        ] {
            assert_eq!(edit_distance(a, b), distance, "{a} {b}");
        }
    }
}
