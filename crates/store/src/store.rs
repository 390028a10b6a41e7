//! The file of the store: opening, checking, copying it.

use crate::error::StoreError;
use crate::schema::{MIGRATIONS, VERSION, VIEWS_OF_EARLIER, check, migrate, version};
use rusqlite::{Connection, OpenFlags, Transaction, TransactionBehavior};
use std::fs;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How long a change waits for another process.
const PATIENCE: Duration = Duration::from_secs(10);

/// How often opening is tried, where the database does not wait by itself in every case, the pause between, and how long each waits.
const ATTEMPTS: u32 = 50;
const PAUSE: Duration = Duration::from_millis(40);
const WAIT: Duration = Duration::from_millis(60);

/// An open store.
#[derive(Debug)]
pub struct Store {
    pub(crate) connection: Connection,
    path: PathBuf,
    is_read_only: bool,
}

impl Store {
    /// Opens the store for writing; one that is not there is made, readable by its owner alone. Tables of an earlier version are brought to
    /// this one's in one transaction, and before a copy is put beside the file.
    ///
    /// # Errors
    /// Of a later version, damaged, locked, or not to be written.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        Self::open_with(path, MIGRATIONS)
    }

    fn open_with(path: &Path, steps: &[&str]) -> Result<Self, StoreError> {
        create_empty(path)?;
        let mut attempt = 0;
        loop {
            match Self::open_once(path, steps) {
                // The change to a write-ahead log is not waited for by the database.
                Err(StoreError::Busy) if attempt < ATTEMPTS => {
                    attempt += 1;
                    std::thread::sleep(PAUSE);
                }
                Err(StoreError::CannotOpen(_)) if !can_be_written(path) => {
                    return Err(StoreError::ReadOnly);
                }
                opened => return opened,
            }
        }
    }

    fn open_once(path: &Path, steps: &[&str]) -> Result<Self, StoreError> {
        let known = steps.len() as i64;
        let mut connection = Connection::open_with_flags(path, WRITE)?;
        prepare(&connection)?;
        connection.busy_timeout(WAIT)?;
        let found = check(&connection, known)?;
        connection.pragma_update(None, "journal_mode", "WAL")?;
        // A finished run is on the disk when its transaction is.
        connection.pragma_update(None, "synchronous", "FULL")?;
        if found < known {
            if found > 0 {
                copy_of_version(&connection, path, found)?;
            }
            migrate(&mut connection, steps)?;
        }
        // What can be read can still be unwritable: known before anything is entered.
        if connection.is_readonly(rusqlite::MAIN_DB)? {
            return Err(StoreError::ReadOnly);
        }
        connection.busy_timeout(PATIENCE)?;
        let path = path.to_path_buf();
        Ok(Self {
            connection,
            path,
            is_read_only: false,
        })
    }

    /// Opens a store for reading alone; `None` if there is none. Nothing is written, so that one in a read-only folder can be read, of an
    /// earlier version as well.
    ///
    /// # Errors
    /// Of a later version, damaged or locked.
    pub fn open_to_read(path: &Path) -> Result<Option<Self>, StoreError> {
        if !path.exists() {
            return Ok(None);
        }
        let opened = Self::read_with(path, path.as_os_str().to_owned(), READ);
        match opened {
            // In a read-only folder no log can be made. Without one nobody writes, and the file is all there is.
            Err(StoreError::CannotOpen(_) | StoreError::ReadOnly) if !log_of(path).exists() => {
                Self::read_with(
                    path,
                    immutable(path).into(),
                    READ | OpenFlags::SQLITE_OPEN_URI,
                )
            }
            opened => opened,
        }
    }

    fn read_with(
        path: &Path,
        name: std::ffi::OsString,
        flags: OpenFlags,
    ) -> Result<Option<Self>, StoreError> {
        let connection = Connection::open_with_flags(name, flags)?;
        prepare(&connection)?;
        let found = check(&connection, VERSION)?;
        if found == 0 {
            // Its maker was killed before it had tables.
            return Ok(None);
        }
        if found < VERSION {
            let views = usize::try_from(found - 1).ok();
            let views = views.and_then(|index| VIEWS_OF_EARLIER.get(index));
            let views = views
                .ok_or_else(|| StoreError::Damaged(format!("its tables are of version {found}")))?;
            connection.execute_batch(views)?;
        }
        let path = path.to_path_buf();
        Ok(Some(Self {
            connection,
            path,
            is_read_only: true,
        }))
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Version of its tables.
    ///
    /// # Errors
    /// Those of the database.
    pub fn version(&self) -> Result<i64, StoreError> {
        version(&self.connection)
    }

    /// What is wrong with its bytes and references, a line each; empty if nothing is.
    ///
    /// # Errors
    /// That it could not be checked: another process holds it.
    pub fn check(&self) -> Result<Vec<String>, StoreError> {
        let mut found = Vec::new();
        for (pragma, column) in [("quick_check", 0), ("foreign_key_check", 0)] {
            let mut collect = || -> rusqlite::Result<()> {
                let mut statement = self.connection.prepare(&format!("PRAGMA {pragma}"))?;
                let mut rows = statement.query([])?;
                while let Some(row) = rows.next()? {
                    let line: String = row.get(column)?;
                    match (pragma, line.as_str()) {
                        ("quick_check", "ok") => {}
                        ("quick_check", _) => found.push(line),
                        _ => found.push(format!("table {line} refers to what is not there")),
                    }
                }
                Ok(())
            };
            match collect().map_err(StoreError::from) {
                Ok(()) => {}
                Err(StoreError::Damaged(what)) => found.push(what),
                Err(other) => return Err(other),
            }
        }
        Ok(found)
    }

    /// Writes the file again without what was deleted, and empties the log.
    ///
    /// # Errors
    /// Those of the database.
    pub fn vacuum(&mut self) -> Result<(), StoreError> {
        self.connection.execute_batch("VACUUM")?;
        self.empty_log()
    }

    /// Puts all that is in the log into the file, and empties it: what was erased is in neither.
    pub(crate) fn empty_log(&self) -> Result<(), StoreError> {
        let emptied = self
            .connection
            .query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |row| {
                row.get::<_, i64>(0)
            })?;
        match emptied {
            0 => Ok(()),
            _ => Err(StoreError::Busy),
        }
    }

    /// Copies of earlier versions beside the file.
    pub fn copies(&self) -> Vec<PathBuf> {
        let copies = (1..VERSION).map(|version| name_of_copy(&self.path, version));
        copies.filter(|copy| copy.exists()).collect()
    }

    /// A transaction that writes.
    pub(crate) fn write(&mut self) -> Result<Transaction<'_>, StoreError> {
        if self.is_read_only {
            return Err(StoreError::ReadOnly);
        }
        let behaviour = TransactionBehavior::Immediate;
        Ok(self.connection.transaction_with_behavior(behaviour)?)
    }
}

const READ: OpenFlags = OpenFlags::SQLITE_OPEN_READ_ONLY.union(OpenFlags::SQLITE_OPEN_NO_MUTEX);
const WRITE: OpenFlags = OpenFlags::SQLITE_OPEN_READ_WRITE.union(OpenFlags::SQLITE_OPEN_NO_MUTEX);

fn prepare(connection: &Connection) -> Result<(), StoreError> {
    connection.busy_timeout(PATIENCE)?;
    connection.pragma_update(None, "foreign_keys", true)?;
    connection.pragma_update(None, "trusted_schema", false)?;
    connection.pragma_update(None, "cell_size_check", true)?;
    // What is erased is overwritten.
    connection.pragma_update(None, "secure_delete", true)?;
    Ok(())
}

/// The write-ahead log of a store.
fn log_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push("-wal");
    name.into()
}

/// The store as a file that nobody writes.
fn immutable(path: &Path) -> String {
    let path = path.to_string_lossy();
    let escaped = path.chars().map(|c| match c {
        '%' => "%25".to_owned(),
        '?' => "%3f".to_owned(),
        '#' => "%23".to_owned(),
        c => c.to_string(),
    });
    format!("file:{}?immutable=1", escaped.collect::<String>())
}

/// Makes the file and its folder, if they are not there, for their owner alone: names stand in it.
fn create_empty(path: &Path) -> Result<(), StoreError> {
    if path.exists() {
        return Ok(());
    }
    let failed = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::ReadOnlyFilesystem => StoreError::ReadOnly,
        std::io::ErrorKind::StorageFull => StoreError::Full,
        _ => StoreError::CannotOpen(format!("{}: {error}", path.display())),
    };
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        let made = fs::DirBuilder::new()
            .recursive(true)
            .mode(0o700)
            .create(folder);
        made.map_err(failed)?;
    }
    let mut options = fs::OpenOptions::new();
    match options.write(true).create_new(true).mode(0o600).open(path) {
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => Ok(()),
        made => made.map(drop).map_err(failed),
    }
}

/// Whether the system lets this user write the file.
fn can_be_written(path: &Path) -> bool {
    fs::OpenOptions::new().append(true).open(path).is_ok()
}

fn name_of_copy(path: &Path, version: i64) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".version-{version}"));
    name.into()
}

/// Puts a copy beside the file; one that is there already is of the same version, and stays.
fn copy_of_version(connection: &Connection, path: &Path, version: i64) -> Result<(), StoreError> {
    let copy = name_of_copy(path, version);
    if copy.exists() {
        return Ok(());
    }
    let name = copy.to_string_lossy();
    connection.execute("VACUUM INTO ?1", [name.as_ref()])?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Filter;

    const STEPS: [&str; 2] = [
        "CREATE TABLE a (x INTEGER) STRICT; INSERT INTO a VALUES (7);",
        "ALTER TABLE a ADD COLUMN y TEXT; UPDATE a SET y = 'seven' WHERE x = 7;",
    ];

    fn seven(store: &Store) -> String {
        let read = store
            .connection
            .query_row("SELECT y FROM a", [], |row| row.get(0));
        read.expect("a row")
    }

    /// A store of version 1 has the column of version 2 after it was opened, its row has moved along, and the copy is the old one.
    #[test]
    fn an_earlier_version_is_migrated_beside_a_copy() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        drop(Store::open_with(&path, &STEPS[..1]).expect("version 1"));
        let store = Store::open_with(&path, &STEPS).expect("version 2");
        assert_eq!((store.version(), seven(&store)), (Ok(2), "seven".into()));
        let copy = Connection::open(name_of_copy(&path, 1)).expect("the copy");
        assert_eq!(version(&copy), Ok(1));
        let columns = copy
            .prepare("SELECT * FROM a")
            .expect("a table")
            .column_count();
        assert_eq!(columns, 1);
    }

    /// A file of version 1 can be read, and salvaged, without a change of it.
    #[test]
    fn an_earlier_version_can_be_read_as_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        let first = Store::open_with(&path, &MIGRATIONS[..1]).expect("version 1");
        let insert = "INSERT INTO session (id, path, module, level, started, simulated, finished, seed, input, version, realtime,
                verdict, counts, failed, duration, targets_done, targets)
            VALUES ('00000000000000000000000000000001', 'p', 'm', 1, 20, 1, 1, '1', 'i', 'v', 0, 'passed', 1, '', 3, 1, 1)";
        first.connection.execute(insert, []).expect("a row");
        drop(first);
        let store = Store::open_to_read(&path)
            .expect("readable")
            .expect("there");
        let found = store.results(&Filter::default(), true).expect("results");
        assert_eq!(
            (found.len(), found[0].session.started_subsec_ns),
            (1, 0),
            "{found:?}"
        );
        let (document, losses) = store.export();
        assert_eq!((document.sessions.len(), losses), (1, Vec::new()));
        assert_eq!(store.version(), Ok(1));
    }

    /// A step that fails leaves the earlier version as it was.
    #[test]
    fn a_migration_that_fails_changes_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        drop(Store::open_with(&path, &STEPS[..1]).expect("version 1"));
        let wrong = [
            STEPS[0],
            "ALTER TABLE a ADD COLUMN y TEXT; INSERT INTO nothing VALUES (1);",
        ];
        assert!(Store::open_with(&path, &wrong).is_err());
        let store = Store::open_with(&path, &STEPS[..1]).expect("version 1");
        let columns = store
            .connection
            .prepare("SELECT * FROM a")
            .expect("a table")
            .column_count();
        assert_eq!((store.version(), columns), (Ok(1), 1));
    }

    #[test]
    fn a_later_version_is_refused_with_both_numbers() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        drop(Store::open_with(&path, &STEPS).expect("version 2"));
        let error = Store::open_with(&path, &STEPS[..1])
            .map(drop)
            .expect_err("too new");
        assert_eq!(error, StoreError::Newer { found: 2, known: 1 });
        assert!(error.to_string().contains("version 2") && error.to_string().contains("up to 1"));
    }

    /// A full disk, here a file that may not grow: the change is refused as a whole, and what was there stays.
    #[test]
    fn a_full_disk_is_named_and_costs_nothing_that_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        let steps = ["CREATE TABLE a (x TEXT) STRICT; INSERT INTO a VALUES ('first');"];
        let mut store = Store::open_with(&path, &steps).expect("a store");
        let pages: i64 = store
            .connection
            .query_row("PRAGMA page_count", [], |row| row.get(0))
            .expect("a number");
        store
            .connection
            .pragma_update(None, "max_page_count", pages + 1)
            .expect("set");
        let transaction = store.write().expect("a transaction");
        let long = "x".repeat(100_000);
        let error = transaction
            .execute("INSERT INTO a VALUES (?1)", [long])
            .expect_err("full");
        assert_eq!(StoreError::from(error), StoreError::Full);
        drop(transaction);
        drop(store);
        let store = Store::open_with(&path, &steps).expect("a store");
        let rows: i64 = store
            .connection
            .query_row("SELECT count(*) FROM a", [], |row| row.get(0))
            .expect("a number");
        assert_eq!((rows, store.check()), (1, Ok(Vec::new())));
    }

    /// A process that holds the store is waited for, and then named.
    #[test]
    fn a_locked_store_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        let mut store = Store::open(&path).expect("a store");
        let other = Store::open(&path).expect("a store");
        other
            .connection
            .execute_batch("BEGIN IMMEDIATE")
            .expect("a lock");
        store.connection.busy_timeout(WAIT).expect("set");
        assert_eq!(store.write().map(drop), Err(StoreError::Busy));
        other.connection.execute_batch("COMMIT").expect("released");
        assert_eq!(store.write().map(drop), Ok(()));
    }

    #[test]
    fn the_file_is_for_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a/store.sqlite");
        let _store = Store::open(&path).expect("a store");
        for (file, mode) in [
            (path.clone(), 0o600),
            (log_of(&path), 0o600),
            (folder.path().join("a"), 0o700),
        ] {
            let found = fs::metadata(&file).expect("a file").permissions().mode() & 0o777;
            assert_eq!(found, mode, "{}", file.display());
        }
    }

    #[test]
    fn a_database_of_another_program_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("store.sqlite");
        let other = Connection::open(&path).expect("a database");
        other
            .execute_batch("CREATE TABLE theirs (x)")
            .expect("a table");
        drop(other);
        let before = fs::read(&path).expect("a file");
        let error = Store::open(&path).map(drop).expect_err("not ours");
        assert!(matches!(error, StoreError::CannotOpen(_)), "{error}");
        assert_eq!(fs::read(&path).expect("a file"), before);
    }
}
