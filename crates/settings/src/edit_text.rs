//! A copy of a level in which single numbers are others: comments, order and notation of all else stay as they are.

use crate::error::{KeyPath, Step};
use serde_json::Value as Json;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

/// Tables whose numbers do not change how tissue moves.
const OF_JUDGEMENT: [&str; 3] = ["limit", "metrics", "module"];

/// What stands in a copy of a level: the text of the level with other values, and a line on top that states what it is.
///
/// What was measured of the motion (`[tuned]`) is left out where a value changes that motion.
#[derive(Debug)]
pub struct LevelCopy<'a> {
    /// The text of the level.
    pub text: &'a str,
    /// Its values, in SI, with what its bodies have from vessels.
    pub value: &'a Json,
    /// What it is a copy of, for example `level 2 of push-strip`.
    pub of: &'a str,
}

impl LevelCopy<'_> {
    /// The text of the copy; each change is a place and what stands there from now on, a number or a text with a unit.
    ///
    /// # Errors
    /// If the text is no TOML, or has no place for a change.
    pub fn with(&self, changes: &[(KeyPath, String)]) -> Result<String, String> {
        let mut document: DocumentMut = self.text.parse().map_err(|e| format!("{e}"))?;
        for (key, text) in changes {
            self.set(document.as_table_mut(), key, text)
                .ok_or_else(|| format!("no place for `{key}`"))?;
        }
        let moves = |key: &KeyPath| match key.steps().first() {
            Some(Step::Key(first)) => !OF_JUDGEMENT.contains(&&first[..]),
            _ => true,
        };
        if changes.iter().any(|(key, _)| moves(key)) {
            document.remove("tuned");
        }
        let names: Vec<String> = changes
            .iter()
            .map(|(key, text)| format!("{key} = {text}"))
            .collect();
        let head = match names.is_empty() {
            true => format!("# A copy of {}.\n", self.of),
            false => format!("# A copy of {}, with {}.\n", self.of, names.join("; ")),
        };
        Ok(head + &document.to_string())
    }

    fn set(&self, root: &mut Table, key: &KeyPath, text: &str) -> Option<()> {
        let (last, path) = key.steps().split_last()?;
        let mut table: &mut dyn TableLike = root;
        // What the file as it is read has at the place that is reached.
        let mut seen = self.value;
        let mut steps = path.iter().peekable();
        while let Some(step) = steps.next() {
            let Step::Key(name) = step else { return None };
            seen = seen.get(name)?;
            match steps.peek() {
                Some(Step::Index(index)) => {
                    steps.next();
                    let read = seen.get(index)?;
                    let absent = || Item::ArrayOfTables(ArrayOfTables::new());
                    table = match table.entry(name).or_insert_with(absent) {
                        Item::ArrayOfTables(list) => element(list, *index, read)?,
                        list => {
                            let element = list.as_array_mut()?.get_mut(*index)?;
                            element.as_inline_table_mut()?
                        }
                    };
                    seen = read;
                }
                _ => {
                    let new = || Item::Table(Table::new());
                    table = table.entry(name).or_insert_with(new).as_table_like_mut()?;
                }
            }
        }
        let Step::Key(name) = last else { return None };
        let mut value = value_of(text.trim());
        if let Some(old) = table.get(name).and_then(Item::as_value) {
            *value.decor_mut() = old.decor().clone();
        }
        table.insert(name, Item::Value(value));
        Some(())
    }
}

/// An element of a list. Behind the tables that are written stand those that a vessel brought, by their region, of which one is made.
fn element<'a>(
    list: &'a mut ArrayOfTables,
    index: usize,
    read: &Json,
) -> Option<&'a mut dyn TableLike> {
    let region = read.get("region").and_then(Json::as_i64);
    let of_region = |table: &Table| {
        let own = table.get("region").and_then(Item::as_integer);
        own.is_some() && own == region
    };
    let place = match index < list.len() {
        true => Some(index),
        false => list.iter().position(of_region),
    };
    let place = match place {
        Some(place) => place,
        None => {
            let mut new = Table::new();
            new.insert("region", toml_edit::value(region?));
            list.push(new);
            list.len() - 1
        }
    };
    Some(list.get_mut(place)?)
}

/// A number as TOML, or else a text with a unit.
fn value_of(text: &str) -> Value {
    match text.parse::<Value>() {
        Ok(value) if value.is_integer() || value.is_float() => value.decorated(" ", ""),
        _ => Value::from(text).decorated(" ", ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(list: &str, index: usize, key: &str) -> KeyPath {
        KeyPath::root().key(list).at(index).key(key)
    }

    /// Expected is the text itself with the one value replaced by hand.
    #[test]
    fn only_the_values_that_change_are_others() {
        let text = "# What it is.\n[clock]\ntick = \"8 ms\" # short\n\n[[limit]] # first\nmetric = \"time\"\nmax = \"60 s\" # long\n\n[[limit]]\nmetric = \"drops\"\nmax = 1\n\n[tuned]\nerror = 0.03\n";
        let value = serde_json::json!({ "limit": [{}, {}], "metrics": {}, "physics": {} });
        let copy = LevelCopy {
            text,
            value: &value,
            of: "level 1 of it",
        };
        let changes = [
            (at("limit", 0, "max"), "1.5 min".to_owned()),
            (at("limit", 1, "max"), "2".to_owned()),
        ];
        let expected = text
            .replace("\"60 s\"", "\"1.5 min\"")
            .replace("max = 1\n", "max = 2\n");
        assert_eq!(
            copy.with(&changes),
            Ok(format!(
                "# A copy of level 1 of it, with limit[0].max = 1.5 min; limit[1].max = 2.\n{expected}"
            ))
        );
        assert_eq!(
            copy.with(&[]),
            Ok(format!("# A copy of level 1 of it.\n{text}"))
        );
        // What was measured of the motion holds no longer; a table that is not there yet is made.
        let key = KeyPath::root().key("physics").key("hand_force");
        let moved = copy.with(&[(key, "2 N".to_owned())]).expect("a place");
        assert!(!moved.contains("tuned") && moved.ends_with("[physics]\nhand_force = \"2 N\"\n"));
        let inline = LevelCopy {
            text: "[[body]]\nload = [{ ramp = \"1 s\" }] # slow\nplasticity = { max_strain = 1, hardening = 0 }\n",
            value: &serde_json::json!({ "body": [{ "load": [{}], "plasticity": {} }] }),
            of: "it",
        };
        let body = KeyPath::root().key("body").at(0);
        let changes = [
            (body.key("load").at(0).key("ramp"), "2 s".to_owned()),
            (body.key("plasticity").key("max_strain"), "3".to_owned()),
        ];
        let expected = "# A copy of it, with body[0].load[0].ramp = 2 s; body[0].plasticity.max_strain = 3.\n\
            [[body]]\nload = [{ ramp = \"2 s\" }] # slow\nplasticity = { max_strain = 3, hardening = 0 }\n";
        assert_eq!(inline.with(&changes), Ok(expected.to_owned()));
        let nowhere = copy.with(&[(at("limit", 2, "max"), "1".to_owned())]);
        assert_eq!(nowhere, Err("no place for `limit[2].max`".to_owned()));
    }

    /// What a vessel gives a body stands in no table of the file: one is made for the region, once.
    #[test]
    fn a_property_of_a_vessel_gets_a_material_of_its_region() {
        let value =
            serde_json::json!({ "body": [{ "material": [{ "region": 0 }, { "region": 1 }] }] });
        let copy = LevelCopy {
            text: "[[body]]\nname = \"artery\"\nvessel = \"radial\"\n",
            value: &value,
            of: "level 1 of it",
        };
        let key = |name| {
            let material = KeyPath::root().key("body").at(0).key("material");
            material.at(1).key(name)
        };
        let changes = [
            (key("density"), "1000 kg/m^3".to_owned()),
            (key("poisson_ratio"), "0.4".to_owned()),
        ];
        let text = copy.with(&changes).expect("a place");
        let expected = "[[body]]\nname = \"artery\"\nvessel = \"radial\"\n\n[[body.material]]\nregion = 1\ndensity = \"1000 kg/m^3\"\npoisson_ratio = 0.4\n";
        assert!(text.ends_with(expected), "{text}");
    }
}
