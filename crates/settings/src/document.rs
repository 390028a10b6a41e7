//! A file that has been read: its text, its values in SI, and the place of each.

use crate::error::{ConfigError, ConfigErrors, KeyPath, Position};
use crate::overrides::Override;
use crate::read::Reader;
use crate::schema::{Kind, Schema};
use crate::tree::{Item, Node};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Where settings came from: enough to hash them, to record them and to complain about them later with file:line.
#[derive(Clone, Debug)]
pub struct Document {
    file: String,
    text: String,
    /// The values that were not taken from the file, as they were written.
    overrides: Vec<String>,
    root: Node,
    value: Value,
}

/// Typed settings with their origin.
#[derive(Clone, Debug)]
pub struct Loaded<T> {
    /// The settings, checked, in SI.
    pub settings: T,
    /// The file that they were read from.
    pub document: Document,
}

impl Document {
    /// Reads a text by a schema. `file` is the name that complaints use. All complaints are collected.
    pub fn read(text: &str, file: &str, schema: &Schema) -> Result<Document, ConfigErrors> {
        let reading = Reading::new(text, file, schema)?;
        reading.document()
    }

    /// The file as it was named when it was read.
    pub fn path(&self) -> PathBuf {
        PathBuf::from(&self.file)
    }

    /// The text as it was read, byte for byte.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The values in SI, with the defaults filled in.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// Whether something stands at `key` in the file.
    pub(crate) fn is_written(&self, key: &KeyPath) -> bool {
        self.root.get(key).is_some()
    }

    /// The number or text at `key` as the file has it; `None` for what is not written there, or is neither.
    pub(crate) fn written(&self, key: &KeyPath) -> Option<String> {
        let node = self.root.get(key)?;
        match &node.item {
            Item::Text(text) => Some(text.clone()),
            Item::Integer(number) => Some(number.to_string()),
            _ => None,
        }
    }

    /// A complaint about the value at `key`, for checks that need more than this file.
    pub fn error_at(&self, key: &KeyPath, found: &str, expected: &str) -> ConfigError {
        let error = ConfigError {
            file: self.file.clone(),
            position: Some(self.root.position(key)),
            key: key.clone(),
            found: found.to_owned(),
            expected: expected.to_owned(),
        };
        self.placed(error)
    }

    /// Where the value at `key` stands, in words that a message can begin with: ``FILE:LINE:COLUMN: key `a.b` ``.
    pub fn place(&self, key: &KeyPath) -> String {
        let error = self.error_at(key, "", "");
        let at = error
            .position
            .map(|at| format!(":{}:{}", at.line, at.column));
        format!("{}{}: key `{key}`", error.file, at.unwrap_or_default())
    }

    /// A complaint that names the override where one is to blame.
    fn placed(&self, mut error: ConfigError) -> ConfigError {
        if let Some(Position { line: 0, column }) = error.position {
            error.file = format!("--set {}", self.overrides[column]);
            error.position = None;
        }
        error
    }
}

/// A file between text and typed settings: the checks that go beyond single values work on this.
pub(crate) struct Reading {
    document: Document,
    errors: Vec<ConfigError>,
}

impl Reading {
    /// Reads a text by a schema. Fails at once only if the text is no TOML; otherwise complaints are collected until the end.
    pub fn new(text: &str, file: &str, schema: &Schema) -> Result<Reading, ConfigErrors> {
        let root = Node::parse(text, file).map_err(sorted)?;
        Ok(Self::of_tree(root, text, file, schema, &[]))
    }

    /// The same of a tree: that of the text, with what has been put into it. `overrides` are those whose places are in it.
    pub fn of_tree(
        root: Node,
        text: &str,
        file: &str,
        schema: &Schema,
        overrides: &[Override],
    ) -> Reading {
        let mut reader = Reader {
            file,
            errors: Vec::new(),
        };
        let value = reader.table(&root, &schema.keys, &KeyPath::root());
        let errors = reader.errors;
        let document = Document {
            file: file.to_owned(),
            text: text.to_owned(),
            overrides: overrides.iter().map(|o| o.text().to_owned()).collect(),
            root,
            value: value.unwrap_or_default(),
        };
        let errors = errors.into_iter().map(|e| document.placed(e)).collect();
        Reading { document, errors }
    }

    /// The values so far. What was wrong is missing (or null in a list), so checks ask for everything with `get`.
    pub fn value(&self) -> &Value {
        &self.document.value
    }

    /// The value at `key`, if it is there and right.
    pub fn value_at(&self, key: &KeyPath) -> Option<&Value> {
        use crate::error::Step;
        key.steps()
            .iter()
            .try_fold(self.value(), |value, step| match step {
                Step::Key(key) => value.get(key),
                Step::Index(index) => value.get(index),
            })
    }

    /// Whether something stands at `key` in the file, right or wrong.
    pub fn is_written(&self, key: &KeyPath) -> bool {
        self.document.root.get(key).is_some()
    }

    /// What ends the reading at once.
    pub fn refuse(&self, errors: Vec<ConfigError>) -> ConfigErrors {
        let placed = errors.into_iter().map(|e| self.document.placed(e));
        sorted(placed.collect())
    }

    /// Notes what is wrong with the value at `key`.
    pub fn complain(&mut self, key: &KeyPath, found: &str, expected: &str) {
        let error = self.document.error_at(key, found, expected);
        self.errors.push(error);
    }

    /// Adds what helps to the complaints about the value at `key`.
    pub fn advise(&mut self, key: &KeyPath, advice: &str) {
        for error in self.errors.iter_mut().filter(|error| error.key == *key) {
            error.expected = format!("{}: {advice}", error.expected);
        }
    }

    /// Reads the value at `key`, a [`Kind::Dependent`] one, as the kind that is known now. Nothing happens without it.
    pub fn refine(&mut self, key: &KeyPath, kind: &Kind) -> Option<Value> {
        let place = find_mut(&mut self.document.value, key)?;
        let node = self.document.root.get(key)?;
        let mut reader = Reader {
            file: &self.document.file,
            errors: Vec::new(),
        };
        let value = reader.value(node, kind, key);
        *place = value.clone().unwrap_or_default();
        let errors = reader.errors;
        let document = &self.document;
        self.errors
            .extend(errors.into_iter().map(|e| document.placed(e)));
        value
    }

    /// What was read, unless there was a complaint.
    pub fn document(self) -> Result<Document, ConfigErrors> {
        if self.errors.is_empty() {
            Ok(self.document)
        } else {
            Err(sorted(self.errors))
        }
    }

    /// The typed settings, unless there was a complaint.
    pub fn finish<T: DeserializeOwned>(self) -> Result<Loaded<T>, ConfigErrors> {
        let document = self.document()?;
        match serde_json::from_value(document.value.clone()) {
            Ok(settings) => Ok(Loaded { settings, document }),
            // A test holds schema and types together, so this is for a schema of somebody else's.
            Err(error) => {
                let found = format!("settings that do not fit their type ({error})");
                let expected = "what the schema states";
                let error = document.error_at(&KeyPath::root(), &found, expected);
                Err(ConfigErrors(vec![error]))
            }
        }
    }
}

/// The text of a file; `expected` names what should be there, for the complaint that it is not.
pub(crate) fn load_text(path: &Path, expected: &str) -> Result<String, ConfigErrors> {
    let complain = |found: String| {
        ConfigErrors(vec![ConfigError {
            file: path.display().to_string(),
            position: None,
            key: KeyPath::root(),
            found,
            expected: expected.to_owned(),
        }])
    };
    let bytes = crate::regular_file::read_regular(path).map_err(|error| {
        complain(match error.kind() {
            std::io::ErrorKind::NotFound => "no such file".to_owned(),
            _ => format!("a file that cannot be read ({error})"),
        })
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        complain(format!("a file that is not UTF-8 at byte {at}"))
    })
}

/// In the order of their places.
pub(crate) fn sorted(mut errors: Vec<ConfigError>) -> ConfigErrors {
    errors.sort_by_key(|error| error.position);
    ConfigErrors(errors)
}

fn find_mut<'a>(value: &'a mut Value, key: &KeyPath) -> Option<&'a mut Value> {
    use crate::error::Step;
    key.steps()
        .iter()
        .try_fold(value, |value, step| match step {
            Step::Key(key) => value.get_mut(key),
            Step::Index(index) => value.get_mut(index),
        })
}
