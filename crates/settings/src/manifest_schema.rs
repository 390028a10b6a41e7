//! The keys of a manifest.

use crate::manifest::KeyType;
use crate::schema::{Form, Key, Kind, Schema};
use microsim_vocabulary::{Category, Direction, Overflow, PluginKind, Unit};

/// Most components of a vector key.
const KEY_VECTOR_MAX: i64 = 16;

/// The schema of `plugin.toml` and `module.toml`.
pub fn manifest_schema() -> Schema {
    let name = |doc| Key::required("name", Kind::Name(Form::Identifier), doc);
    let id = |doc| Key::required("id", Kind::Name(Form::Identifier), doc);
    let message_kinds = |name, doc| Key::list(name, Kind::Name(Form::Message), 64, doc);
    Schema {
        name: "manifest".to_owned(),
        doc:
            "plugin.toml and module.toml: what a plugin or training module is, needs and declares."
                .to_owned(),
        keys: vec![
            name("Unique among all plugins and modules."),
            Key::required(
                "kind",
                Kind::choice(&PluginKind::NAMES),
                "What it does in the tick.",
            ),
            Key::required("version", Kind::Name(Form::Version), "Its own version."),
            Key::required(
                "abi",
                Kind::Integer {
                    min: 1,
                    max: 65_535,
                },
                "Version of the plugin contract that it was built for.",
            ),
            Key::required("licence", Kind::Text, "SPDX expression."),
            Key::required(
                "library",
                Kind::Name(Form::Symbol),
                "Base name of the dynamic library beside this file, without prefix and extension.",
            ),
            Key::required("title", Kind::LocalText, "Its name for people."),
            Key::required(
                "summary",
                Kind::LocalText,
                "What it is for, in a sentence for people.",
            ),
            message_kinds("publishes", "Message kinds that it sends."),
            message_kinds("subscribes", "Message kinds that it receives."),
            Key::list(
                "plugins",
                Kind::Name(Form::Identifier),
                32,
                "Only for a module: plugins that it uses, by name, besides those that the run itself brings (source, recorder, renderer).",
            ),
            Key::list(
                "message",
                Kind::Table(vec![
                    Key::required(
                        "name",
                        Kind::Name(Form::Message),
                        "Begins with the plugin's name and a dot.",
                    ),
                    Key::required(
                        "version",
                        Kind::Integer {
                            min: 1,
                            max: 65_535,
                        },
                        "Version of its content.",
                    ),
                    Key::required("doc", Kind::Text, "What it says."),
                    Key::required(
                        "overflow",
                        Kind::choice(&Overflow::NAMES),
                        "What happens when its queue is full.",
                    ),
                ]),
                64,
                "Message kinds of its own.",
            ),
            Key::list(
                "key",
                Kind::Table(module_key_keys()),
                64,
                "Only for a module: the keys of the table [module] in its levels.",
            ),
            Key::list(
                "metric",
                Kind::Table(metric_keys()),
                64,
                "Only for a module: metrics that it computes.",
            ),
            Key::list(
                "reason",
                Kind::Table(vec![
                    id("Its name in results and in the limits of levels."),
                    Key::required(
                        "text",
                        Kind::LocalText,
                        "The reason in a sentence for people.",
                    ),
                ]),
                64,
                "Only for a module: reasons for which a level can be failed.",
            ),
            Key::list(
                "file",
                Kind::Table(vec![
                    name("By which the plugin asks for it."),
                    Key::required(
                        "path",
                        Kind::Name(Form::RelativePath),
                        "Where it lies, below the folder of this file.",
                    ),
                ]),
                64,
                "Files that the host hands to the plugin as bytes.",
            ),
        ],
    }
}

fn module_key_keys() -> Vec<Key> {
    let dependent = |of: &str| Kind::Dependent(format!("a value of the key's `type`{of}"));
    vec![
        Key::required("name", Kind::Name(Form::Symbol), "As levels write it."),
        Key::required(
            "type",
            Kind::choice(&KeyType::NAMES),
            "What its value may be.",
        ),
        Key::optional(
            "unit",
            unit_kind(),
            "Only and always for a quantity or vector: its SI unit.",
        ),
        Key::optional(
            "min",
            dependent(" and unit"),
            "Only and always for a quantity, vector or integer: the smallest value.",
        ),
        Key::optional(
            "max",
            dependent(" and unit"),
            "Only and always for a quantity, vector or integer: the largest value.",
        ),
        Key::optional(
            "len",
            Kind::Integer {
                min: 1,
                max: KEY_VECTOR_MAX,
            },
            "Only and always for a vector: the number of components.",
        ),
        Key::list(
            "values",
            Kind::Text,
            64,
            "Only and always for a choice: its texts.",
        ),
        Key::optional(
            "default",
            dependent(", within its range"),
            "What holds where a level leaves the key out; without it the key is required.",
        ),
        Key::required("doc", Kind::Text, "What it means."),
    ]
}

fn metric_keys() -> Vec<Key> {
    vec![
        Key::required(
            "id",
            Kind::Name(Form::Identifier),
            "Its name in limits and results.",
        ),
        Key::required("unit", unit_kind(), "SI unit of its values."),
        Key::optional(
            "display_unit",
            Kind::Text,
            "Symbol in which people read it, of the same dimension as `unit`; that of `unit` if left out.",
        ),
        Key::required(
            "direction",
            Kind::choice(&Direction::NAMES),
            "Whether lower or higher values are better, or whether it only informs.",
        ),
        Key::required(
            "category",
            Kind::choice(&Category::NAMES),
            "Which part of the score it belongs to.",
        ),
        Key::required(
            "formula",
            Kind::Text,
            "Name and version of its formula, such as `angle-error/1`.",
        ),
        Key::required("source", Kind::Text, "Where its definition comes from."),
        Key::required("title", Kind::LocalText, "Its name for people."),
        Key::required(
            "advice",
            Kind::LocalText,
            "What to do better, in a sentence for people.",
        ),
    ]
}

fn unit_kind() -> Kind {
    Kind::Choice(Unit::ALL.map(|unit| unit.symbol().to_owned()).to_vec())
}
