//! A schema for editors (JSON Schema, draft 2020-12) and for people (a Markdown table).
//!
//! A quantity carries its SI symbol in the annotation `unit`, which JSON Schema lets validators ignore.

use crate::read::{english_text_keys, local_text_keys};
use crate::schema::{Form, Key, Kind, Presence, Schema, range};
use microsim_vocabulary::Unit;
use serde_json::{Map, Value, json};

/// The JSON Schema of a kind of file.
pub fn json_schema(schema: &Schema) -> Value {
    let mut document = table_schema(&schema.keys);
    document["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    document["title"] = json!(schema.name);
    document["description"] = json!(schema.doc);
    document
}

/// The keys of a kind of file as one Markdown table, inner tables by their full names.
pub fn reference(schema: &Schema) -> String {
    let mut lines = format!(
        "# {}\n\n{}\n\n| key | value | default | meaning |\n|---|---|---|---|\n",
        schema.name, schema.doc
    );
    reference_rows(&schema.keys, "", &mut lines);
    lines
}

fn table_schema(keys: &[Key]) -> Value {
    let mut properties = Map::new();
    for key in keys {
        let mut value = kind_schema(&key.kind);
        value["description"] = json!(key.doc);
        if let Presence::Default(default) = &key.presence {
            value["default"] = default.clone();
        }
        properties.insert(key.name.clone(), value);
    }
    let required: Vec<&str> = keys
        .iter()
        .filter(|key| key.presence == Presence::Required)
        .map(|key| key.name.as_str())
        .collect();
    json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn kind_schema(kind: &Kind) -> Value {
    match kind {
        Kind::Text => json!({"type": "string", "pattern": "\\S"}),
        Kind::Name(form) => json!({"type": "string", "pattern": form_pattern(*form)}),
        Kind::Bool => json!({"type": "boolean"}),
        Kind::Integer { min, max } => json!({"type": "integer", "minimum": min, "maximum": max}),
        Kind::Quantity { unit, min, max } => quantity_schema(*unit, *min, *max),
        Kind::Vector {
            unit,
            len,
            min,
            max,
        } => list_schema(quantity_schema(*unit, *min, *max), *len, *len),
        Kind::Quaternion => {
            let component = json!({"type": "number", "minimum": -1.001, "maximum": 1.001});
            list_schema(component, 4, 4)
        }
        Kind::Direction => list_schema(json!({"type": "number"}), 3, 3),
        Kind::Choice(values) => json!({"enum": values}),
        Kind::ChoiceOr(values, other) => json!({"anyOf": [{"enum": values}, kind_schema(other)]}),
        Kind::Colour => json!({"type": "string", "pattern": "^#[0-9a-fA-F]{6}$"}),
        Kind::LocalText => table_schema(&local_text_keys()),
        Kind::EnglishText => table_schema(&english_text_keys()),
        Kind::Table(keys) => table_schema(keys),
        Kind::List { of, min, max } => list_schema(kind_schema(of), *min, *max),
        Kind::Map { keys, of } => json!({
            "type": "object",
            "propertyNames": {"pattern": form_pattern(*keys)},
            "additionalProperties": kind_schema(of),
        }),
        Kind::Dependent(_) => json!({"type": ["number", "string", "boolean", "array"]}),
    }
}

fn list_schema(items: Value, min: usize, max: usize) -> Value {
    json!({"type": "array", "items": items, "minItems": min, "maxItems": max})
}

fn quantity_schema(unit: Unit, min: f64, max: f64) -> Value {
    let mut number = json!({"type": "number"});
    // An infinite bound is no JSON number, and no bound.
    if min.is_finite() {
        number["minimum"] = json!(min);
    }
    if max.is_finite() {
        number["maximum"] = json!(max);
    }
    let symbols: Vec<String> = unit.symbols().map(|s| s.replace('^', "\\^")).collect();
    let optional = match unit {
        Unit::Ratio | Unit::Count => "?",
        _ => "",
    };
    let symbols = symbols.join("|");
    let text = json!({
        "type": "string",
        "pattern": format!("^\\s*[+-]?\\d+(\\.\\d+)?([eE][+-]?\\d+)?\\s*({symbols}){optional}\\s*$"),
    });
    json!({"anyOf": [number, text], "unit": unit.symbol()})
}

fn form_pattern(form: Form) -> &'static str {
    match form {
        Form::Identifier => "^[a-z][a-z0-9]*(-[a-z0-9]+)*$",
        Form::Symbol => "^[a-z][a-z0-9]*(_[a-z0-9]+)*$",
        Form::FileName => "^[a-z0-9][a-z0-9_-]*\\.[a-z0-9]+$",
        Form::Message => "^[a-z][a-z0-9-]*(\\.[a-z][a-z0-9-]*)+$",
        Form::Version => "^\\d+\\.\\d+\\.\\d+$",
        Form::RelativePath => "^(?!(.*/)?\\.{0,2}(/|$))[^\\\\:]+$",
    }
}

fn reference_rows(keys: &[Key], prefix: &str, lines: &mut String) {
    for key in keys {
        let name = format!("{prefix}{}", key.name);
        let default = match &key.presence {
            Presence::Required => "required".to_owned(),
            Presence::Optional => "none".to_owned(),
            Presence::Default(value) => default_text(&key.kind, value),
        };
        let value = value_text(&key.kind).replace('|', "\\|");
        let doc = key.doc.replace('|', "\\|");
        lines.push_str(&format!("| `{name}` | {value} | {default} | {doc} |\n"));
        match &key.kind {
            Kind::Table(inner) => reference_rows(inner, &format!("{name}."), lines),
            Kind::List { of, .. } => {
                if let Kind::Table(inner) = &**of {
                    reference_rows(inner, &format!("{name}[]."), lines);
                }
            }
            _ => {}
        }
    }
}

/// What the value may be; shorter than [`Kind::expected`], which also explains how to write it.
fn value_text(kind: &Kind) -> String {
    match kind {
        Kind::Quantity { unit, min, max } => range(*unit, *min, *max),
        Kind::Vector {
            unit,
            len,
            min,
            max,
        } => format!("list of {len}, each {}", range(*unit, *min, *max)),
        Kind::List { of, min, max } => format!("list of {min} to {max}, each {}", value_text(of)),
        Kind::Map { of, .. } => format!("table of free keys, each {}", value_text(of)),
        kind => kind.expected(),
    }
}

fn default_text(kind: &Kind, value: &Value) -> String {
    match (kind, value.as_f64()) {
        (Kind::Quantity { unit, .. }, Some(si)) => unit.describe(si),
        (Kind::Table(_), _) => "its keys'".to_owned(),
        _ => format!("`{value}`"),
    }
}
