//! The key of this station, which signs the sessions that it records: a file outside of every session, that its owner alone may read.

use crate::cli::Place;
use crate::folders::Folders;
use microsim_session::{Station, StationKey};
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

/// Environment variable that names the file of the key.
const VARIABLE: &str = "MICROSIM_STATION_KEY";

/// First line of the file; behind it stand 32 random bytes as hexadecimal digits.
const FIRST_LINE: &str =
    "MicroSim station key: secret, whoever has it can sign in the name of this station";

/// Where the key lies: as the environment states, else in the data folder of the user.
pub fn path(place: &Place) -> Result<PathBuf, String> {
    match std::env::var_os(VARIABLE).filter(|value| !value.is_empty()) {
        Some(path) => Ok(path.into()),
        None => Ok(Folders::of(place)?.data.join("station.key")),
    }
}

/// This station, if it has a key.
pub fn this(place: &Place) -> Result<Option<Station>, String> {
    Ok(read(&path(place)?)?.map(|key| key.station()))
}

/// The key of this station, made at its first use.
pub fn key(place: &Place) -> Result<StationKey, String> {
    let path = path(place)?;
    if let Some(key) = read(&path)? {
        return Ok(key);
    }
    make(&path).map_err(|e| format!("its key {} cannot be written: {e}", path.display()))?;
    let made = read(&path)?;
    made.ok_or_else(|| format!("its key {} is gone again", path.display()))
}

/// Writes a new key beside its place and links it there, so that of two processes at the same time one key remains, whole.
fn make(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    fs::DirBuilder::new()
        .recursive(true)
        .mode(0o700)
        .create(folder)?;
    let mut seed = [0; 32];
    getrandom::fill(&mut seed).map_err(std::io::Error::other)?;
    let digits: String = seed.iter().map(|byte| format!("{byte:02x}")).collect();
    let new = folder.join(format!(".station.key.{}", std::process::id()));
    let mut options = OpenOptions::new();
    let file = options.write(true).create_new(true).mode(0o600).open(&new);
    let written = file.and_then(|mut file| {
        file.write_all(format!("{FIRST_LINE}\n{digits}\n").as_bytes())?;
        file.sync_all()
    });
    let linked = written.and_then(|()| fs::hard_link(&new, path));
    let removed = fs::remove_file(&new);
    match linked {
        Err(error) if error.kind() == ErrorKind::AlreadyExists && path.exists() => removed,
        linked => linked.and(removed),
    }
}

/// The key in a file; `None` if there is no file.
fn read(path: &Path) -> Result<Option<StationKey>, String> {
    let shown = path.display();
    let mode = match fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(format!("its key {shown} cannot be read: {error}")),
        Ok(metadata) => metadata.permissions().mode() & 0o777,
    };
    if mode & 0o077 != 0 {
        return Err(format!(
            "its key {shown} can be read or written by others (mode {mode:o}): it proves nothing. If nobody has used that, `chmod 600 {shown}`; else delete it, and a new one is made"
        ));
    }
    let text =
        fs::read_to_string(path).map_err(|e| format!("its key {shown} cannot be read: {e}"))?;
    let seed = seed(&text).ok_or_else(|| {
        format!("its key {shown} is damaged: expected the line \"{FIRST_LINE}\" and 64 hexadecimal digits")
    })?;
    Ok(Some(StationKey::from_seed(&seed)))
}

fn seed(text: &str) -> Option<[u8; 32]> {
    let digits = text
        .strip_prefix(FIRST_LINE)?
        .strip_prefix('\n')?
        .strip_suffix('\n')?;
    if digits.len() != 64 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let mut seed = [0; 32];
    for (index, byte) in seed.iter_mut().enumerate() {
        *byte = u8::from_str_radix(&digits[2 * index..2 * index + 2], 16).ok()?;
    }
    Some(seed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_made_once_and_for_its_owner_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a/b/station.key");
        assert!(read(&path).expect("no file").is_none());
        make(&path).expect("made");
        let first = read(&path).expect("a key").expect("a key").station();
        make(&path).expect("left as it is");
        assert_eq!(read(&path).expect("a key").expect("a key").station(), first);
        let mode = |path: &Path| fs::metadata(path).expect("there").permissions().mode() & 0o777;
        assert_eq!(
            (mode(&path), mode(&folder.path().join("a/b"))),
            (0o600, 0o700)
        );
        assert_eq!(
            fs::read_dir(folder.path().join("a/b"))
                .expect("a folder")
                .count(),
            1
        );
        let other = folder.path().join("other.key");
        make(&other).expect("made");
        assert_ne!(
            read(&other).expect("a key").expect("a key").station(),
            first
        );
    }

    #[test]
    fn a_key_that_others_can_read_or_that_is_damaged_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("station.key");
        make(&path).expect("made");
        let text = fs::read_to_string(&path).expect("a key");
        for cut in 0..text.len() {
            fs::write(&path, &text[..cut]).expect("written");
            assert!(
                read(&path).expect_err("cut").contains("is damaged"),
                "{cut}"
            );
        }
        fs::write(&path, &text).expect("written");
        for mode in [0o640, 0o604, 0o620] {
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).expect("set");
            let refused = read(&path).expect_err("readable by others");
            assert!(refused.contains(&format!("(mode {mode:o})")), "{refused}");
        }
    }
}
