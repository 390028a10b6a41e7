//! Reading the whole store, also one that is damaged.

use crate::course::{Course, Step};
use crate::document::{CourseEntry, DOCUMENT_FORMAT, Document, Group, SessionEntry, Unlocked};
use crate::erase::Erasure;
use crate::id::Id;
use crate::population::PopulationRecord;
use crate::rows::{self, Keyed, MEASURED, METRIC, SESSION};
use crate::salvage::{Lost, Salvaged, read};
use crate::session::Metric;
use crate::store::Store;
use crate::trainee::{Role, Trainee};
use std::collections::BTreeMap;

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
        let members = reader.table(
            "membership",
            "trainee_group",
            "trainee_group, trainee",
            |row| Ok((row.get::<_, i64>(0)?, row.get::<_, i64>(1)?)),
        );
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
        let entry = CourseEntry {
            course,
            trainees,
            groups,
            unlocked,
        };
        Ok((row.get::<_, i64>(0)?, entry))
    });
    let mut courses: BTreeMap<i64, CourseEntry> = rows.into_iter().collect();
    let columns = "course, module, level, passes";
    let steps = reader.table("course_step", "course", columns, |row| {
        let (module, level, passes) = (row.get(1)?, row.get(2)?, row.get(3)?);
        Ok((
            row.get::<_, i64>(0)?,
            Step {
                module,
                level,
                passes,
            },
        ))
    });
    for (course, step) in steps {
        if let Some(entry) = courses.get_mut(&course) {
            entry.course.steps.push(step);
        }
    }
    let columns = "course, trainee, trainee_group";
    let enrolled = reader.table("enrolment", "rowid", columns, |row| {
        Ok((
            row.get::<_, i64>(0)?,
            row.get::<_, Option<i64>>(1)?,
            row.get::<_, Option<i64>>(2)?,
        ))
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
            entry.unlocked.push(Unlocked {
                trainee,
                module,
                level,
            });
        }
    }
    let mut courses: Vec<CourseEntry> = courses.into_values().collect();
    for entry in &mut courses {
        entry.trainees.sort();
        entry.groups.sort();
        entry
            .unlocked
            .sort_by(|a, b| (a.trainee, &a.module, a.level).cmp(&(b.trainee, &b.module, b.level)));
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
    let rows = reader.table("session", "key", SESSION, rows::session);
    let rows = rows.into_iter().map(|(Keyed { key, row }, trainee)| {
        let mut session = row;
        session.trainee = trainee.and_then(|key| ids.get(&key)).copied();
        let (files, values) = (Vec::new(), Vec::new());
        let entry = SessionEntry {
            session,
            files,
            values,
        };
        (key, entry)
    });
    let mut sessions: BTreeMap<i64, SessionEntry> = rows.collect();
    let scores = reader.table(
        "category_score",
        "session",
        "session, category, score",
        |row| Ok((row.get::<_, i64>(0)?, (row.get(1)?, row.get(2)?))),
    );
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
    let mut metrics = Vec::new();
    let mut places = BTreeMap::new();
    for Keyed { key, row } in reader.table("metric", "key", METRIC, rows::metric) {
        places.insert(key, metrics.len());
        metrics.push(row);
    }
    for Keyed { key, row } in reader.table("metric_value", "session", MEASURED, rows::measured) {
        if let (Some(entry), Some(place)) = (sessions.get_mut(&key), places.get(&row.metric)) {
            entry.values.push(row.of(*place));
        }
    }
    let mut sessions: Vec<SessionEntry> = sessions.into_values().collect();
    sessions.sort_by_key(|entry| entry.session.id);
    (metrics, sessions)
}
