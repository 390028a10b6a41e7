//! The schema, which reads, and the Rust types, which the program uses, agree.

use crate::{EXAMPLES, manifest, read};
use microsim_settings::*;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Keys that are optional in the schema, but needed by the type where they stand in the examples: one of a few must be
/// there, which the checks see to.
const CONDITIONAL: [&str; 22] = [
    "contact[].grip",
    "contact[].response",
    "cut[].topology",
    "cut[].trigger",
    "physics.broad_phase",
    "run.broad_phase",
    "object[].radius",
    "object[].length",
    "object[].tube",
    "object[].half_size",
    "object[].model",
    "tool[].key[].direction",
    "tool[].key[].orientation",
    "rigid[].half_size",
    "rigid[].wall",
    "rigid[].gap",
    "rigid[].radius",
    "rigid[].length",
    "tool[].motion[].axis",
    "tool[].motion[].angle",
    "tool[].motion[].orientation",
    "rigid[].rounding",
];

/// Keys that the example cannot have: a method has some of the parameters, and a file one method; a vessel is a file of its own.
const NOT_IN_THE_EXAMPLE: [&str; 2] = ["method.substeps", "body[].vessel"];

/// Whether a key is a parameter of a law: the examples have materials of some laws, not of every one.
fn is_of_a_law(name: &str) -> bool {
    let mut parameters = LawName::ALL.into_iter().flat_map(LawName::parameters);
    parameters.any(|(key, _)| name.ends_with(&format!("material[].{key}")))
}

/// The schema by which the example of a kind is read.
fn schema(kind: &str) -> Schema {
    match kind {
        "level" => level_schema(Some(&manifest())),
        kind => schema_for(kind).expect("each kind has a schema"),
    }
}

/// The result of reading values by the type of a kind; only errors are of interest.
fn accept(kind: &str, value: &Value) -> Result<(), String> {
    fn parse<T: serde::de::DeserializeOwned>(value: &Value) -> Result<(), String> {
        serde_json::from_value::<T>(value.clone())
            .map(drop)
            .map_err(|error| error.to_string())
    }
    match kind {
        "manifest" => parse::<Manifest>(value),
        "level" => parse::<Level>(value),
        "scene" => parse::<Scene>(value),
        "chart" => parse::<Chart>(value),
        "tool" => parse::<Tool>(value),
        "vessel" => parse::<Vessel>(value),
        "window" => parse::<WindowSettings>(value),
        "translator" => parse::<Translator>(value),
        "recording" => parse::<RecordingMap>(value),
        "script" => parse::<Script>(value),
        "trainees" => parse::<Trainees>(value),
        "course" => parse::<Course>(value),
        "host" => parse::<Host>(value),
        other => panic!("no kind `{other}`"),
    }
}

/// Calls `visit` with each table of a value by its schema: its JSON pointer, its full name, its keys.
fn tables(
    keys: &[Key],
    value: &Value,
    pointer: &str,
    name: &str,
    visit: &mut dyn FnMut(&str, &str, &[Key]),
) {
    visit(pointer, name, keys);
    for key in keys {
        let Some(inner) = value.get(&key.name) else {
            continue;
        };
        let pointer = format!("{pointer}/{}", key.name);
        let name = format!("{name}{}", key.name);
        match &key.kind {
            Kind::Table(keys) => tables(keys, inner, &pointer, &format!("{name}."), visit),
            Kind::LocalText => {
                let keys = ["de", "en"].map(|key| Key::required(key, Kind::Text, "A text."));
                visit(&pointer, &format!("{name}."), &keys);
            }
            Kind::List { of, .. } => {
                if let Kind::Table(keys) = &**of {
                    for (i, inner) in inner.as_array().into_iter().flatten().enumerate() {
                        let pointer = format!("{pointer}/{i}");
                        tables(keys, inner, &pointer, &format!("{name}[]."), visit);
                    }
                }
            }
            _ => {}
        }
    }
}

/// The full names of all keys of a schema.
fn all_names(keys: &[Key], prefix: &str, names: &mut BTreeSet<String>) {
    for key in keys {
        let name = format!("{prefix}{}", key.name);
        match &key.kind {
            Kind::Table(inner) => all_names(inner, &format!("{name}."), names),
            Kind::List { of, .. } => {
                if let Kind::Table(inner) = &**of {
                    all_names(inner, &format!("{name}[]."), names);
                }
            }
            _ => {}
        }
        names.insert(name);
    }
}

/// The names in backquotes after "expected" in a message of serde.
fn listed(message: &str) -> BTreeSet<String> {
    let (_, list) = message.split_once("expected").unwrap_or_default();
    let parts = list.split('`').skip(1).step_by(2);
    parts.map(str::to_owned).collect()
}

/// A copy of `value` in which `edit` has changed the table at `pointer`.
fn edited(
    value: &Value,
    pointer: &str,
    edit: impl FnOnce(&mut serde_json::Map<String, Value>),
) -> Value {
    let mut copy = value.clone();
    let table = copy.pointer_mut(pointer).and_then(Value::as_object_mut);
    edit(table.expect("a table at a place of the value"));
    copy
}

/// Adding a key is noticed by the type, and its list of known keys is that of the schema.
#[test]
fn types_have_the_keys_of_the_schema() {
    for (kind, text) in EXAMPLES {
        let value = read(kind, text).expect(kind);
        accept(kind, &value).expect(kind);
        tables(
            &schema(kind).keys,
            &value,
            "",
            "",
            &mut |pointer, name, keys| {
                // The keys of a module are free in the type: its manifest decides.
                if (kind, pointer) == ("level", "/module") {
                    return;
                }
                let added = edited(&value, pointer, |table| {
                    table.insert("zzz".to_owned(), json!(1));
                });
                let message = accept(kind, &added).expect_err("an unknown key");
                let expected: BTreeSet<String> = keys.iter().map(|key| key.name.clone()).collect();
                assert_eq!(listed(&message), expected, "{kind} {name} {message}");
            },
        );
    }
}

/// A key that the schema always gives is needed by the type, and one that may be missing is not.
#[test]
fn types_need_what_the_schema_always_gives() {
    for (kind, text) in EXAMPLES {
        let value = read(kind, text).expect(kind);
        tables(
            &schema(kind).keys,
            &value,
            "",
            "",
            &mut |pointer, name, keys| {
                if (kind, pointer) == ("level", "/module") {
                    return;
                }
                for key in keys {
                    let name = format!("{name}{}", key.name);
                    let removed = edited(&value, pointer, |table| {
                        table.remove(&key.name);
                    });
                    let optional = key.presence == Presence::Optional;
                    if !CONDITIONAL.contains(&name.as_str()) {
                        assert_eq!(accept(kind, &removed).is_ok(), optional, "{kind} {name}");
                    }
                }
            },
        );
    }
}

/// The reader notices each key that is added, and each required one that is missing, with the right place.
#[test]
fn the_reader_needs_what_the_schema_requires() {
    for (kind, text) in EXAMPLES {
        let mut seen = BTreeSet::new();
        let value = read(kind, text).expect(kind);
        let schema = schema(kind);
        tables(&schema.keys, &value, "", "", &mut |pointer, name, keys| {
            let table = value.pointer(pointer).and_then(Value::as_object);
            let there = |key: &Key| table.is_some_and(|table| table.contains_key(&key.name));
            seen.extend(
                keys.iter()
                    .filter(|key| there(key))
                    .map(|key| format!("{name}{}", key.name)),
            );
        });
        let mut names = BTreeSet::new();
        all_names(&schema.keys, "", &mut names);
        let missing: Vec<&String> = names
            .difference(&seen)
            .filter(|name| !NOT_IN_THE_EXAMPLE.contains(&name.as_str()) && !is_of_a_law(name))
            .collect();
        assert!(
            missing.is_empty(),
            "the example of {kind} lacks {missing:?}"
        );

        let unknown = format!("zzz = 1\n{text}");
        let errors = read(kind, &unknown).expect_err("an unknown key");
        assert!(
            errors
                .to_string()
                .starts_with("f.toml:1:1: key `zzz`: found an unknown key")
        );

        // An empty file lacks exactly the keys that are required at the top, and those of tables without choice.
        let complaints = read(kind, "").err().map_or(Vec::new(), |errors| errors.0);
        let complaints: BTreeSet<String> = complaints.iter().map(|e| e.key.to_string()).collect();
        for key in &schema.keys {
            let required = key.presence == Presence::Required;
            assert_eq!(
                complaints.contains(&key.name),
                required,
                "{kind} {}",
                key.name
            );
        }
    }
}

/// Each text that the schema offers is known to the type, and the type knows no other.
#[test]
fn types_have_the_choices_of_the_schema() {
    for (kind, text) in EXAMPLES {
        let value = read(kind, text).expect(kind);
        tables(
            &schema(kind).keys,
            &value,
            "",
            "",
            &mut |pointer, name, keys| {
                for key in keys {
                    let (Kind::Choice(choices) | Kind::ChoiceOr(choices, _)) = &key.kind else {
                        continue;
                    };
                    let with = |choice: &str| {
                        let changed = edited(&value, pointer, |table| {
                            table.insert(key.name.clone(), json!(choice));
                        });
                        accept(kind, &changed)
                    };
                    for choice in choices {
                        // A shape without its sizes, or with the file of a model, is refused, but known.
                        let message = with(choice).err().unwrap_or_default();
                        let refused = ["sizes of", "keys of"];
                        let known = message.is_empty()
                            || refused.iter().any(|start| message.starts_with(start));
                        assert!(known, "{kind} {name}{} {choice}: {message}", key.name);
                    }
                    let message = with("zzz").err().unwrap_or_default();
                    if message.starts_with("unknown variant") {
                        let choices: BTreeSet<String> = choices.iter().cloned().collect();
                        assert_eq!(listed(&message), choices, "{kind} {name}{}", key.name);
                    }
                }
            },
        );
    }
}

/// A default is a value that the file could have given, in SI, and reads as itself.
#[test]
fn defaults_are_legal_values() {
    fn check(keys: &[Key], name: &str) {
        for key in keys {
            let name = format!("{name}.{}", key.name);
            assert!(!key.doc.trim().is_empty(), "{name} has no doc");
            match &key.kind {
                Kind::Table(inner) => check(inner, &name),
                Kind::List { of, .. } => {
                    if let Kind::Table(inner) = &**of {
                        check(inner, &name);
                    }
                }
                _ => {}
            }
            if let (Presence::Default(default), false) =
                (&key.presence, matches!(key.kind, Kind::Table(_)))
            {
                let schema = Schema {
                    name: "one key".to_owned(),
                    doc: String::new(),
                    keys: vec![Key::required("k", key.kind.clone(), "The key.")],
                };
                // JSON of these values is TOML.
                let document = Document::read(&format!("k = {default}"), "f.toml", &schema);
                assert_eq!(document.expect(&name).value()["k"], *default, "{name}");
            }
        }
    }
    for (kind, _) in EXAMPLES {
        check(&schema(kind).keys, kind);
    }
}

/// The JSON Schema has each key with its meaning; the reference has a row for each.
#[test]
fn schemas_are_printed_whole() {
    fn check(keys: &[Key], schema: &Value) {
        assert_eq!(schema["type"], "object");
        assert_eq!(schema["additionalProperties"], false);
        let properties = schema["properties"].as_object().expect("an object");
        assert_eq!(properties.len(), keys.len());
        for key in keys {
            let property = &properties[&key.name];
            assert_eq!(property["description"], json!(key.doc));
            let required = schema["required"]
                .as_array()
                .expect("a list")
                .contains(&json!(key.name));
            assert_eq!(required, key.presence == Presence::Required, "{}", key.name);
            match &key.kind {
                Kind::Table(inner) => check(inner, property),
                Kind::List { of, .. } => {
                    if let Kind::Table(inner) = &**of {
                        check(inner, &property["items"]);
                    }
                }
                Kind::Quantity { unit, min, max } => {
                    assert_eq!(property["unit"], unit.symbol());
                    assert_eq!(property["anyOf"][0]["minimum"], json!(min));
                    assert_eq!(property["anyOf"][0]["maximum"], json!(max));
                }
                _ => {}
            }
        }
    }
    for (kind, _) in KINDS {
        let schema = schema_for(kind).expect(kind);
        let json = json_schema(&schema);
        assert_eq!(
            json["$schema"],
            "https://json-schema.org/draft/2020-12/schema"
        );
        check(&schema.keys, &json);

        let table = reference(&schema);
        let mut names = BTreeSet::new();
        all_names(&schema.keys, "", &mut names);
        for name in names {
            assert!(
                table.contains(&format!("| `{name}` |")),
                "{kind} {name}\n{table}"
            );
        }
    }
    assert_eq!(schema_for("nothing"), None);
}
