//! Groups of trainees.

use crate::error::{StoreError, refuse};
use crate::id::Id;
use crate::store::Store;
use crate::trainee;
use rusqlite::{Connection, OptionalExtension, params};

/// Key of the row of a group.
pub(crate) fn key(connection: &Connection, name: &str) -> Result<Option<i64>, StoreError> {
    let mut statement =
        connection.prepare_cached("SELECT key FROM trainee_group WHERE name = ?1")?;
    Ok(statement.query_row([name], |row| row.get(0)).optional()?)
}

/// Key of the row of a group, which is made if there is none.
pub(crate) fn key_or_new(connection: &Connection, name: &str) -> Result<i64, StoreError> {
    if name.trim().is_empty() || name.contains('\n') {
        return refuse("the name of a group is a line of text");
    }
    connection.execute(
        "INSERT OR IGNORE INTO trainee_group (name) VALUES (?1)",
        [name],
    )?;
    key(connection, name)?.ok_or_else(|| StoreError::Other("a group is gone again".into()))
}

/// Key of the row of a group, or a sentence with the groups that there are.
pub(crate) fn must_be(connection: &Connection, name: &str) -> Result<i64, StoreError> {
    if let Some(key) = key(connection, name)? {
        return Ok(key);
    }
    let names = names(connection)?;
    let known = match names.is_empty() {
        true => "there is none yet".to_owned(),
        false => format!("there are: {}", names.join(", ")),
    };
    refuse(format!("no group \"{name}\"; {known}"))
}

fn names(connection: &Connection) -> Result<Vec<String>, StoreError> {
    let mut statement = connection.prepare("SELECT name FROM trainee_group ORDER BY name")?;
    let names = statement.query_map([], |row| row.get(0))?;
    Ok(names.collect::<rusqlite::Result<_>>()?)
}

impl Store {
    /// Names of all groups, sorted.
    ///
    /// # Errors
    /// Those of the database.
    pub fn groups(&self) -> Result<Vec<String>, StoreError> {
        names(&self.connection)
    }

    /// An error with the known ones unless there is such a group.
    ///
    /// # Errors
    /// [`StoreError::Refused`] if there is none, and those of the database.
    pub fn must_be_group(&self, name: &str) -> Result<(), StoreError> {
        must_be(&self.connection, name).map(drop)
    }

    /// Puts trainees into a group, which is made if there is none, and takes others out; a group without members is gone, unless it is
    /// enrolled in a course.
    ///
    /// # Errors
    /// Those of the database.
    pub fn change_group(
        &mut self,
        name: &str,
        add: &[Id],
        remove: &[Id],
    ) -> Result<(), StoreError> {
        let transaction = self.write()?;
        let group = match add.is_empty() {
            true => must_be(&transaction, name)?,
            false => key_or_new(&transaction, name)?,
        };
        for (ids, sql) in [
            (
                add,
                "INSERT OR IGNORE INTO membership (trainee_group, trainee) VALUES (?1, ?2)",
            ),
            (
                remove,
                "DELETE FROM membership WHERE trainee_group = ?1 AND trainee = ?2",
            ),
        ] {
            for id in ids {
                let Some(trainee) = trainee::key(&transaction, *id)? else {
                    return refuse(format!("no trainee of the id {id}"));
                };
                transaction.execute(sql, params![group, trainee])?;
            }
        }
        transaction.execute(
            "DELETE FROM trainee_group WHERE key = ?1
                AND NOT EXISTS (SELECT 1 FROM membership WHERE trainee_group = ?1)
                AND NOT EXISTS (SELECT 1 FROM enrolment WHERE trainee_group = ?1)",
            [group],
        )?;
        Ok(transaction.commit()?)
    }
}
