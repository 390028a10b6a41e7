//! Files of models and textures that the objects of a level name: found, read and looked through, so that a broken one is refused before a run.

use crate::request::AssembleError;
use microsim_message::SetupFile;
use microsim_model::{self as model, ModelError};
use microsim_settings::{self as settings, KeyPath, Level, Loaded};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The folder of a module, and of an installation, in which such files lie.
pub const ASSETS: &str = "assets";

/// What the objects of a level need from files.
#[derive(Debug, Default)]
pub struct Assets {
    /// Where each file lies.
    pub paths: Vec<PathBuf>,
    /// Each file under the name by which the level has it; one that a model names is `MODEL/NAME`.
    pub files: Vec<SetupFile>,
}

impl Assets {
    /// Reads what a level names, from the first of these folders that has it.
    ///
    /// # Errors
    /// The key of the level that names a file which is not there or broken, with the reason.
    pub fn read(folders: &[PathBuf], level: &Loaded<Level>) -> Result<Self, AssembleError> {
        let mut assets = Self::default();
        for (key, name) in level.settings.object_files() {
            if assets.files.iter().any(|file| file.name == name) {
                continue;
            }
            assets.add(folders, &name).map_err(|found| {
                let expected = "a model in glTF, OBJ or STL, or a texture in PNG";
                let error = level.document.error_at(&key, &found, expected);
                AssembleError(error.to_string())
            })?;
        }
        assets.check_textures(level)?;
        Ok(assets)
    }

    /// Looks through one file, with those that it names.
    ///
    /// # Errors
    /// What was found.
    pub fn check(path: &Path) -> Result<(), String> {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self::default().add(&[folder], &name)
    }

    /// Adds a file, and those that it names; the error is what was found.
    fn add(&mut self, folders: &[PathBuf], name: &str) -> Result<(), String> {
        let found = folders.iter().find(|folder| folder.join(name).exists());
        let Some(folder) = found else {
            let folders: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
            return Err(format!(
                "`{name}`, which is not in {}",
                folders.join(" or in ")
            ));
        };
        let path = folder.join(name);
        let bytes = read(&path)?;
        let broken = |error: ModelError| format!("`{}`: {error}", path.display());
        if is_texture(name) {
            model::read_texture(&bytes).map_err(broken)?;
        } else {
            let mut beside: Vec<(String, PathBuf, Vec<u8>)> = Vec::new();
            for reference in model::references(name, &bytes).map_err(broken)? {
                let path = folder.join(&reference);
                let bytes = read(&path)?;
                beside.push((reference, path, bytes));
            }
            let file = |wanted: &str| {
                let found = beside.iter().find(|(name, _, _)| name == wanted);
                found.map(|(_, _, bytes)| &bytes[..])
            };
            model::read(name, &bytes, &file).map_err(broken)?;
            for (reference, path, bytes) in beside {
                self.paths.push(path);
                self.files.push(SetupFile {
                    name: format!("{name}/{reference}"),
                    bytes,
                });
            }
        }
        self.paths.push(path);
        self.files.push(SetupFile {
            name: name.to_owned(),
            bytes,
        });
        Ok(())
    }

    /// A texture has to be a picture, and its model to have texture coordinates.
    fn check_textures(&self, level: &Loaded<Level>) -> Result<(), AssembleError> {
        for (index, object) in level.settings.object.iter().enumerate() {
            let files = object.files();
            for (key, name) in &files {
                let at = KeyPath::root().key("object").at(index).key(key);
                let refuse = |found: &str, expected: &str| {
                    let error = level.document.error_at(&at, found, expected);
                    Err(AssembleError(error.to_string()))
                };
                match (*key, is_texture(name)) {
                    ("model", true) => return refuse("a picture", "a model in glTF, OBJ or STL"),
                    ("texture", false) => return refuse("a model", "a picture in PNG"),
                    ("texture", true) if !self.has_coordinates(files[0].1) => {
                        let found = format!(
                            "a texture for `{}`, which has no texture coordinates",
                            files[0].1
                        );
                        return refuse(&found, "none, or a model that has them");
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    fn has_coordinates(&self, name: &str) -> bool {
        let parsed = self
            .files
            .iter()
            .find(|file| file.name == name)
            .map(|file| {
                model::read(name, &file.bytes, &|reference| {
                    let whole = format!("{name}/{reference}");
                    let found = self.files.iter().find(|file| file.name == whole);
                    found.map(|file| &file.bytes[..])
                })
            });
        let Some(Ok(parsed)) = parsed else {
            return false;
        };
        parsed.parts.iter().any(|part| !part.coordinates.is_empty())
    }

    /// Digests of the files, hexadecimal, by their names.
    pub fn digests(&self) -> BTreeMap<String, String> {
        let digest = |file: &SetupFile| blake3::hash(&file.bytes).to_hex().to_string();
        let digests = self
            .files
            .iter()
            .map(|file| (file.name.clone(), digest(file)));
        digests.collect()
    }
}

fn is_texture(name: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|ending| ending == "png")
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    let size = std::fs::metadata(path).map_or(0, |file| file.len());
    if size > model::MAX_BYTES as u64 {
        return Err(format!(
            "`{}` of {size} bytes; at most {} are read",
            path.display(),
            model::MAX_BYTES
        ));
    }
    settings::read_regular(path)
        .map_err(|e| format!("`{}`, which cannot be read ({e})", path.display()))
}
