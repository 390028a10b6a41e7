//! Reading what must be a file: a pipe or a device could be endless, or never give a byte.

use std::io::{Error, ErrorKind};
use std::path::Path;

/// The bytes of a regular file, or of what a link to one names.
pub fn read_regular(path: &Path) -> Result<Vec<u8>, Error> {
    let kind = std::fs::metadata(path)?.file_type();
    if !kind.is_file() {
        let what = match kind.is_dir() {
            true => "it is a folder",
            false => "it is a pipe or device, not a file",
        };
        return Err(Error::new(ErrorKind::InvalidInput, what));
    }
    std::fs::read(path)
}

#[cfg(test)]
mod tests {
    use super::read_regular;
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
}
