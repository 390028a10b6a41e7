//! The whole store as one document: what sessions on the disk cannot give back, and what they can.

use crate::course::{self, Course, Enrolled};
use crate::erase::Erasure;
use crate::error::{StoreError, refuse};
use crate::group;
use crate::id::Id;
use crate::population::{self, PopulationRecord};
use crate::session::{self, Measured, Metric, Session};
use crate::store::Store;
use crate::trainee::{self, Trainee};
use rusqlite::params;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Version of the fields of [`Document`].
pub const DOCUMENT_FORMAT: u32 = 1;

/// Everything in the store.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// [`DOCUMENT_FORMAT`].
    pub format: u32,
    /// Trainees, by id.
    pub trainees: Vec<Trainee>,
    /// Groups, by name.
    pub groups: Vec<Group>,
    /// Courses, by name.
    pub courses: Vec<CourseEntry>,
    /// Populations.
    pub populations: Vec<PopulationRecord>,
    /// The metrics that values of sessions refer to by their place in this list.
    pub metrics: Vec<Metric>,
    /// Sessions with their results, by id.
    pub sessions: Vec<SessionEntry>,
    /// What was erased and when, without ids and names.
    pub erasures: Vec<Erasure>,
}

/// A group with its members.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Its members.
    pub members: Vec<Id>,
}

/// A course with those who take it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CourseEntry {
    /// The course.
    #[serde(flatten)]
    pub course: Course,
    /// Trainees who take it by themselves.
    pub trainees: Vec<Id>,
    /// Groups that take it.
    pub groups: Vec<String>,
    /// Levels that were opened by hand.
    pub unlocked: Vec<Unlocked>,
}

/// A level that was opened by hand.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unlocked {
    /// For whom.
    pub trainee: Id,
    /// Module.
    pub module: String,
    /// Level.
    pub level: u32,
}

/// A session with the values of its metrics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionEntry {
    /// The session, without metrics.
    #[serde(flatten)]
    pub session: Session,
    /// Files that belong to it and do not lie beside it.
    pub files: Vec<String>,
    /// Values of metrics, each by its place in [`Document::metrics`].
    pub values: Vec<Measured<usize>>,
}

/// How much an import has added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Imported {
    /// Trainees that were not there, or had no name.
    pub trainees: usize,
    /// Courses that were not there.
    pub courses: usize,
    /// Populations.
    pub populations: usize,
    /// Sessions that were not there.
    pub sessions: usize,
}

impl Document {
    /// One without anything.
    pub fn empty() -> Self {
        Self {
            format: DOCUMENT_FORMAT,
            trainees: Vec::new(),
            groups: Vec::new(),
            courses: Vec::new(),
            populations: Vec::new(),
            metrics: Vec::new(),
            sessions: Vec::new(),
            erasures: Vec::new(),
        }
    }

    /// What is of one trainee: their row, groups and courses that they are in, and their sessions.
    pub fn of_trainee(mut self, id: Id) -> Self {
        self.trainees.retain(|trainee| trainee.id == id);
        self.groups.retain(|group| group.members.contains(&id));
        for group in &mut self.groups {
            group.members = vec![id];
        }
        for entry in &mut self.courses {
            entry.trainees.retain(|trainee| *trainee == id);
            entry.unlocked.retain(|unlocked| unlocked.trainee == id);
            let groups = &self.groups;
            entry
                .groups
                .retain(|name| groups.iter().any(|group| group.name == *name));
        }
        self.courses.retain(|entry| {
            !(entry.trainees.is_empty() && entry.groups.is_empty() && entry.unlocked.is_empty())
        });
        self.sessions
            .retain(|entry| entry.session.trainee == Some(id));
        self.populations.clear();
        self.erasures.clear();
        self
    }
}

impl Store {
    /// Adds what is missing, all or nothing: trainees, members, courses, enrolments, unlocked levels, populations, sessions. What is there
    /// stays as it is; a trainee without a name gets that of the document.
    ///
    /// # Errors
    /// A document of a later format, a name that another trainee has here, and those of the database.
    pub fn import(&mut self, document: &Document) -> Result<Imported, StoreError> {
        if document.format > DOCUMENT_FORMAT {
            return refuse(format!(
                "the document has format {}, this version reads formats up to {DOCUMENT_FORMAT}",
                document.format
            ));
        }
        let mut imported = Imported::default();
        let transaction = self.write()?;
        for trainee in &document.trainees {
            let new = trainee::key(&transaction, trainee.id)?.is_none();
            let key = trainee::key_or_new(&transaction, trainee.id, trainee.created)?;
            let sql = "SELECT name IS NULL FROM trainee WHERE key = ?1";
            let nameless: bool = transaction.query_row(sql, [key], |row| row.get(0))?;
            if nameless && let Some(name) = &trainee.name {
                if trainee::is_taken(&transaction, name)? {
                    return refuse(format!(
                        "another trainee here has the name \"{name}\" already; rename one of the two"
                    ));
                }
                transaction.execute(
                    "UPDATE trainee SET name = ?2, role = ?3, created = ?4 WHERE key = ?1",
                    params![key, name, trainee.role.name(), trainee.created],
                )?;
                imported.trainees += 1;
            } else if new {
                transaction.execute(
                    "UPDATE trainee SET role = ?2 WHERE key = ?1",
                    params![key, trainee.role.name()],
                )?;
                imported.trainees += 1;
            }
        }
        for group in &document.groups {
            let key = group::key_or_new(&transaction, &group.name)?;
            for id in &group.members {
                let trainee = trainee::key_or_new(&transaction, *id, 0)?;
                transaction.execute(
                    "INSERT OR IGNORE INTO membership (trainee_group, trainee) VALUES (?1, ?2)",
                    [key, trainee],
                )?;
            }
        }
        for entry in &document.courses {
            let find = "SELECT key FROM course WHERE name = ?1";
            let mut find = transaction.prepare(find)?;
            let known = find.exists([&entry.course.name])?;
            let key = match known {
                true => find.query_row([&entry.course.name], |row| row.get(0))?,
                false => course::put(&transaction, &entry.course)?,
            };
            imported.courses += usize::from(!known);
            for id in &entry.trainees {
                course::enrol(&transaction, key, &Enrolled::Trainee(*id))?;
            }
            for name in &entry.groups {
                course::enrol(&transaction, key, &Enrolled::Group(name.clone()))?;
            }
            for unlocked in &entry.unlocked {
                let Unlocked {
                    trainee,
                    module,
                    level,
                } = unlocked;
                course::unlock(&transaction, key, *trainee, module, *level)?;
            }
        }
        for record in &document.populations {
            population::put(&transaction, record)?;
            imported.populations += 1;
        }
        let metrics: Vec<Arc<Metric>> = document.metrics.iter().cloned().map(Arc::new).collect();
        for entry in &document.sessions {
            if session::key(&transaction, entry.session.id)?.is_some() {
                continue;
            }
            session::enter(&transaction, &entry.whole(&metrics)?)?;
            let key = session::key(&transaction, entry.session.id)?;
            for path in &entry.files {
                transaction.execute(
                    "INSERT OR IGNORE INTO session_file VALUES (?1, ?2)",
                    params![key, path],
                )?;
            }
            imported.sessions += 1;
        }
        for erasure in &document.erasures {
            transaction.execute(
                "INSERT INTO erasure (time, what, sessions, files) SELECT ?1, ?2, ?3, ?4 WHERE NOT EXISTS
                    (SELECT 1 FROM erasure WHERE time = ?1 AND what = ?2 AND sessions = ?3 AND files = ?4)",
                params![erasure.time, erasure.what, erasure.sessions, erasure.files],
            )?;
        }
        transaction.commit()?;
        Ok(imported)
    }
}

impl SessionEntry {
    /// The session with its metrics.
    fn whole(&self, metrics: &[Arc<Metric>]) -> Result<Session, StoreError> {
        let mut session = self.session.clone();
        for value in &self.values {
            let Some(metric) = metrics.get(value.metric) else {
                return refuse(format!(
                    "the session {} refers to metric {} of {}",
                    session.id,
                    value.metric,
                    metrics.len()
                ));
            };
            session.metrics.push(value.of(Arc::clone(metric)));
        }
        Ok(session)
    }
}
