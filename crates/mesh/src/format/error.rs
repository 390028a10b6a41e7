//! Why a file cannot be read.

/// Where in a file something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text file, the first is 1.
    Line(usize),
    /// A byte of a binary file, the first is 0.
    Byte(usize),
    /// An array of a VTK file.
    Array(String),
}

/// A file that cannot be read: where, what stands there, what should.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// The file among several (`.node`, `.ele`); empty where there is only one.
    pub file: &'static str,
    /// Where.
    pub place: Place,
    /// What stands there.
    pub found: String,
    /// What should.
    pub expected: String,
}

impl FormatError {
    /// An error in the only file.
    pub(super) fn new(place: Place, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self {
            file: "",
            place,
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// The same error in the file named `file`.
    pub(super) fn in_file(self, file: &'static str) -> Self {
        Self { file, ..self }
    }
}

impl std::fmt::Display for FormatError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let file = if self.file.is_empty() {
            String::new()
        } else {
            format!("{} file, ", self.file)
        };
        match &self.place {
            Place::File if self.file.is_empty() => write!(f, "mesh file: ")?,
            Place::File => write!(f, "{} file: ", self.file)?,
            Place::Line(line) => write!(f, "{file}line {line}: ")?,
            Place::Byte(byte) => write!(f, "{file}byte {byte}: ")?,
            Place::Array(name) => write!(f, "{file}array \"{name}\": ")?,
        }
        write!(f, "found {}; expected {}", self.found, self.expected)
    }
}

impl std::error::Error for FormatError {}
