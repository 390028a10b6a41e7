//! What is wrong with a file, where, and what would be right.

use std::fmt;

/// A place in a text file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

/// A path from the top of a file to a value, printed as `limit[0].max`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeyPath(Vec<Step>);

/// One step of a [`KeyPath`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Key(String),
    Index(usize),
}

impl KeyPath {
    /// The file as a whole.
    pub fn root() -> Self {
        Self::default()
    }

    /// The value of `key` in this table.
    pub fn key(&self, key: &str) -> Self {
        self.and(Step::Key(key.to_owned()))
    }

    /// The element `index` (from 0) of this list.
    pub fn at(&self, index: usize) -> Self {
        self.and(Step::Index(index))
    }

    pub(crate) fn steps(&self) -> &[Step] {
        &self.0
    }

    fn and(&self, step: Step) -> Self {
        let mut steps = self.0.clone();
        steps.push(step);
        Self(steps)
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.0.iter().enumerate() {
            let dot = if i == 0 { "" } else { "." };
            match step {
                Step::Index(index) => write!(f, "[{index}]")?,
                Step::Key(key) if is_bare(key) => write!(f, "{dot}{key}")?,
                Step::Key(key) => write!(f, "{dot}{key:?}")?,
            }
        }
        Ok(())
    }
}

/// Whether TOML lets this key stand without quotes.
fn is_bare(key: &str) -> bool {
    !key.is_empty()
        && key
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}

/// One complaint about one file.
///
/// Printed as ``FILE:LINE:COLUMN: key `a.b`: found …, expected …``; the parts that do not apply are left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The file as it was named when it was read.
    pub file: String,
    /// Where in the file; `None` if the file as a whole is meant.
    pub position: Option<Position>,
    /// Which value; the root if the file as a whole is meant.
    pub key: KeyPath,
    /// What stands there.
    pub found: String,
    /// What should stand there.
    pub expected: String,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(Position { line, column }) = self.position {
            write!(f, ":{line}:{column}")?;
        }
        if self.key != KeyPath::root() {
            write!(f, ": key `{}`", self.key)?;
        }
        write!(f, ": found {}, expected {}", self.found, self.expected)
    }
}

impl std::error::Error for ConfigError {}

/// Complaints that are printed; a file of another kind altogether has one in each of its lines.
const PRINTED: usize = 20;

/// All complaints about what was read, in the order of their places; never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigErrors(pub Vec<ConfigError>);

impl fmt::Display for ConfigErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, error) in self.0.iter().take(PRINTED).enumerate() {
            let line_break = if i == 0 { "" } else { "\n" };
            write!(f, "{line_break}{error}")?;
        }
        match self.0.len().saturating_sub(PRINTED) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

impl std::error::Error for ConfigErrors {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_file_place_key_found_and_expected() {
        let mut error = ConfigError {
            file: "config/host.toml".into(),
            position: Some(Position { line: 3, column: 7 }),
            key: KeyPath::root().key("queue").key("a.b").at(0).key("c"),
            found: "4".into(),
            expected: "a list".into(),
        };
        let whole = "config/host.toml:3:7: key `queue.\"a.b\"[0].c`: found 4, expected a list";
        assert_eq!(error.to_string(), whole);
        error.position = None;
        error.key = KeyPath::root();
        assert_eq!(
            error.to_string(),
            "config/host.toml: found 4, expected a list"
        );
    }
}
