//! What a file may hold: keys with their kind, unit, range, default and meaning, as data.
//!
//! One engine serves our own files and the keys that a training module declares in its manifest. From the same tree
//! come the reader ([`crate::Document::read`]), the JSON Schema and the reference table.

use microsim_vocabulary::Unit;
use serde_json::Value;

/// A kind of file.
#[derive(Clone, Debug, PartialEq)]
pub struct Schema {
    /// Its name on the command line, for example `level`.
    pub name: String,
    /// What such a file holds, in a sentence.
    pub doc: String,
    /// The keys at its top.
    pub keys: Vec<Key>,
}

/// One key of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// As it is written in the file.
    pub name: String,
    /// What its value may be.
    pub kind: Kind,
    /// What it means, in a sentence.
    pub doc: String,
    /// What happens without it.
    pub presence: Presence,
}

/// What happens if a key is not there.
#[derive(Clone, Debug, PartialEq)]
pub enum Presence {
    /// That is an error.
    Required,
    /// It stays away.
    Optional,
    /// This value, in SI, takes its place. A table is filled with the defaults of its own keys instead.
    Default(Value),
}

/// How a name is spelt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Lower-case words joined by hyphens: `touch-spheres`.
    Identifier,
    /// Lower-case words joined by underscores: a key, or a library's base name.
    Symbol,
    /// A file by its plain name, with an ending.
    FileName,
    /// A message kind: two or more identifiers joined by dots.
    Message,
    /// Three numbers joined by dots.
    Version,
    /// A path below the file's own folder, with `/`, without `..`.
    RelativePath,
}

/// What a value may be. Bounds are inclusive and in SI; an infinite one is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A text that is not empty.
    Text,
    /// A name of this form, at most 64 characters (a path: 255).
    Name(Form),
    /// `true` or `false`.
    Bool,
    /// A whole number.
    Integer {
        /// Smallest value.
        min: i64,
        /// Largest value.
        max: i64,
    },
    /// A number in SI or a text with a unit; read as `f64` in SI.
    Quantity {
        /// Its dimension.
        unit: Unit,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// A list of `len` quantities.
    Vector {
        /// Dimension of each component.
        unit: Unit,
        /// Number of components.
        len: usize,
        /// Smallest value of a component.
        min: f64,
        /// Largest value of a component.
        max: f64,
    },
    /// A rotation `[x, y, z, w]`, of length 1 within 0.001; read with length 1.
    Quaternion,
    /// Three numbers, not all zero; read with length 1.
    Direction,
    /// One of these texts.
    Choice(Vec<String>),
    /// One of these texts, or a value of the other kind.
    ChoiceOr(Vec<String>, Box<Kind>),
    /// `#rrggbb`, sRGB.
    Colour,
    /// A table with `de` and `en`.
    LocalText,
    /// A table with `en`, and `de` where there is a German text: without it the English one stands for both.
    EnglishText,
    /// A table with these keys.
    Table(Vec<Key>),
    /// A list, or an array of tables.
    List {
        /// Kind of each element.
        of: Box<Kind>,
        /// Smallest number of elements.
        min: usize,
        /// Largest number of elements.
        max: usize,
    },
    /// A table whose keys are free, with values of one kind.
    Map {
        /// Form of each key.
        keys: Form,
        /// Kind of each value.
        of: Box<Kind>,
    },
    /// A number, text, truth value or list of these, whose kind another part of the files decides; the text names it.
    Dependent(String),
}

impl Kind {
    /// A quantity of this unit from `min` to `max`, in SI.
    pub fn quantity(unit: Unit, min: f64, max: f64) -> Self {
        Kind::Quantity { unit, min, max }
    }

    /// One of these texts.
    pub fn choice(values: &[&str]) -> Self {
        Kind::Choice(values.iter().map(ToString::to_string).collect())
    }

    /// A list of at most `max` elements that may be empty.
    pub fn list(of: Kind, max: usize) -> Self {
        Kind::List {
            of: Box::new(of),
            min: 0,
            max,
        }
    }

    /// What should stand there, in words that fit after "expected".
    pub fn expected(&self) -> String {
        match self {
            Kind::Text => "a text that is not empty".to_owned(),
            Kind::Name(form) => form.expected().to_owned(),
            Kind::Bool => "true or false".to_owned(),
            Kind::Integer { min, max } => format!("a whole number from {min} to {max}"),
            Kind::Quantity { unit, min, max } => {
                format!("{}{}", range(*unit, *min, *max), notation(*unit))
            }
            Kind::Vector {
                unit,
                len,
                min,
                max,
            } => format!(
                "a list of {len}, each {}{}",
                range(*unit, *min, *max),
                notation(*unit)
            ),
            Kind::Quaternion => "a rotation [x, y, z, w] of length 1".to_owned(),
            Kind::Direction => "a direction [x, y, z] that is not zero".to_owned(),
            Kind::Choice(values) => one_of(values),
            Kind::ChoiceOr(values, kind) => format!("{}, or {}", one_of(values), kind.expected()),
            Kind::Colour => "a colour such as \"#c04030\"".to_owned(),
            Kind::LocalText => "a table with the texts `de` and `en`".to_owned(),
            Kind::EnglishText => "a table with the text `en`, and `de` if there is one".to_owned(),
            Kind::Table(_) => "a table".to_owned(),
            Kind::List { of, min, max } if min == max => {
                format!("a list of {max}, each {}", of.expected())
            }
            Kind::List { of, min, max } => {
                format!("a list of {min} to {max}, each {}", of.expected())
            }
            Kind::Map { of, .. } => format!("a table whose values are {}", of.expected()),
            Kind::Dependent(which) => which.clone(),
        }
    }
}

impl Form {
    /// What should stand there, in words that fit after "expected".
    fn expected(self) -> &'static str {
        match self {
            Form::Identifier => "a name of lower-case letters, digits and single hyphens",
            Form::Symbol => "a name of lower-case letters, digits and single underscores",
            Form::FileName => {
                "the name of a file in lower-case letters, digits, hyphens and underscores, with its ending"
            }
            Form::Message => "a message kind such as `object.set`",
            Form::Version => "a version such as 0.1.0",
            Form::RelativePath => "a path below this folder, with `/` and without `..`",
        }
    }

    /// Whether `text` is such a name.
    pub fn accepts(self, text: &str) -> bool {
        let words = |text: &str, joint: char| {
            text.starts_with(|c: char| c.is_ascii_lowercase())
                && text.split(joint).all(|word| {
                    !word.is_empty()
                        && word
                            .chars()
                            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
                })
        };
        match self {
            Form::Identifier => text.len() <= 64 && words(text, '-'),
            Form::Symbol => text.len() <= 64 && words(text, '_'),
            Form::FileName => {
                let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit();
                let stem = |c: char| is_plain(c) || c == '-' || c == '_';
                text.len() <= 64
                    && text.starts_with(is_plain)
                    && text.split_once('.').is_some_and(|(name, ending)| {
                        name.chars().all(stem) && !ending.is_empty() && ending.chars().all(is_plain)
                    })
            }
            Form::Message => {
                text.len() <= 64 && text.contains('.') && text.split('.').all(|w| words(w, '-'))
            }
            Form::Version => {
                let number = |n: &str| n.parse::<u32>().is_ok_and(|v| v.to_string() == n);
                text.split('.').count() == 3 && text.split('.').all(number)
            }
            Form::RelativePath => {
                let plain = |part: &str| !matches!(part, "" | "." | "..");
                text.len() <= 255 && !text.contains(['\\', ':', '\0']) && text.split('/').all(plain)
            }
        }
    }
}

impl Key {
    /// A key that must be there.
    pub fn required(name: &str, kind: Kind, doc: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            doc: doc.to_owned(),
            presence: Presence::Required,
        }
    }
}

/// "a length from 1 um to 1 m"; just "a length" without bounds.
pub(crate) fn range(unit: Unit, min: f64, max: f64) -> String {
    let (noun, from, to) = (unit.noun(), unit.describe(min), unit.describe(max));
    match (min.is_finite(), max.is_finite()) {
        (true, true) => format!("{noun} from {from} to {to}"),
        (true, false) => format!("{noun} of at least {from}"),
        (false, true) => format!("{noun} of at most {to}"),
        (false, false) => noun.to_owned(),
    }
}

/// How a quantity may be written, if there is more than one notation.
fn notation(unit: Unit) -> String {
    match unit {
        Unit::Ratio | Unit::Count => String::new(),
        unit => {
            let symbols: Vec<&str> = unit.symbols().collect();
            let symbols = enumerate(&symbols, "or");
            format!(" (a number in {}, or a text in {symbols})", unit.symbol())
        }
    }
}

fn one_of(values: &[String]) -> String {
    let quoted: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    let quoted: Vec<&str> = quoted.iter().map(String::as_str).collect();
    enumerate(&quoted, "or")
}

/// "a, b or c"
pub(crate) fn enumerate(words: &[&str], last: &str) -> String {
    match words {
        [] => "nothing".to_owned(),
        [word] => word.to_string(),
        [first @ .., word] => format!("{} {last} {word}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_spelt_in_one_way() {
        let cases = [
            (Form::Identifier, "touch-spheres", true),
            (Form::Identifier, "level2", true),
            (Form::Identifier, "", false),
            (Form::Identifier, "2nd", false),
            (Form::Identifier, "-a", false),
            (Form::Identifier, "a--b", false),
            (Form::Identifier, "Touch", false),
            (Form::Identifier, "größe", false),
            (Form::Symbol, "angle_tolerance", true),
            (Form::Symbol, "angle-tolerance", false),
            (Form::FileName, "mat_2.glb", true),
            (Form::FileName, "mat", false),
            (Form::FileName, "../mat.glb", false),
            (Form::FileName, "Mat.glb", false),
            (Form::FileName, ".glb", false),
            (Form::FileName, "a.b.glb", false),
            (Form::Message, "tool.states", true),
            (Form::Message, "touch-spheres.hit", true),
            (Form::Message, "hit", false),
            (Form::Message, "a..b", false),
            (Form::Version, "0.1.0", true),
            (Form::Version, "0.1", false),
            (Form::Version, "0.1.0-x", false),
            (Form::Version, "01.0.0", false),
            (Form::RelativePath, "data/limits.csv", true),
            (Form::RelativePath, "../limits.csv", false),
            (Form::RelativePath, "/etc/passwd", false),
            (Form::RelativePath, "C:/x", false),
            (Form::RelativePath, "a\\b", false),
        ];
        for (form, text, accepted) in cases {
            assert_eq!(form.accepts(text), accepted, "{form:?} {text}");
        }
        assert!(!Form::Identifier.accepts(&"a".repeat(65)));
    }
}
