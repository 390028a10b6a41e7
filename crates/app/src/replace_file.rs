//! Replacing a file: what was there before stays until all of the new one is on the disk.

use crate::output::Problem;
use microsim_settings::unwritable;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// An error if nothing can be written at `path`, found before there is anything to write. What is there stays as it is.
pub fn must_be_writable(path: &Path) -> Result<(), Problem> {
    if is_special(path) {
        return Ok(());
    }
    let is_new = !path.exists();
    let opened = fs::OpenOptions::new().append(true).create(true).open(path);
    opened.map_err(|e| unwritable(path, e))?;
    if is_new {
        fs::remove_file(path).map_err(|e| unwritable(path, e))?;
    }
    Ok(())
}

/// A device or pipe that is named on purpose, such as /dev/stdout: it is written to, not replaced.
fn is_special(path: &Path) -> bool {
    let special = |kind: fs::FileType| !kind.is_file() && !kind.is_dir();
    path.starts_with("/dev")
        || path.starts_with("/proc")
        || fs::metadata(path).is_ok_and(|m| special(m.file_type()))
}

/// Writes a file that must not be there. After a failure, of a full disk for example, there is none.
pub fn write_new(path: &Path, content: &[u8]) -> Result<(), Problem> {
    let named = |e| unwritable(path, e);
    let mut file = fs::File::create_new(path).map_err(named)?;
    file.write_all(content).map_err(|e| {
        let _ = fs::remove_file(path);
        named(e)
    })?;
    Ok(())
}

/// Puts `content` in the place of what is at `path`. A link is replaced, and what it names stays as it is. After a failure, of a full
/// disk for example, the old content is still there.
pub fn replace(path: &Path, content: &[u8]) -> Result<(), Problem> {
    replace_by(path, |file| file.write_all(content))
}

/// The same with what `write` writes, which need not be in memory at once.
pub fn replace_by(
    path: &Path,
    write: impl FnOnce(&mut fs::File) -> std::io::Result<()>,
) -> Result<(), Problem> {
    let named = |e| unwritable(path, e);
    if is_special(path) {
        let opened = fs::OpenOptions::new().write(true).truncate(true).open(path);
        return Ok(opened
            .and_then(|mut file| write(&mut file))
            .map_err(named)?);
    }
    let (new, mut file) = beside(path).map_err(named)?;
    let written = write(&mut file)
        .and_then(|()| match fs::symlink_metadata(path) {
            Ok(old) if old.is_file() => file.set_permissions(old.permissions()),
            _ => Ok(()),
        })
        .and_then(|()| file.sync_all())
        .and_then(|()| fs::rename(&new, path));
    if written.is_err() {
        // It is useless, and only that it was not written counts.
        let _ = fs::remove_file(&new);
    }
    Ok(written.map_err(named)?)
}

/// A new file in the folder of `path`.
fn beside(path: &Path) -> Result<(PathBuf, fs::File), std::io::Error> {
    let name = path.file_name().ok_or(ErrorKind::InvalidInput)?;
    for attempt in 0.. {
        let mut own = std::ffi::OsString::from(".");
        own.push(name);
        own.push(format!(".{}-{attempt}.new", std::process::id()));
        let new = path.with_file_name(own);
        match fs::File::create_new(&new) {
            Ok(file) => return Ok((new, file)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(ErrorKind::AlreadyExists.into())
}

#[cfg(test)]
mod tests {
    use super::replace;
    use std::fs;

    /// A link in the place of a page does not lead out of the folder, and what was there is whole or new.
    #[cfg(unix)]
    #[test]
    fn a_link_is_replaced_and_not_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (other, page) = (folder.path().join("other"), folder.path().join("page"));
        fs::write(&other, "of another").expect("a file");
        std::os::unix::fs::symlink(&other, &page).expect("a link");
        replace(&page, b"new").unwrap_or_else(|e| panic!("{e:?}"));
        assert_eq!(fs::read(&other).expect("a file"), b"of another");
        assert_eq!(fs::read(&page).expect("a file"), b"new");
        assert!(fs::symlink_metadata(&page).is_ok_and(|m| m.is_file()));
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2);
    }

    /// What cannot be finished leaves the old file, and nothing beside it.
    #[test]
    fn a_file_that_cannot_be_replaced_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().join("page");
        fs::create_dir(&place).expect("a folder in its place");
        assert!(replace(&place, b"new").is_err());
        assert!(place.is_dir());
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }
}
