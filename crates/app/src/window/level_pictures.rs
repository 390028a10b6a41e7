//! Pictures of levels: `pictures/level<N>.png` beside the manifest of a module.

use super::AtThisPlace;
use microsim_settings::{ModuleFolder, read_regular};
use microsim_window::{LevelPictures, PictureFile};
use std::io::ErrorKind;
use std::path::Path;

impl LevelPictures for AtThisPlace {
    fn picture(&self, module: &str, level: u32) -> Result<Option<PictureFile>, String> {
        let module: &ModuleFolder = self
            .installation
            .module(module)
            .map_err(|e| e.to_string())?;
        read(&module.manifest.document.path(), level)
    }
}

/// The picture of a level, by the manifest of its module.
fn read(manifest: &Path, level: u32) -> Result<Option<PictureFile>, String> {
    let path = manifest.with_file_name("pictures");
    let path = path.join(format!("level{level}.png"));
    match read_regular(&path) {
        Ok(bytes) => Ok(Some(PictureFile { path, bytes })),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(format!("{} cannot be read: {error}", path.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_found_beside_the_manifest_and_one_that_cannot_be_read_is_named() {
        let module = tempfile::tempdir().expect("a folder");
        let manifest = module.path().join("module.toml");
        assert_eq!(read(&manifest, 1), Ok(None));
        let folder = module.path().join("pictures");
        std::fs::create_dir_all(folder.join("level2.png")).expect("folders");
        std::fs::write(folder.join("level1.png"), "a picture").expect("a file");
        let found = read(&manifest, 1).expect("read").expect("it is there");
        assert_eq!(found.bytes, b"a picture");
        assert_eq!(found.path, folder.join("level1.png"));
        let why = read(&manifest, 2).expect_err("a folder");
        let place = folder.join("level2.png").display().to_string();
        assert!(
            why.starts_with(&place) && why.contains("cannot be read"),
            "{why}"
        );
        assert_eq!(read(&manifest, 3), Ok(None));
    }
}
