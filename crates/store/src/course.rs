//! Courses: levels in order, who takes them, and how far they are.

use crate::error::{StoreError, refuse};
use crate::group;
use crate::id::Id;
use crate::store::Store;
use crate::trainee;
use microsim_training::{mastered_with, passes_in_a_row};
use rusqlite::{Connection, OptionalExtension, params};
use serde::{Deserialize, Serialize};

/// A course.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Course {
    /// Its name.
    pub name: String,
    /// What people call it, in English.
    pub title_en: String,
    /// The same in German.
    pub title_de: String,
    /// Whether a level opens when the one before it is mastered; otherwise all are open.
    pub in_order: bool,
    /// Its levels in their order.
    pub steps: Vec<Step>,
}

/// A level of a course.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Step {
    /// Module.
    pub module: String,
    /// Level.
    pub level: u32,
    /// Passes in a row after which it is mastered.
    pub passes: u32,
}

/// Who takes a course.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Enrolled {
    /// A trainee.
    Trainee(Id),
    /// All members of a group.
    Group(String),
}

/// How far a trainee is with a level of a course.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepProgress {
    /// The level.
    pub step: Step,
    /// Results that count.
    pub attempts: usize,
    /// Passes among them.
    pub passed: usize,
    /// Passes in a row at the end.
    pub row: usize,
    /// Which attempt mastered it, from 1.
    pub mastered_with: Option<usize>,
    /// Whether it may be trained.
    pub open: bool,
    /// Whether it was opened by hand.
    pub unlocked: bool,
}

/// How far a trainee is with a course.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The course.
    pub course: Course,
    /// Its levels.
    pub steps: Vec<StepProgress>,
}

impl Progress {
    /// The first level that is open and not mastered.
    pub fn next(&self) -> Option<&StepProgress> {
        let mut steps = self.steps.iter();
        steps.find(|step| step.open && step.mastered_with.is_none())
    }
}

fn key(connection: &Connection, name: &str) -> Result<i64, StoreError> {
    let mut statement = connection.prepare("SELECT key FROM course WHERE name = ?1")?;
    if let Some(key) = statement.query_row([name], |row| row.get(0)).optional()? {
        return Ok(key);
    }
    let mut statement = connection.prepare("SELECT name FROM course ORDER BY name")?;
    let names = statement.query_map([], |row| row.get(0))?;
    let names = names.collect::<rusqlite::Result<Vec<String>>>()?;
    let known = match names.is_empty() {
        true => "there is none yet; `microsim courses add FILE.toml` adds one".to_owned(),
        false => format!("there are: {}", names.join(", ")),
    };
    refuse(format!("no course \"{name}\"; {known}"))
}

/// Puts a course in the place of one of the same name; who takes it stays.
pub(crate) fn put(connection: &Connection, course: &Course) -> Result<i64, StoreError> {
    let key: i64 = connection.query_row(
        "INSERT INTO course (name, title_en, title_de, in_order) VALUES (?1, ?2, ?3, ?4)
        ON CONFLICT (name) DO UPDATE SET title_en = ?2, title_de = ?3, in_order = ?4 RETURNING key",
        params![
            course.name,
            course.title_en,
            course.title_de,
            course.in_order
        ],
        |row| row.get(0),
    )?;
    connection.execute("DELETE FROM course_step WHERE course = ?1", [key])?;
    for (position, step) in course.steps.iter().enumerate() {
        connection.execute(
            "INSERT INTO course_step VALUES (?1, ?2, ?3, ?4, ?5)",
            params![key, position as i64, step.module, step.level, step.passes],
        )?;
    }
    Ok(key)
}

/// Enrols in the course of a key.
pub(crate) fn enrol(
    connection: &Connection,
    course: i64,
    who: &Enrolled,
) -> Result<(), StoreError> {
    match who {
        Enrolled::Trainee(id) => {
            let Some(trainee) = trainee::key(connection, *id)? else {
                return refuse(format!("no trainee of the id {id}"));
            };
            connection.execute(
                "INSERT OR IGNORE INTO enrolment (course, trainee) VALUES (?1, ?2)",
                [course, trainee],
            )?;
        }
        Enrolled::Group(name) => {
            let group = group::must_be(connection, name)?;
            connection.execute(
                "INSERT OR IGNORE INTO enrolment (course, trainee_group) VALUES (?1, ?2)",
                [course, group],
            )?;
        }
    }
    Ok(())
}

/// Opens a level of the course of a key for a trainee.
pub(crate) fn unlock(
    connection: &Connection,
    course: i64,
    id: Id,
    module: &str,
    level: u32,
) -> Result<(), StoreError> {
    let Some(trainee) = trainee::key(connection, id)? else {
        return refuse(format!("no trainee of the id {id}"));
    };
    connection.execute(
        "INSERT OR IGNORE INTO unlocked VALUES (?1, ?2, ?3, ?4)",
        params![course, trainee, module, level],
    )?;
    Ok(())
}

impl Store {
    /// Puts a course in the place of one of the same name; who takes it, and what was unlocked, stays.
    ///
    /// # Errors
    /// Those of the database.
    pub fn put_course(&mut self, course: &Course) -> Result<(), StoreError> {
        let transaction = self.write()?;
        put(&transaction, course)?;
        Ok(transaction.commit()?)
    }

    /// Removes a course; results stay.
    ///
    /// # Errors
    /// A course that is not there, and those of the database.
    pub fn remove_course(&mut self, name: &str) -> Result<(), StoreError> {
        let transaction = self.write()?;
        let key = key(&transaction, name)?;
        transaction.execute("DELETE FROM course WHERE key = ?1", [key])?;
        Ok(transaction.commit()?)
    }

    /// All courses, by name.
    ///
    /// # Errors
    /// Those of the database.
    pub fn courses(&self) -> Result<Vec<Course>, StoreError> {
        let mut statement = self
            .connection
            .prepare("SELECT key, name, title_en, title_de, in_order FROM course ORDER BY name")?;
        let mut steps = self.connection.prepare(
            "SELECT module, level, passes FROM course_step WHERE course = ?1 ORDER BY position",
        )?;
        let rows = statement.query_map([], |row| {
            let key: i64 = row.get(0)?;
            let steps = steps.query_map([key], |row| {
                Ok(Step {
                    module: row.get(0)?,
                    level: row.get(1)?,
                    passes: row.get(2)?,
                })
            })?;
            Ok(Course {
                name: row.get(1)?,
                title_en: row.get(2)?,
                title_de: row.get(3)?,
                in_order: row.get(4)?,
                steps: steps.collect::<rusqlite::Result<_>>()?,
            })
        })?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }

    /// A course.
    ///
    /// # Errors
    /// A course that is not there, and those of the database.
    pub fn course(&self, name: &str) -> Result<Course, StoreError> {
        key(&self.connection, name)?;
        let courses = self.courses()?;
        let found = courses.into_iter().find(|course| course.name == name);
        found.ok_or_else(|| StoreError::Other(format!("the course \"{name}\" is gone again")))
    }

    /// Enrols a trainee or a group.
    ///
    /// # Errors
    /// A course, trainee or group that is not there, and those of the database.
    pub fn enrol(&mut self, course: &str, who: &Enrolled) -> Result<(), StoreError> {
        let transaction = self.write()?;
        let course = key(&transaction, course)?;
        enrol(&transaction, course, who)?;
        Ok(transaction.commit()?)
    }

    /// Takes a trainee or a group out of a course.
    ///
    /// # Errors
    /// A course that is not there, and those of the database.
    pub fn leave(&mut self, course: &str, who: &Enrolled) -> Result<(), StoreError> {
        let transaction = self.write()?;
        let course = key(&transaction, course)?;
        let (sql, value) = match who {
            Enrolled::Trainee(id) => (
                "DELETE FROM enrolment WHERE course = ?1 AND trainee = (SELECT key FROM trainee WHERE id = ?2)",
                id.to_string(),
            ),
            Enrolled::Group(name) => (
                "DELETE FROM enrolment WHERE course = ?1 AND trainee_group = (SELECT key FROM trainee_group WHERE name = ?2)",
                name.clone(),
            ),
        };
        transaction.execute(sql, params![course, value])?;
        Ok(transaction.commit()?)
    }

    /// Opens a level of a course for a trainee, whatever is mastered.
    ///
    /// # Errors
    /// A course or level that is not there, and those of the database.
    pub fn unlock(
        &mut self,
        course: &str,
        id: Id,
        module: &str,
        level: u32,
    ) -> Result<(), StoreError> {
        let transaction = self.write()?;
        let key = key(&transaction, course)?;
        let sql = "SELECT 1 FROM course_step WHERE course = ?1 AND module = ?2 AND level = ?3";
        let has = transaction
            .prepare(sql)?
            .exists(params![key, module, level])?;
        if !has {
            return refuse(format!(
                "the course \"{course}\" has no level {level} of {module}"
            ));
        }
        unlock(&transaction, key, id, module, level)?;
        Ok(transaction.commit()?)
    }

    /// The groups that take a course, and the trainees who take it themselves.
    ///
    /// # Errors
    /// A course that is not there, and those of the database.
    pub fn enrolled(&self, course: &str) -> Result<Vec<Enrolled>, StoreError> {
        let course = key(&self.connection, course)?;
        let mut statement = self.connection.prepare(
            "SELECT trainee.id, trainee_group.name FROM enrolment LEFT JOIN trainee ON trainee.key = enrolment.trainee
                LEFT JOIN trainee_group ON trainee_group.key = enrolment.trainee_group
            WHERE course = ?1 ORDER BY trainee_group.name, trainee.name, trainee.id",
        )?;
        let rows = statement.query_map([course], |row| {
            let id: Option<Id> = row.get(0)?;
            Ok(match id {
                Some(id) => Enrolled::Trainee(id),
                None => Enrolled::Group(row.get(1)?),
            })
        })?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }

    /// All who take a course, by themselves or as members, by name.
    ///
    /// # Errors
    /// A course that is not there, and those of the database.
    pub fn participants(&self, course: &str) -> Result<Vec<Id>, StoreError> {
        let course = key(&self.connection, course)?;
        let mut statement = self.connection.prepare(
            "SELECT id FROM trainee WHERE key IN (SELECT trainee FROM enrolment WHERE course = ?1 AND trainee IS NOT NULL)
                OR key IN (SELECT membership.trainee FROM membership JOIN enrolment
                    ON enrolment.trainee_group = membership.trainee_group WHERE course = ?1)
            ORDER BY name IS NULL, name, id",
        )?;
        let rows = statement.query_map([course], |row| row.get(0))?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }

    /// Names of the courses that a trainee takes.
    ///
    /// # Errors
    /// Those of the database.
    pub fn courses_of(&self, id: Id) -> Result<Vec<String>, StoreError> {
        let mut statement = self.connection.prepare(
            "SELECT name FROM course WHERE key IN (
                SELECT course FROM enrolment JOIN trainee ON enrolment.trainee = trainee.key WHERE trainee.id = ?1
                UNION SELECT course FROM enrolment JOIN membership ON enrolment.trainee_group = membership.trainee_group
                    JOIN trainee ON trainee.key = membership.trainee WHERE trainee.id = ?1)
            ORDER BY name",
        )?;
        let rows = statement.query_map([id], |row| row.get(0))?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }

    /// How far a trainee is with a course. What counts are results that count, of people, in the order of time: an aborted run is none, and
    /// so neither continues nor ends a row of passes.
    ///
    /// # Errors
    /// A course that is not there, and those of the database.
    pub fn progress(&self, course: &str, id: Id) -> Result<Progress, StoreError> {
        let course_key = key(&self.connection, course)?;
        let course = self.course(course)?;
        let mut attempts = self.connection.prepare(
            "SELECT verdict = 'passed' FROM session JOIN trainee ON session.trainee = trainee.key
            WHERE trainee.id = ?1 AND module = ?2 AND level = ?3 AND counts AND synthetic IS NULL
            ORDER BY session.started, session.started_subsec_ns, session.id",
        )?;
        let mut unlocked = self.connection.prepare(
            "SELECT 1 FROM unlocked JOIN trainee ON unlocked.trainee = trainee.key
            WHERE course = ?1 AND trainee.id = ?2 AND module = ?3 AND level = ?4",
        )?;
        let mut steps: Vec<StepProgress> = Vec::new();
        for step in &course.steps {
            let rows =
                attempts.query_map(params![id, step.module, step.level], |row| row.get(0))?;
            let passes = rows.collect::<rusqlite::Result<Vec<bool>>>()?;
            let by_hand = unlocked.exists(params![course_key, id, step.module, step.level])?;
            let before = steps
                .last()
                .is_none_or(|before| before.mastered_with.is_some());
            steps.push(StepProgress {
                step: step.clone(),
                attempts: passes.len(),
                passed: passes.iter().filter(|passed| **passed).count(),
                row: passes_in_a_row(&passes),
                mastered_with: mastered_with(passes.iter().copied(), step.passes).map(|at| at + 1),
                open: !course.in_order || before || by_hand,
                unlocked: by_hand,
            });
        }
        Ok(Progress { course, steps })
    }
}
