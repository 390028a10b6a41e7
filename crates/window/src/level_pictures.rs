//! What the list of levels needs of a station: pictures of what is trained.

use std::path::PathBuf;

/// A picture as it lies in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureFile {
    /// The file, for complaints.
    pub path: PathBuf,
    /// What is in it; PNG is expected.
    pub bytes: Vec<u8>,
}

/// A station with pictures of its levels.
pub trait LevelPictures {
    /// The picture of a level of a module, by its number from 1; `None` where the module brings none.
    ///
    /// # Errors
    /// Why the file cannot be read.
    fn picture(&self, module: &str, level: u32) -> Result<Option<PictureFile>, String>;
}
