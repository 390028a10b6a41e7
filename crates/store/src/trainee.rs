//! Trainees: an id that sessions hold, and a name that stands here alone.

use crate::error::{StoreError, refuse};
use crate::id::Id;
use crate::near::near;
use crate::store::Store;
use microsim_vocabulary::terms;
use rusqlite::{Connection, OptionalExtension, Row, params};

terms! {
    /// What somebody does here. A label for lists: without passwords it protects nothing, and whoever can write the store may do all of it.
    pub enum Role {
        /// Runs the station.
        Operator = "operator",
        /// Teaches.
        Instructor = "instructor",
        /// Trains.
        Trainee = "trainee",
    }
}

/// A trainee.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Trainee {
    /// The id that sessions hold.
    pub id: Id,
    /// The name; `None`: anonymous.
    pub name: Option<String>,
    /// What somebody does here.
    pub role: Role,
    /// When it was added: wall clock, seconds since 1970.
    pub created: i64,
}

/// A trainee in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedTrainee {
    /// The trainee.
    pub trainee: Trainee,
    /// Groups, sorted.
    pub groups: Vec<String>,
    /// Sessions.
    pub sessions: i64,
    /// Start of the last one, seconds since 1970.
    pub last: Option<i64>,
}

/// What was found for a name or id.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// The trainee.
    One(Trainee),
    /// Nobody; the names that are near it, the nearest first.
    Nobody(Vec<String>),
}

impl Found {
    /// The trainee, or a sentence with the names that are near.
    ///
    /// # Errors
    /// [`StoreError::Refused`] if there is none.
    pub fn or_refuse(self, asked: &str) -> Result<Trainee, StoreError> {
        match self {
            Self::One(trainee) => Ok(trainee),
            Self::Nobody(names) => {
                let near = match names.is_empty() {
                    true => String::new(),
                    false => {
                        let quoted: Vec<String> =
                            names.iter().map(|name| format!("\"{name}\"")).collect();
                        format!("; near it: {}", quoted.join(", "))
                    }
                };
                refuse(format!("no trainee \"{asked}\"{near}"))
            }
        }
    }
}

const COLUMNS: &str = "id, name, role, created";

fn read(row: &Row<'_>) -> rusqlite::Result<Trainee> {
    let role: String = row.get(2)?;
    Ok(Trainee {
        id: row.get(0)?,
        name: row.get(1)?,
        // The table has a check.
        role: Role::from_name(&role).unwrap_or(Role::Trainee),
        created: row.get(3)?,
    })
}

/// Refuses a name that cannot be used: an empty one, or one that reads as an id.
fn check_name(name: &str) -> Result<(), StoreError> {
    if name.trim().is_empty() {
        return refuse("a name of blanks cannot be found again; give another");
    }
    match Id::parse(name) {
        Some(_) => refuse("a name of 32 hexadecimal digits would be taken for an id; give another"),
        None => Ok(()),
    }
}

/// Key of the row of a trainee.
pub(crate) fn key(connection: &Connection, id: Id) -> Result<Option<i64>, StoreError> {
    let mut statement = connection.prepare_cached("SELECT key FROM trainee WHERE id = ?1")?;
    Ok(statement.query_row([id], |row| row.get(0)).optional()?)
}

/// Key of the row of a trainee; a row without a name if there was none.
pub(crate) fn key_or_new(connection: &Connection, id: Id, now: i64) -> Result<i64, StoreError> {
    if let Some(key) = key(connection, id)? {
        return Ok(key);
    }
    connection.execute(
        "INSERT INTO trainee (id, name, role, created) VALUES (?1, NULL, 'trainee', ?2)",
        params![id, now],
    )?;
    Ok(connection.last_insert_rowid())
}

/// Whether somebody has this name.
pub(crate) fn is_taken(connection: &Connection, name: &str) -> Result<bool, StoreError> {
    let mut statement = connection.prepare_cached("SELECT 1 FROM trainee WHERE name = ?1")?;
    Ok(statement.exists([name])?)
}

impl Store {
    /// Adds a trainee.
    ///
    /// # Errors
    /// A name or id that is there already, and those of the database.
    pub fn add_trainee(&mut self, trainee: &Trainee) -> Result<(), StoreError> {
        if let Some(name) = &trainee.name {
            check_name(name)?;
        }
        let transaction = self.write()?;
        if let Some(name) = &trainee.name
            && is_taken(&transaction, name)?
        {
            return refuse(format!(
                "there is a trainee \"{name}\" already; add what distinguishes the two, such as a year"
            ));
        }
        if key(&transaction, trainee.id)?.is_some() {
            return refuse(format!(
                "there is a trainee of the id {} already",
                trainee.id
            ));
        }
        transaction.execute(
            "INSERT INTO trainee (id, name, role, created) VALUES (?1, ?2, ?3, ?4)",
            params![
                trainee.id,
                trainee.name,
                trainee.role.name(),
                trainee.created
            ],
        )?;
        Ok(transaction.commit()?)
    }

    /// Gives a trainee another name.
    ///
    /// # Errors
    /// A name that is there already, and those of the database.
    pub fn rename(&mut self, id: Id, name: &str) -> Result<(), StoreError> {
        check_name(name)?;
        let transaction = self.write()?;
        if is_taken(&transaction, name)? {
            return refuse(format!("there is a trainee \"{name}\" already"));
        }
        transaction.execute(
            "UPDATE trainee SET name = ?2 WHERE id = ?1",
            params![id, name],
        )?;
        Ok(transaction.commit()?)
    }

    /// Gives a trainee another role.
    ///
    /// # Errors
    /// Those of the database.
    pub fn set_role(&mut self, id: Id, role: Role) -> Result<(), StoreError> {
        let transaction = self.write()?;
        transaction.execute(
            "UPDATE trainee SET role = ?2 WHERE id = ?1",
            params![id, role.name()],
        )?;
        Ok(transaction.commit()?)
    }

    /// The trainee of an id.
    ///
    /// # Errors
    /// Those of the database.
    pub fn trainee(&self, id: Id) -> Result<Option<Trainee>, StoreError> {
        let sql = format!("SELECT {COLUMNS} FROM trainee WHERE id = ?1");
        let mut statement = self.connection.prepare_cached(&sql)?;
        Ok(statement.query_row([id], read).optional()?)
    }

    /// The trainee of a name or an id, or the names that are near.
    ///
    /// # Errors
    /// Those of the database.
    pub fn find_trainee(&self, asked: &str) -> Result<Found, StoreError> {
        if let Some(id) = Id::parse(asked)
            && let Some(trainee) = self.trainee(id)?
        {
            return Ok(Found::One(trainee));
        }
        let sql = format!("SELECT {COLUMNS} FROM trainee WHERE name = ?1");
        let mut statement = self.connection.prepare(&sql)?;
        if let Some(trainee) = statement.query_row([asked], read).optional()? {
            return Ok(Found::One(trainee));
        }
        let mut statement = self
            .connection
            .prepare("SELECT name FROM trainee WHERE name IS NOT NULL ORDER BY name")?;
        let names = statement.query_map([], |row| row.get(0))?;
        let names = names.collect::<rusqlite::Result<Vec<String>>>()?;
        Ok(Found::Nobody(near(asked, &names)))
    }

    /// All trainees, by name, those without one last; of a group, if one is named.
    ///
    /// # Errors
    /// Those of the database.
    pub fn trainees(&self, group: Option<&str>) -> Result<Vec<ListedTrainee>, StoreError> {
        let mut statement = self.connection.prepare(
            "SELECT id, name, role, created,
                (SELECT group_concat(name, char(10)) FROM (SELECT name FROM trainee_group JOIN membership
                    ON trainee_group = trainee_group.key WHERE membership.trainee = t.key ORDER BY name)),
                (SELECT count(*) FROM session WHERE trainee = t.key),
                (SELECT max(started) FROM session WHERE trainee = t.key)
            FROM trainee AS t
            WHERE ?1 IS NULL OR key IN (SELECT membership.trainee FROM membership JOIN trainee_group
                ON membership.trainee_group = trainee_group.key WHERE trainee_group.name = ?1)
            ORDER BY name IS NULL, name, id",
        )?;
        let rows = statement.query_map([group], |row| {
            let groups: Option<String> = row.get(4)?;
            Ok(ListedTrainee {
                trainee: read(row)?,
                groups: groups
                    .map_or_else(Vec::new, |g| g.split('\n').map(str::to_owned).collect()),
                sessions: row.get(5)?,
                last: row.get(6)?,
            })
        })?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }
}
