//! `plugin.toml` and `module.toml`: what a plugin is, what flows in and out of it, and what a training module declares:
//! the keys of its levels, its metrics, its reasons for failing, its texts.

use crate::document::{Loaded, Reading, load_text};
use crate::error::ConfigErrors;
use crate::manifest_check::check;
use crate::manifest_schema::manifest_schema;
use crate::schema::{Key, Kind, Presence};
use microsim_vocabulary::{Category, Direction, LocalText, Overflow, PluginKind, Unit, terms};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// What a plugin or module says of itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Unique among plugins and modules.
    pub name: String,
    /// What it does in the tick.
    pub kind: PluginKind,
    /// Its own version, three numbers.
    pub version: String,
    /// Version of the plugin contract that it was built for.
    pub abi: u32,
    /// SPDX expression.
    pub licence: String,
    /// Base name of the dynamic library beside the manifest, without prefix and extension.
    pub library: String,
    /// For people: its name.
    pub title: LocalText,
    /// For people: what it is for, in a sentence.
    pub summary: LocalText,
    /// Message kinds that it sends.
    pub publishes: Vec<String>,
    /// Message kinds that it receives.
    pub subscribes: Vec<String>,
    /// Plugins that a module uses, besides those that the run itself brings.
    pub plugins: Vec<String>,
    /// Message kinds of its own.
    pub message: Vec<MessageKind>,
    /// Keys of the table `[module]` in its levels.
    pub key: Vec<ModuleKey>,
    /// Metrics of its own.
    pub metric: Vec<ModuleMetric>,
    /// Reasons for which its levels can be failed.
    pub reason: Vec<Reason>,
    /// Files that the host hands to the plugin as bytes.
    pub file: Vec<PluginFile>,
}

/// A message kind that a plugin brings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MessageKind {
    /// Begins with the plugin's name and a dot.
    pub name: String,
    /// Version of its content.
    pub version: u32,
    /// What it says.
    pub doc: String,
    /// What happens when its queue is full.
    pub overflow: Overflow,
}

/// A key of a level's table `[module]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModuleKey {
    /// As levels write it.
    pub name: String,
    /// What its value may be.
    #[serde(rename = "type")]
    pub value_type: KeyType,
    /// Of a quantity and of each component of a vector.
    pub unit: Option<Unit>,
    /// Smallest value, in SI.
    pub min: Option<f64>,
    /// Largest value, in SI.
    pub max: Option<f64>,
    /// Number of components of a vector.
    pub len: Option<usize>,
    /// Of a choice.
    pub values: Vec<String>,
    /// Holds where a level leaves the key out, in SI; a key without it is required.
    pub default: Option<Value>,
    /// What it means.
    pub doc: String,
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

/// A metric that a module computes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModuleMetric {
    /// Its name in limits and results.
    pub id: String,
    /// Values are in this unit's SI symbol.
    pub unit: Unit,
    /// Symbol in which people read it; that of `unit` if left out.
    pub display_unit: Option<String>,
    /// Which values are good.
    pub direction: Direction,
    /// Which part of the score it belongs to.
    pub category: Category,
    /// Name and version of its formula.
    pub formula: String,
    /// Where the definition comes from.
    pub source: String,
    /// For people: its name.
    pub title: LocalText,
    /// For people: what to do better.
    pub advice: LocalText,
}

/// Why a level can be failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reason {
    /// Its name in results.
    pub id: String,
    /// For people.
    pub text: LocalText,
}

/// A file of the plugin's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PluginFile {
    /// By which the plugin asks for it.
    pub name: String,
    /// Below the folder of the manifest.
    pub path: String,
}

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

/// Reads a manifest from a text; `file` is the name that complaints use.
pub fn read_manifest(text: &str, file: &str) -> Result<Loaded<Manifest>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &manifest_schema())?;
    check(&mut reading);
    reading.finish()
}

/// Reads the manifest at `path`.
pub fn load_manifest(path: &Path) -> Result<Loaded<Manifest>, ConfigErrors> {
    let expected = "the manifest of a plugin (plugin.toml) or module (module.toml)";
    read_manifest(&load_text(path, expected)?, &path.display().to_string())
}
