//! What goes when a trainee asks for it, and the record of it, which holds neither id nor name.

use crate::error::{StoreError, refuse};
use crate::id::Id;
use crate::store::Store;
use crate::trainee;
use rusqlite::params;
use serde::{Deserialize, Serialize};

/// That somebody was erased or made anonymous.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Erasure {
    /// When: wall clock, seconds since 1970.
    pub time: i64,
    /// `erased` or `anonymised`.
    pub what: String,
    /// Sessions that went, or that were made anonymous.
    pub sessions: i64,
    /// Files that went.
    pub files: i64,
}

impl Store {
    /// Removes all rows of a trainee; their files are the caller's. The rows are overwritten in file and log.
    ///
    /// # Errors
    /// A trainee who is not there, and those of the database.
    pub fn erase(&mut self, id: Id, now: i64, files: i64) -> Result<(), StoreError> {
        let transaction = self.write()?;
        let Some(key) = trainee::key(&transaction, id)? else {
            return refuse(format!("no trainee of the id {id}"));
        };
        // Runs that were killed before they were entered.
        transaction.execute(
            "DELETE FROM pending WHERE path IN (SELECT path FROM session WHERE trainee = ?1)",
            [key],
        )?;
        let sessions = transaction.execute("DELETE FROM session WHERE trainee = ?1", [key])?;
        transaction.execute("DELETE FROM trainee WHERE key = ?1", [key])?;
        transaction.execute(
            "INSERT INTO erasure (time, what, sessions, files) VALUES (?1, 'erased', ?2, ?3)",
            params![now, sessions as i64, files],
        )?;
        transaction.commit()?;
        self.empty_log()
    }

    /// Removes the name of a trainee; id and sessions stay. The name is overwritten in file and log.
    ///
    /// # Errors
    /// A trainee who is not there, and those of the database.
    pub fn anonymise(&mut self, id: Id, now: i64) -> Result<(), StoreError> {
        let transaction = self.write()?;
        let Some(key) = trainee::key(&transaction, id)? else {
            return refuse(format!("no trainee of the id {id}"));
        };
        transaction.execute("UPDATE trainee SET name = NULL WHERE key = ?1", [key])?;
        transaction.execute(
            "INSERT INTO erasure (time, what, sessions, files)
            SELECT ?2, 'anonymised', count(*), 0 FROM session WHERE trainee = ?1",
            [key, now],
        )?;
        transaction.commit()?;
        self.empty_log()
    }

    /// What was erased and when.
    ///
    /// # Errors
    /// Those of the database.
    pub fn erasures(&self) -> Result<Vec<Erasure>, StoreError> {
        let mut statement = self
            .connection
            .prepare("SELECT time, what, sessions, files FROM erasure ORDER BY key")?;
        let rows = statement.query_map([], |row| {
            Ok(Erasure {
                time: row.get(0)?,
                what: row.get(1)?,
                sessions: row.get(2)?,
                files: row.get(3)?,
            })
        })?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }
}
