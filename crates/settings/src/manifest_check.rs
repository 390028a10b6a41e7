//! What a manifest must fulfil beyond its single values: names, the plugin's kind, the ranges and defaults of keys.

use crate::check::{items, refers, texts, unique};
use crate::document::Reading;
use crate::document::{Loaded, load_text};
use crate::error::ConfigErrors;
use crate::error::KeyPath;
use crate::files::schema_of;
use crate::manifest::KeyType;
use crate::manifest::Manifest;
use crate::schema::Kind;
use microsim_vocabulary::{PluginKind, Unit};
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;

/// Bounds that the `[[key]]` of a manifest may set for whole numbers.
const KEY_INTEGER_BOUND: i64 = 1_000_000_000;
/// Reads a manifest from a text; `file` is the name that complaints use.
pub fn read_manifest(text: &str, file: &str) -> Result<Loaded<Manifest>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<Manifest>("manifest"))?;
    check(&mut reading);
    reading.finish()
}

/// Reads the manifest at `path`.
pub fn load_manifest(path: &Path) -> Result<Loaded<Manifest>, ConfigErrors> {
    let expected = "the manifest of a plugin (plugin.toml) or module (module.toml)";
    read_manifest(&load_text(path, expected)?, &path.display().to_string())
}

/// Complains about all that is wrong in a manifest that was read by its schema.
fn check(reading: &mut Reading) {
    let root = KeyPath::root();
    for (list, field) in [
        ("message", "name"),
        ("key", "name"),
        ("metric", "id"),
        ("reason", "id"),
        ("file", "name"),
    ] {
        let names = texts(reading.value(), list, field);
        unique(reading, &root, &names, list, field);
    }
    for list in ["publishes", "subscribes", "plugins"] {
        let names: Vec<String> = items(reading.value(), list)
            .map(|(_, name)| name.as_str().unwrap_or_default().to_owned())
            .collect();
        for (i, name) in names.iter().enumerate() {
            if !name.is_empty() && names[..i].contains(name) {
                reading.complain(
                    &root.key(list).at(i),
                    &format!("`{name}` a second time"),
                    "each name once",
                );
            }
        }
    }
    check_module_only(reading);
    check_isolated(reading);
    check_own_messages(reading);
    check_display_units(reading);
    let keys: Vec<(usize, Value)> = items(reading.value(), "key")
        .map(|(i, key)| (i, key.clone()))
        .collect();
    for (i, key) in keys {
        check_key(reading, &root.key("key").at(i), &key);
    }
}

fn check_module_only(reading: &mut Reading) {
    let kind = reading.value()["kind"]
        .as_str()
        .unwrap_or("module")
        .to_owned();
    if kind == "module" {
        return;
    }
    for list in ["plugins", "key", "metric", "reason"] {
        if items(reading.value(), list).next().is_some() {
            let expected = "none, as only a module has these";
            reading.complain(
                &KeyPath::root().key(list),
                &format!("`{list}` in a plugin of kind `{kind}`"),
                expected,
            );
        }
    }
}

fn check_isolated(reading: &mut Reading) {
    let kind = reading.value()["kind"].as_str().unwrap_or_default();
    let Some(kind) = PluginKind::from_name(kind).filter(|kind| !kind.can_be_isolated()) else {
        return;
    };
    if reading.value()["isolate"] == true {
        let kind = kind.name();
        reading.complain(
            &KeyPath::root().key("isolate"),
            &format!("`true` in a plugin of kind `{kind}`"),
            "`false`, as only sources, translators and modules can run in a process of their own",
        );
    }
}

fn check_own_messages(reading: &mut Reading) {
    let Some(plugin) = reading.value()["name"]
        .as_str()
        .map(|name| format!("{name}."))
    else {
        return;
    };
    for (i, name) in texts(reading.value(), "message", "name") {
        if !name.starts_with(&plugin) {
            let key = KeyPath::root().key("message").at(i).key("name");
            reading.complain(
                &key,
                &format!("`{name}`"),
                &format!("a message kind that begins with `{plugin}`"),
            );
        }
    }
}

fn check_display_units(reading: &mut Reading) {
    let metrics: Vec<(usize, Option<Unit>, String)> = items(reading.value(), "metric")
        .filter_map(|(i, metric)| {
            let unit = metric["unit"].as_str().and_then(Unit::of_symbol);
            Some((i, unit, metric["display_unit"].as_str()?.to_owned()))
        })
        .collect();
    for (i, unit, symbol) in metrics {
        let Some(unit) = unit else { continue };
        let symbols: Vec<&str> = unit.symbols().collect();
        let key = KeyPath::root().key("metric").at(i).key("display_unit");
        refers(
            reading,
            &key,
            &symbol,
            "a unit of the same dimension",
            &symbols,
        );
    }
}

/// Reads the bounds and the default of a module's key by its type and unit.
fn check_key(reading: &mut Reading, path: &KeyPath, key: &Value) {
    let Ok(kind) = KeyType::deserialize(&key["type"]) else {
        return;
    };
    let has_unit = matches!(kind, KeyType::Quantity | KeyType::Vector);
    let has_range = has_unit || kind == KeyType::Integer;
    let complete = [
        ("unit", has_unit),
        ("min", has_range),
        ("max", has_range),
        ("len", kind == KeyType::Vector),
        ("values", kind == KeyType::Choice),
    ]
    .map(|(field, wanted)| belongs(reading, path, kind, field, wanted));
    let unit = key["unit"].as_str().and_then(Unit::of_symbol);
    if complete.contains(&false) || has_unit != unit.is_some() {
        return;
    }

    let bound = match unit {
        Some(unit) => Kind::quantity(unit, f64::NEG_INFINITY, f64::INFINITY),
        None => Kind::Integer {
            min: -KEY_INTEGER_BOUND,
            max: KEY_INTEGER_BOUND,
        },
    };
    let [min, max] = ["min", "max"].map(|field| {
        let value = reading.refine(&path.key(field), &bound);
        value.and_then(|value| value.as_f64())
    });
    if min.zip(max).is_some_and(|(min, max)| min > max) {
        reading.complain(
            &path.key("min"),
            "a `min` above `max`",
            "a range that is not empty",
        );
        return;
    }
    let texts = items(key, "values").filter_map(|(_, text)| Some(text.as_str()?.to_owned()));
    let len = key["len"].as_u64().map(|len| len as usize);
    if let Some(kind) = kind.value_kind(unit, min, max, len, texts.collect()) {
        reading.refine(&path.key("default"), &kind);
    }
}

/// Whether a field of a key that depends on its type is written if and only if it is `wanted`; complains if not.
fn belongs(
    reading: &mut Reading,
    path: &KeyPath,
    kind: KeyType,
    field: &str,
    wanted: bool,
) -> bool {
    let written = reading.is_written(&path.key(field));
    let kind = kind.name();
    match (written, wanted) {
        (false, true) => {
            let expected = format!("`{field}`, which a key of type `{kind}` needs");
            reading.complain(&path.key(field), "nothing", &expected);
        }
        (true, false) => {
            let expected = format!("no `{field}`, as the key is of type `{kind}`");
            reading.complain(&path.key(field), &format!("`{field}`"), &expected);
        }
        _ => {}
    }
    written == wanted
}
