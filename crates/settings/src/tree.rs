//! A TOML text as a tree of values that know where they stand. Knows the syntax of TOML, nothing of keys or units.

use crate::error::{ConfigError, KeyPath, Position, Step};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value with its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub at: Position,
    pub item: Item,
}

/// What TOML can hold.
#[derive(Clone, Debug)]
pub(crate) enum Item {
    Text(String),
    Integer(i64),
    Float(f64),
    Bool(bool),
    Date(String),
    List(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key of a table with its value; both places are known.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub key: String,
    pub at: Position,
    pub node: Node,
}

impl Node {
    /// Reads a TOML text; the errors are those of its syntax, all that the parser finds.
    pub fn parse(text: &str, file: &str) -> Result<Node, Vec<ConfigError>> {
        let lines = Lines::new(text);
        let (table, errors) = DeTable::parse_recoverable(text);
        let mut errors: Vec<ConfigError> = errors
            .iter()
            .map(|error| ConfigError {
                file: file.to_owned(),
                position: error.span().map(|span| lines.position(span.start)),
                key: KeyPath::root(),
                found: format!("a mistake in the TOML syntax ({})", error.message()),
                expected: "valid TOML".to_owned() + &decimal_point(text, error.span()),
            })
            .collect();
        let top = Position { line: 1, column: 1 };
        let mut builder = Builder {
            lines,
            file,
            errors: Vec::new(),
        };
        let item = builder.table(table.get_ref(), &KeyPath::root());
        errors.append(&mut builder.errors);
        if errors.is_empty() {
            Ok(Node { at: top, item })
        } else {
            Err(errors)
        }
    }

    /// The value at `path`, if there is one.
    pub fn get(&self, path: &KeyPath) -> Option<&Node> {
        let (node, steps) = self.follow(path);
        (steps == path.steps().len()).then_some(node)
    }

    /// The place of the value at `path`, or of the nearest table or list around it that exists.
    pub fn position(&self, path: &KeyPath) -> Position {
        self.follow(path).0.at
    }

    /// The last value along `path`, and how many steps lead to it.
    fn follow(&self, path: &KeyPath) -> (&Node, usize) {
        let mut node = self;
        for (taken, step) in path.steps().iter().enumerate() {
            let next = match (step, &node.item) {
                (Step::Key(key), Item::Table(entries)) => {
                    entries.iter().find(|e| e.key == *key).map(|e| &e.node)
                }
                (Step::Index(index), Item::List(nodes)) => nodes.get(*index),
                _ => None,
            };
            match next {
                Some(next) => node = next,
                None => return (node, taken),
            }
        }
        (node, path.steps().len())
    }

    /// The value of a key of this table.
    pub fn item_of(&self, key: &str) -> Option<&Node> {
        let Item::Table(entries) = &self.item else {
            return None;
        };
        let entry = entries.iter().find(|entry| entry.key == key);
        entry.map(|entry| &entry.node)
    }

    /// The same, to be changed.
    pub fn item_mut(&mut self, key: &str) -> Option<&mut Item> {
        let Item::Table(entries) = &mut self.item else {
            return None;
        };
        let entry = entries.iter_mut().find(|entry| entry.key == key);
        entry.map(|entry| &mut entry.node.item)
    }

    /// The whole number of a key of this table.
    pub fn integer(&self, key: &str) -> Option<i64> {
        match self.item_of(key)?.item {
            Item::Integer(number) => Some(number),
            _ => None,
        }
    }

    /// Gives a key of this table a value that is from `at`, if it has none.
    pub fn set_default(&mut self, key: &str, item: Item, at: Position) {
        if self.item_of(key).is_some() {
            return;
        }
        if let Item::Table(entries) = &mut self.item {
            entries.push(Entry {
                key: key.to_owned(),
                at,
                node: Node { at, item },
            });
        }
    }

    /// What this is, in words that fit after "found".
    pub fn describe(&self) -> String {
        match &self.item {
            Item::Text(text) => format!("the text `{}`", shorten(text)),
            Item::Integer(number) => format!("`{number}`"),
            Item::Float(number) if number.is_nan() => "`nan`".to_owned(),
            Item::Float(number) => format!("`{number:?}`"),
            Item::Bool(truth) => format!("`{truth}`"),
            Item::Date(date) => format!("the date `{date}`"),
            Item::List(nodes) => format!("a list of {}", nodes.len()),
            Item::Table(_) => "a table".to_owned(),
        }
    }
}

/// What helps where a number was written with a comma, as in German: the parser stops at it, behind a digit.
fn decimal_point(text: &str, error: Option<std::ops::Range<usize>>) -> String {
    let number = error.and_then(|span| {
        let (before, after) = text.split_at_checked(span.start)?;
        let digits = |text: &str| text.chars().take_while(char::is_ascii_digit).count();
        let after = after.strip_prefix(',')?;
        let end = digits(after);
        let is_of_number = |c: char| c.is_ascii_digit() || "+-.".contains(c);
        let start = before.trim_end_matches(is_of_number).len();
        let whole = before[start..].replace('.', "");
        (end > 0 && whole.ends_with(|c: char| c.is_ascii_digit()))
            .then(|| format!("{whole}.{}", &after[..end]))
    });
    number.map_or_else(String::new, |number| {
        format!(": a decimal sign is a point, as in {number}")
    })
}

/// At most 40 characters of a text on one line, for messages.
fn shorten(text: &str) -> String {
    let line: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    match text.chars().nth(40) {
        Some(_) => format!("{line}…"),
        None => line,
    }
}

/// Where the lines of a text begin.
struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let starts = std::iter::once(0).chain(breaks.map(|(at, _)| at + 1));
        Self {
            text,
            starts: starts.collect(),
        }
    }

    /// The place of a byte; one past the end is allowed.
    fn position(&self, byte: usize) -> Position {
        let byte = byte.min(self.text.len());
        let line = self.starts.partition_point(|start| *start <= byte);
        let start = self.starts[line - 1];
        // Bytes that continue a character do not count.
        let column = self.text.as_bytes()[start..byte]
            .iter()
            .filter(|b| **b & 0xC0 != 0x80)
            .count()
            + 1;
        Position { line, column }
    }
}

/// Turns the parser's tree into ours, collecting numbers that do not fit.
struct Builder<'a> {
    lines: Lines<'a>,
    file: &'a str,
    errors: Vec<ConfigError>,
}

impl Builder<'_> {
    fn table(&mut self, table: &DeTable<'_>, path: &KeyPath) -> Item {
        let entries = table.iter().map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            at: self.lines.position(key.span().start),
            node: self.node(value, &path.key(key.get_ref())),
        });
        Item::Table(entries.collect())
    }

    fn node(&mut self, value: &Spanned<DeValue<'_>>, path: &KeyPath) -> Node {
        let at = self.lines.position(value.span().start);
        let item = match value.get_ref() {
            DeValue::String(text) => Item::Text(text.to_string()),
            DeValue::Integer(number) => {
                match i64::from_str_radix(number.as_str(), number.radix()) {
                    Ok(number) => Item::Integer(number),
                    Err(_) => self.unfit(at, path, number.to_string(), "an integer of 64 bits"),
                }
            }
            DeValue::Float(number) => match number.as_str().parse::<f64>() {
                // A number that is only too large reads as infinite; one written `inf` is left to the schema.
                Ok(value) if !value.is_infinite() || number.as_str().contains("inf") => {
                    Item::Float(value)
                }
                _ => self.unfit(at, path, number.to_string(), "a number below 1.8e308"),
            },
            DeValue::Boolean(truth) => Item::Bool(*truth),
            DeValue::Datetime(date) => Item::Date(date.to_string()),
            DeValue::Array(list) => Item::List(
                list.iter()
                    .enumerate()
                    .map(|(i, value)| self.node(value, &path.at(i)))
                    .collect(),
            ),
            DeValue::Table(table) => self.table(table, path),
        };
        Node { at, item }
    }

    fn unfit(&mut self, at: Position, path: &KeyPath, number: String, expected: &str) -> Item {
        self.errors.push(ConfigError {
            file: self.file.to_owned(),
            position: Some(at),
            key: path.clone(),
            found: format!("`{number}`"),
            expected: expected.to_owned(),
        });
        Item::Integer(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_knows_its_line_and_column() {
        let text = "a = 1\nb = [2,\n  \"µ\", ==]\n";
        let errors = Node::parse(text, "f").expect_err("two equal signs");
        let place = errors[0].position.map(|p| (p.line, p.column));
        assert_eq!(place, Some((3, 8)));

        let text = "\"µ\" = {a = 1}\n[b]\n[[b.c]]\n  k = [ 1, 2]\n";
        let node = Node::parse(text, "f").expect("valid");
        let place = |path: &KeyPath| {
            let at = node.position(path);
            (at.line, at.column)
        };
        let root = KeyPath::root();
        assert_eq!(place(&root), (1, 1));
        assert_eq!(place(&root.key("µ").key("a")), (1, 12));
        let list = root.key("b").key("c").at(0).key("k");
        assert_eq!(place(&list), (4, 7));
        assert_eq!(place(&list.at(1)), (4, 12));
        // What is missing is shown at the table that should hold it.
        assert_eq!(place(&root.key("b").key("z")), (2, 1));
    }

    #[test]
    fn numbers_that_do_not_fit_are_named() {
        let text = "a = 99999999999999999999\nb = 1e999\nc = 0xff\n";
        let errors = Node::parse(text, "f").expect_err("too large");
        let printed: Vec<String> = errors.iter().map(ToString::to_string).collect();
        assert_eq!(
            printed,
            [
                "f:1:5: key `a`: found `99999999999999999999`, expected an integer of 64 bits",
                "f:2:5: key `b`: found `1e999`, expected a number below 1.8e308",
            ]
        );
    }
}
