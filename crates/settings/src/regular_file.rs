//! Reading what must be a file: a pipe or a device could be endless, or never give a byte. And why a file cannot be read or
//! written, in words instead of numbers of the system.

use std::fs::File;
use std::io::{Error, ErrorKind};
use std::path::Path;

/// The bytes of a regular file, or of what a link to one names. An error states why in words.
pub fn read_regular(path: &Path) -> Result<Vec<u8>, Error> {
    refuse_others(path)
        .and_then(|()| std::fs::read(path))
        .map_err(in_words)
}

/// A regular file to read from, as [`read_regular`] has it.
pub fn open_regular(path: &Path) -> Result<File, Error> {
    refuse_others(path)
        .and_then(|()| File::open(path))
        .map_err(in_words)
}

fn refuse_others(path: &Path) -> Result<(), Error> {
    let kind = std::fs::metadata(path)?.file_type();
    match () {
        () if kind.is_file() => Ok(()),
        () if kind.is_dir() => Err(ErrorKind::IsADirectory.into()),
        () => Err(Error::new(
            ErrorKind::InvalidInput,
            "it is a pipe or device, not a file",
        )),
    }
}

/// The same error in words, where the system's own are known; its kind stays.
pub fn in_words(error: Error) -> Error {
    let words = match error.kind() {
        ErrorKind::NotFound => "there is no such file",
        ErrorKind::PermissionDenied => "this user has no permission",
        ErrorKind::AlreadyExists => "it exists already",
        ErrorKind::IsADirectory => "it is a folder",
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder",
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only",
        _ => return error,
    };
    Error::new(error.kind(), words)
}

/// Why a file or folder cannot be written or made, in words and with its path.
pub fn unwritable(path: &Path, error: Error) -> String {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let why = match error.kind() {
        ErrorKind::NotFound if !folder.exists() => {
            format!("there is no folder {}", folder.display())
        }
        ErrorKind::NotFound => format!("nothing can be made in {}", folder.display()),
        _ => in_words(error).to_string(),
    };
    format!("{} cannot be written: {why}", path.display())
}

#[cfg(test)]
mod tests {
    use super::{read_regular, unwritable};
    use std::path::Path;

    /// An endless device ends nothing: it is refused before a byte is read.
    #[test]
    fn only_files_are_read() {
        for (path, what) in [("/dev/zero", "device"), ("/", "folder")] {
            let error = read_regular(Path::new(path)).expect_err("no file");
            assert!(error.to_string().contains(what), "{error}");
        }
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        assert!(read_regular(&own).is_ok_and(|bytes| !bytes.is_empty()));
    }

    /// Whoever mistypes a name need not know the numbers of the system.
    #[test]
    fn what_is_not_there_is_told_in_words() {
        for (path, words) in [
            ("/no/such", "there is no such file"),
            ("/dev/null/x", "a part of the path is a file, not a folder"),
        ] {
            let error = read_regular(Path::new(path)).expect_err("no file");
            assert_eq!(error.to_string(), words);
        }
        let wrong = |path: &str| {
            let path = Path::new(path);
            unwritable(path, std::fs::write(path, "").expect_err("no such place"))
        };
        let no_folder = "/no/such/x cannot be written: there is no folder /no/such";
        assert_eq!(wrong("/no/such/x"), no_folder);
        #[cfg(target_os = "linux")]
        assert_eq!(
            wrong("/proc/x"),
            "/proc/x cannot be written: nothing can be made in /proc"
        );
    }
}
