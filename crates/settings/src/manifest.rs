//! `plugin.toml` and `module.toml`: what a plugin is, what flows in and out of it, and what a training module declares:
//! the keys of its levels, its metrics, its reasons for failing, its texts.

use crate::kinds::{dependent, identifier, list, message_kind, relative_path, symbol, version};
use crate::schema::{Key, Kind, Presence};
use crate::table::{choices, table};
use microsim_vocabulary::{Category, Direction, LocalText, Overflow, PluginKind, Unit, terms};
use serde_json::Value;

table! {
    /// What a plugin or module declares of itself.
    pub struct Manifest {
        /// Unique among all plugins and modules.
        name: String = identifier(),
        /// What it does in the tick.
        kind: PluginKind,
        /// Its own version.
        version: String = version(),
        /// Version of the plugin contract that it was built for.
        abi: u32 [1, 65_535],
        /// SPDX expression.
        licence: String,
        /// Base name of the dynamic library beside this file, without prefix and extension.
        library: String = symbol(),
        /// Whether it always runs in a process of its own, also where the installation brought its library; only for sources, translators and
        /// modules.
        isolate: bool => false,
        /// Its name for people.
        title: LocalText,
        /// What it is for, in a sentence for people.
        summary: LocalText,
        /// Message kinds that it sends.
        publishes: Vec<String> = list(message_kind(), 0, 64),
        /// Message kinds that it receives.
        subscribes: Vec<String> = list(message_kind(), 0, 64),
        /// Only for a module: plugins that it uses, by name, besides those that the run itself brings (source,
        /// recorder, renderer).
        plugins: Vec<String> = list(identifier(), 0, 32),
        /// Message kinds of its own.
        message: Vec<MessageKind> [0, 64],
        /// Only for a module: the keys of the table `[module]` in its levels.
        key: Vec<ModuleKey> [0, 64],
        /// Only for a module: metrics that it computes.
        metric: Vec<ModuleMetric> [0, 64],
        /// Only for a module: reasons for which a level can be failed.
        reason: Vec<Reason> [0, 64],
        /// Files that the host hands to the plugin as bytes.
        file: Vec<PluginFile> [0, 64],
    }
}

table! {
    /// A message kind that a plugin brings.
    pub struct MessageKind {
        /// Begins with the plugin's name and a dot.
        name: String = message_kind(),
        /// Version of its content.
        version: u32 [1, 65_535],
        /// What it states.
        doc: String,
        /// What happens when its queue is full.
        overflow: Overflow,
    }
}

table! {
    /// A key of a level's table `[module]`.
    pub struct ModuleKey {
        /// As levels write it.
        name: String = symbol(),
        /// What its value may be.
        value_type as "type": KeyType,
        /// Only and always for a quantity or vector: its SI unit.
        unit: Option<Unit>,
        /// Only and always for a quantity, vector or integer: the smallest value.
        min: Option<f64> = dependent("a value of the key's `type` and unit"),
        /// Only and always for a quantity, vector or integer: the largest value.
        max: Option<f64> = dependent("a value of the key's `type` and unit"),
        /// Only and always for a vector: the number of components.
        len: Option<usize> [1, 16],
        /// Only and always for a choice: its texts.
        values: Vec<String> [0, 64],
        /// What holds where a level leaves the key out; without it the key is required.
        default: Option<Value> = dependent("a value of the key's `type`, within its range"),
        /// What it means.
        doc: String,
    }
}

terms! {
    /// What the value of a module's key may be.
    pub enum KeyType {
        /// A number with a unit.
        Quantity = "quantity",
        /// A whole number.
        Integer = "integer",
        /// `true` or `false`.
        Bool = "bool",
        /// A text.
        Text = "text",
        /// One of some texts.
        Choice = "choice",
        /// Several quantities of one unit.
        Vector = "vector",
    }
}

table! {
    /// A metric that a module computes.
    pub struct ModuleMetric {
        /// Its name in limits and results.
        id: String = identifier(),
        /// SI unit of its values.
        unit: Unit,
        /// Symbol in which people read it, of the same dimension as `unit`; that of `unit` if left out.
        display_unit: Option<String>,
        /// Whether lower or higher values are better, or whether it only informs.
        direction: Direction,
        /// Which part of the score it belongs to.
        category: Category,
        /// Name and version of its formula, such as `angle-error/1`.
        formula: String,
        /// Where its definition comes from.
        source: String,
        /// Its name for people.
        title: LocalText,
        /// What to do better, in a sentence for people.
        advice: LocalText,
    }
}

table! {
    /// Why a level can be failed.
    pub struct Reason {
        /// Its name in results and in the limits of levels.
        id: String = identifier(),
        /// The reason in a sentence for people.
        text: LocalText,
    }
}

table! {
    /// A file of the plugin's own.
    pub struct PluginFile {
        /// By which the plugin asks for it.
        name: String = identifier(),
        /// Where it lies, below the folder of this file.
        path: String = relative_path(),
    }
}

choices!(KeyType);

impl KeyType {
    /// What a value of this type may be; `None` if something that the type needs is missing.
    pub(crate) fn value_kind(
        self,
        unit: Option<Unit>,
        min: Option<f64>,
        max: Option<f64>,
        len: Option<usize>,
        values: Vec<String>,
    ) -> Option<Kind> {
        Some(match self {
            KeyType::Quantity => Kind::quantity(unit?, min?, max?),
            KeyType::Vector => Kind::Vector {
                unit: unit?,
                len: len?,
                min: min?,
                max: max?,
            },
            // The bounds were read as whole numbers of at most ten digits, which an f64 holds exactly.
            KeyType::Integer => Kind::Integer {
                min: min? as i64,
                max: max? as i64,
            },
            KeyType::Bool => Kind::Bool,
            KeyType::Choice => Kind::Choice(values),
            KeyType::Text => Kind::Text,
        })
    }
}

impl Manifest {
    /// The keys that the table `[module]` of this module's levels has.
    pub fn module_keys(&self) -> Vec<Key> {
        self.key.iter().filter_map(ModuleKey::key).collect()
    }
}

impl ModuleKey {
    /// As the reader wants it; `None` only for a key that [`read_manifest`] would have refused.
    fn key(&self) -> Option<Key> {
        let values = self.values.clone();
        let kind = self
            .value_type
            .value_kind(self.unit, self.min, self.max, self.len, values)?;
        let presence = match &self.default {
            Some(value) => Presence::Default(value.clone()),
            None => Presence::Required,
        };
        Some(Key {
            name: self.name.clone(),
            kind,
            doc: self.doc.clone(),
            presence,
        })
    }
}
