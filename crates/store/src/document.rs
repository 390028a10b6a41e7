//! The whole store as one document: what sessions on the disk cannot give back, and what they can.

use crate::course::{self, Course, Enrolled, Step};
use crate::erase::Erasure;
use crate::error::{StoreError, refuse};
use crate::group;
use crate::id::Id;
use crate::population::{self, PopulationRecord};
use crate::salvage::{Lost, Salvaged, read};
use crate::session::{self, Measured, Metric, Session, Verdict};
use crate::store::Store;
use crate::trainee::{self, Role, Trainee};
use rusqlite::params;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
    /// Values of metrics.
    pub values: Vec<Value>,
}

/// The value of a metric.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// Place of the metric in [`Document::metrics`].
    pub metric: usize,
    /// Value; `None`: not applicable.
    pub value: Option<f64>,
    /// Smallest value that passes.
    pub min: Option<f64>,
    /// Largest value that passes.
    pub max: Option<f64>,
    /// Whether the limit decides.
    pub decides: Option<bool>,
    /// Whether the value is within the limit.
    pub within: Option<bool>,
    /// Score.
    pub score: Option<f64>,
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
            entry.groups.retain(|name| groups.iter().any(|group| group.name == *name));
        }
        self.courses.retain(|entry| {
            !(entry.trainees.is_empty() && entry.groups.is_empty() && entry.unlocked.is_empty())
        });
        self.sessions.retain(|entry| entry.session.trainee == Some(id));
        self.populations.clear();
        self.erasures.clear();
        self
    }
}

/// Tables in memory, with what is lost of them.
struct Reader<'a> {
    store: &'a Store,
    losses: Vec<String>,
}

impl Reader<'_> {
    fn table<T>(
        &mut self,
        table: &str,
        key: &str,
        columns: &str,
        mut of: impl FnMut(&rusqlite::Row<'_>) -> rusqlite::Result<T>,
    ) -> Vec<T> {
        let Salvaged { rows, lost } = read(&self.store.connection, table, key, columns, &mut of);
        match lost {
            Lost::Nothing => {}
            Lost::Keys(n) => self.losses.push(format!(
                "{table}: {} rows were read, those of {n} keys cannot be read",
                rows.len()
            )),
            Lost::Most => self.losses.push(format!(
                "{table}: {} rows were read, the rest cannot be read",
                rows.len()
            )),
        }
        rows
    }
}

impl Store {
    /// Everything in the store, and what of it cannot be read, a sentence for each table that is damaged. A store that is intact loses nothing.
    pub fn export(&self) -> (Document, Vec<String>) {
        let mut reader = Reader {
            store: self,
            losses: Vec::new(),
        };
        let trainees = reader.table("trainee", "key", "key, id, name, role, created", |row| {
            let role: String = row.get(3)?;
            Ok((
                row.get::<_, i64>(0)?,
                Trainee {
                    id: row.get(1)?,
                    name: row.get(2)?,
                    role: Role::from_name(&role).unwrap_or(Role::Trainee),
                    created: row.get(4)?,
                },
            ))
        });
        let ids: BTreeMap<i64, Id> = trainees.iter().map(|(key, t)| (*key, t.id)).collect();
        let mut groups: BTreeMap<i64, Group> = reader
            .table("trainee_group", "key", "key, name", |row| {
                let (name, members) = (row.get(1)?, Vec::new());
                Ok((row.get::<_, i64>(0)?, Group { name, members }))
            })
            .into_iter()
            .collect();
        let members = reader.table("membership", "trainee_group", "trainee_group, trainee", |row| {
            Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?))
        });
        for (group, trainee) in members {
            if let (Some(group), Some(id)) = (groups.get_mut(&group), ids.get(&trainee)) {
                group.members.push(*id);
            }
        }
        let courses = courses(&mut reader, &ids, &groups);
        let populations = populations(&mut reader);
        let (metrics, sessions) = sessions(&mut reader, &ids);
        let erasures = reader.table("erasure", "key", "time, what, sessions, files", |row| {
            Ok(Erasure {
                time: row.get(0)?,
                what: row.get(1)?,
                sessions: row.get(2)?,
                files: row.get(3)?,
            })
        });
        let mut trainees: Vec<Trainee> = trainees.into_iter().map(|(_, t)| t).collect();
        trainees.sort_by_key(|trainee| trainee.id);
        let mut groups: Vec<Group> = groups.into_values().collect();
        groups.iter_mut().for_each(|group| group.members.sort());
        groups.sort_by(|a, b| a.name.cmp(&b.name));
        let document = Document {
            format: DOCUMENT_FORMAT,
            trainees,
            groups,
            courses,
            populations,
            metrics,
            sessions,
            erasures,
        };
        (document, reader.losses)
    }

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
                let Unlocked { trainee, module, level } = unlocked;
                course::unlock(&transaction, key, *trainee, module, *level)?;
            }
        }
        for record in &document.populations {
            population::put(&transaction, record)?;
            imported.populations += 1;
        }
        for entry in &document.sessions {
            if session::key(&transaction, entry.session.id)?.is_some() {
                continue;
            }
            session::enter(&transaction, &entry.whole(&document.metrics)?)?;
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
    fn whole(&self, metrics: &[Metric]) -> Result<Session, StoreError> {
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
            session.metrics.push(Measured {
                metric: metric.clone(),
                value: value.value,
                min: value.min,
                max: value.max,
                decides: value.decides,
                within: value.within,
                score: value.score,
            });
        }
        Ok(session)
    }
}

fn courses(
    reader: &mut Reader<'_>,
    ids: &BTreeMap<i64, Id>,
    groups: &BTreeMap<i64, Group>,
) -> Vec<CourseEntry> {
    let columns = "key, name, title_en, title_de, in_order";
    let rows = reader.table("course", "key", columns, |row| {
        let course = Course {
            name: row.get(1)?,
            title_en: row.get(2)?,
            title_de: row.get(3)?,
            in_order: row.get(4)?,
            steps: Vec::new(),
        };
        let (trainees, groups, unlocked) = (Vec::new(), Vec::new(), Vec::new());
        let entry = CourseEntry { course, trainees, groups, unlocked };
        Ok((row.get::<_, i64>(0)?, entry))
    });
    let mut courses: BTreeMap<i64, CourseEntry> = rows.into_iter().collect();
    let columns = "course, module, level, passes";
    let steps = reader.table("course_step", "course", columns, |row| {
        let (module, level, passes) = (row.get(1)?, row.get(2)?, row.get(3)?);
        Ok((row.get::<_, i64>(0)?, Step { module, level, passes }))
    });
    for (course, step) in steps {
        if let Some(entry) = courses.get_mut(&course) {
            entry.course.steps.push(step);
        }
    }
    let columns = "course, trainee, trainee_group";
    let enrolled = reader.table("enrolment", "rowid", columns, |row| {
        Ok((row.get::<_, i64>(0)?, row.get::<_, Option<i64>>(1)?, row.get::<_, Option<i64>>(2)?))
    });
    for (course, trainee, group) in enrolled {
        let Some(entry) = courses.get_mut(&course) else {
            continue;
        };
        entry.trainees.extend(trainee.and_then(|key| ids.get(&key)));
        let group = group.and_then(|key| groups.get(&key));
        entry.groups.extend(group.map(|group| group.name.clone()));
    }
    let columns = "course, trainee, module, level";
    let unlocked = reader.table("unlocked", "course", columns, |row| {
        let (module, level) = (row.get(2)?, row.get(3)?);
        let keys = (row.get::<_, i64>(0)?, row.get::<_, i64>(1)?);
        Ok((keys, module, level))
    });
    for ((course, trainee), module, level) in unlocked {
        if let (Some(entry), Some(trainee)) = (courses.get_mut(&course), ids.get(&trainee)) {
            let trainee = *trainee;
            entry.unlocked.push(Unlocked { trainee, module, level });
        }
    }
    let mut courses: Vec<CourseEntry> = courses.into_values().collect();
    for entry in &mut courses {
        entry.trainees.sort();
        entry.groups.sort();
        entry.unlocked.sort_by(|a, b| (a.trainee, &a.module, a.level).cmp(&(b.trainee, &b.module, b.level)));
    }
    courses.sort_by(|a, b| a.course.name.cmp(&b.course.name));
    courses
}

fn populations(reader: &mut Reader<'_>) -> Vec<PopulationRecord> {
    let columns = "key, module, level, metric, source, n, mean, deviation";
    let rows = reader.table("population", "key", columns, |row| {
        let record = PopulationRecord {
            module: row.get(1)?,
            level: row.get(2)?,
            metric: row.get(3)?,
            source: row.get(4)?,
            n: row.get(5)?,
            mean: row.get(6)?,
            deviation: row.get(7)?,
            percentiles: Vec::new(),
        };
        Ok((row.get::<_, i64>(0)?, record))
    });
    let mut records: BTreeMap<i64, PopulationRecord> = rows.into_iter().collect();
    let columns = "population, percent, value";
    let values = reader.table("population_percentile", "population", columns, |row| {
        Ok((row.get::<_, i64>(0)?, (row.get(1)?, row.get(2)?)))
    });
    for (population, percentile) in values {
        if let Some(record) = records.get_mut(&population) {
            record.percentiles.push(percentile);
        }
    }
    records.into_values().collect()
}

fn sessions(reader: &mut Reader<'_>, ids: &BTreeMap<i64, Id>) -> (Vec<Metric>, Vec<SessionEntry>) {
    let columns = "key, id, path, trainee, module, level, started, simulated, finished, seed, input, version, realtime, synthetic,
        state_hash, verdict, counts, failed, duration, targets_done, targets, score";
    let rows = reader.table("session", "key", columns, |row| {
        let trainee: Option<i64> = row.get(3)?;
        let seed: String = row.get(9)?;
        let verdict: String = row.get(15)?;
        let failed: String = row.get(17)?;
        let session = Session {
            id: row.get(1)?,
            path: row.get(2)?,
            trainee: trainee.and_then(|key| ids.get(&key)).copied(),
            module: row.get(4)?,
            level: row.get(5)?,
            started: row.get(6)?,
            simulated: row.get(7)?,
            finished: row.get(8)?,
            seed: seed.parse().unwrap_or_default(),
            input: row.get(10)?,
            version: row.get(11)?,
            realtime: row.get(12)?,
            synthetic: row.get(13)?,
            state_hash: row.get(14)?,
            verdict: Verdict::from_name(&verdict).unwrap_or(Verdict::Incomplete),
            counts: row.get(16)?,
            failed: failed.lines().map(str::to_owned).collect(),
            duration: row.get(18)?,
            targets_done: row.get(19)?,
            targets: row.get(20)?,
            score: row.get(21)?,
            categories: Vec::new(),
            metrics: Vec::new(),
        };
        let (files, values) = (Vec::new(), Vec::new());
        let entry = SessionEntry { session, files, values };
        Ok((row.get::<_, i64>(0)?, entry))
    });
    let mut sessions: BTreeMap<i64, SessionEntry> = rows.into_iter().collect();
    let scores = reader.table("category_score", "session", "session, category, score", |row| {
        Ok((row.get::<_, i64>(0)?, (row.get(1)?, row.get(2)?)))
    });
    for (session, score) in scores {
        if let Some(entry) = sessions.get_mut(&session) {
            entry.session.categories.push(score);
        }
    }
    let files = reader.table("session_file", "session", "session, path", |row| {
        Ok((row.get::<_, i64>(0)?, row.get(1)?))
    });
    for (session, path) in files {
        if let Some(entry) = sessions.get_mut(&session) {
            entry.files.push(path);
        }
    }
    let columns =
        "key, id, title, unit, display_unit, display_factor, direction, category, formula";
    let mut metrics = Vec::new();
    let mut places = BTreeMap::new();
    let rows = reader.table("metric", "key", columns, |row| {
        let metric = Metric {
            id: row.get(1)?,
            title: row.get(2)?,
            unit: row.get(3)?,
            display_unit: row.get(4)?,
            display_factor: row.get(5)?,
            direction: row.get(6)?,
            category: row.get(7)?,
            formula: row.get(8)?,
        };
        Ok((row.get::<_, i64>(0)?, metric))
    });
    for (key, metric) in rows {
        places.insert(key, metrics.len());
        metrics.push(metric);
    }
    let columns = "session, metric, value, limit_min, limit_max, decides, within, score";
    let values = reader.table("metric_value", "session", columns, |row| {
        let value = Value {
            metric: 0,
            value: row.get(2)?,
            min: row.get(3)?,
            max: row.get(4)?,
            decides: row.get(5)?,
            within: row.get(6)?,
            score: row.get(7)?,
        };
        Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?, value))
    });
    for (session, metric, value) in values {
        if let (Some(entry), Some(metric)) = (sessions.get_mut(&session), places.get(&metric)) {
            let metric = *metric;
            entry.values.push(Value { metric, ..value });
        }
    }
    let mut sessions: Vec<SessionEntry> = sessions.into_values().collect();
    sessions.sort_by_key(|entry| entry.session.id);
    (metrics, sessions)
}
