//! Sessions with their results: entered after a run, or read again from their files.

use crate::error::StoreError;
use crate::id::Id;
use crate::store::Store;
use crate::trainee;
use microsim_vocabulary::terms;
use rusqlite::{Connection, OptionalExtension, params};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

terms! {
    /// How a session ended for the trainee; the names are those of reports.
    pub enum Verdict {
        /// By the verdict of the module.
        Passed = "passed",
        /// By the verdict of the module, with reasons.
        Failed = "failed",
        /// Without a verdict: what was computed or measured is no ground for one.
        NotJudged = "not-judged",
        /// Ended by the operator.
        Aborted = "aborted",
        /// The module gave no result.
        Incomplete = "incomplete",
    }
}

/// What a metric is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metric {
    /// Its id.
    pub id: String,
    /// What people call it.
    pub title: String,
    /// SI unit of values and limits.
    pub unit: String,
    /// Unit to show.
    pub display_unit: String,
    /// A value in `unit` times this is in `display_unit`.
    pub display_factor: f64,
    /// Which side is better.
    pub direction: String,
    /// Category of the score.
    pub category: String,
    /// Id of the formula.
    pub formula: String,
}

/// The value of a metric in a session, with the metric, which many values have in common, or with what names it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured<M = Arc<Metric>> {
    /// The metric.
    pub metric: M,
    /// Value in the SI unit; `None`: not applicable.
    pub value: Option<f64>,
    /// Smallest value that passes.
    pub min: Option<f64>,
    /// Largest value that passes.
    pub max: Option<f64>,
    /// Whether the limit decides on a pass; `None` without a limit.
    pub decides: Option<bool>,
    /// Whether the value is within the limit.
    pub within: Option<bool>,
    /// Score, 0 to 100.
    pub score: Option<f64>,
}

impl<M> Measured<M> {
    /// The same value with another name of its metric.
    pub(crate) fn of<N>(&self, metric: N) -> Measured<N> {
        Measured {
            metric,
            value: self.value,
            min: self.min,
            max: self.max,
            decides: self.decides,
            within: self.within,
            score: self.score,
        }
    }
}

/// A session with its result. Documents have the values of its metrics beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Session {
    /// Its id.
    pub id: Id,
    /// Its file.
    pub path: String,
    /// Who trained.
    pub trainee: Option<Id>,
    /// Module.
    pub module: String,
    /// Level, from 1.
    pub level: u32,
    /// Wall clock at the start, seconds since 1970. When it ended does not stand in a session, so it is not here either.
    pub started: i64,
    /// Nanoseconds within that second; 0 for sessions of before 2026-11-26.
    #[serde(default)]
    pub started_subsec_ns: u32,
    /// Simulated time of all ticks \[s\].
    pub simulated: f64,
    /// Whether it was closed; otherwise its process was killed.
    pub finished: bool,
    /// Seed.
    pub seed: u64,
    /// Where the motion came from.
    pub input: String,
    /// Version of MicroSim that ran it.
    pub version: String,
    /// Whether it was paced by the wall clock.
    pub realtime: bool,
    /// By what a synthetic trainee was made.
    pub synthetic: Option<String>,
    /// State hash at the end.
    pub state_hash: Option<String>,
    /// How it ended.
    pub verdict: Verdict,
    /// Whether it counts as a result.
    pub counts: bool,
    /// Ids of the reasons why it failed.
    pub failed: Vec<String>,
    /// Running time of the level \[s\].
    pub duration: f64,
    /// Targets reached.
    pub targets_done: u32,
    /// Targets of the level.
    pub targets: u32,
    /// Score, 0 to 100.
    pub score: Option<f64>,
    /// Scores by category.
    pub categories: Vec<(String, f64)>,
    /// All metrics, by id.
    #[serde(skip)]
    pub metrics: Vec<Measured>,
}

/// A run that has begun and is not entered yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pending {
    /// File of its session.
    pub path: String,
    /// Its process.
    pub process: i64,
    /// When that process began, in the units of its system.
    pub process_started: i64,
}

/// Key of the row of a session.
pub(crate) fn key(connection: &Connection, id: Id) -> Result<Option<i64>, StoreError> {
    let mut statement = connection.prepare_cached("SELECT key FROM session WHERE id = ?1")?;
    Ok(statement.query_row([id], |row| row.get(0)).optional()?)
}

impl Session {
    /// The order of sessions: by their start, and by id where that is the same.
    pub fn order(&self) -> (i64, u32, Id) {
        (self.started, self.started_subsec_ns, self.id)
    }
}

/// Enters a session in the place of one of the same id.
pub(crate) fn enter(connection: &Connection, session: &Session) -> Result<(), StoreError> {
    let trainee = session.trainee;
    let trainee = trainee.map(|id| trainee::key_or_new(connection, id, session.started));
    let trainee = trainee.transpose()?;
    let mut insert = connection.prepare_cached(
        "INSERT INTO session (id, path, trainee, module, level, started, simulated, finished, seed, input, version, realtime,
            synthetic, state_hash, verdict, counts, failed, duration, targets_done, targets, score, started_subsec_ns)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22)
        ON CONFLICT (id) DO UPDATE SET path = ?2, trainee = ?3, module = ?4, level = ?5, started = ?6, simulated = ?7, finished = ?8,
            seed = ?9, input = ?10, version = ?11, realtime = ?12, synthetic = ?13, state_hash = ?14, verdict = ?15, counts = ?16,
            failed = ?17, duration = ?18, targets_done = ?19, targets = ?20, score = ?21,
            started_subsec_ns = ?22
        RETURNING key",
    )?;
    let key: i64 = insert.query_row(
        params![
            session.id,
            session.path,
            trainee,
            session.module,
            session.level,
            session.started,
            session.simulated,
            session.finished,
            session.seed.to_string(),
            session.input,
            session.version,
            session.realtime,
            session.synthetic,
            session.state_hash,
            session.verdict.name(),
            session.counts,
            session.failed.join("\n"),
            session.duration,
            session.targets_done,
            session.targets,
            session.score,
            session.started_subsec_ns,
        ],
        |row| row.get(0),
    )?;
    for table in ["category_score", "metric_value"] {
        let sql = format!("DELETE FROM {table} WHERE session = ?1");
        connection.prepare_cached(&sql)?.execute([key])?;
    }
    let mut insert = connection.prepare_cached("INSERT INTO category_score VALUES (?1, ?2, ?3)")?;
    for (category, score) in &session.categories {
        insert.execute(params![key, category, score])?;
    }
    let mut insert = connection.prepare_cached(
        "INSERT OR REPLACE INTO metric_value VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
    )?;
    for measured in &session.metrics {
        insert.execute(params![
            key,
            metric_key(connection, &measured.metric)?,
            measured.value,
            measured.min,
            measured.max,
            measured.decides,
            measured.within,
            measured.score,
        ])?;
    }
    let mut done = connection.prepare_cached("DELETE FROM pending WHERE path = ?1")?;
    done.execute([&session.path])?;
    Ok(())
}

/// Key of the row of a metric, which is made if there is none.
fn metric_key(connection: &Connection, metric: &Metric) -> Result<i64, StoreError> {
    let values = params![
        metric.id,
        metric.title,
        metric.unit,
        metric.display_unit,
        metric.display_factor,
        metric.direction,
        metric.category,
        metric.formula
    ];
    let mut find = connection.prepare_cached(
        "SELECT key FROM metric WHERE id = ?1 AND title = ?2 AND unit = ?3 AND display_unit = ?4 AND display_factor = ?5
            AND direction = ?6 AND category = ?7 AND formula = ?8",
    )?;
    if let Some(key) = find.query_row(values, |row| row.get(0)).optional()? {
        return Ok(key);
    }
    let mut insert = connection.prepare_cached(
        "INSERT INTO metric (id, title, unit, display_unit, display_factor, direction, category, formula)
        VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
    )?;
    insert.execute(values)?;
    Ok(connection.last_insert_rowid())
}

impl Store {
    /// Enters sessions, each in the place of one of the same id, in one transaction: all or none. A trainee whose id is not known gets a row
    /// without a name.
    ///
    /// # Errors
    /// Those of the database.
    pub fn enter(&mut self, sessions: &[Session]) -> Result<(), StoreError> {
        let transaction = self.write()?;
        for session in sessions {
            enter(&transaction, session)?;
        }
        Ok(transaction.commit()?)
    }

    /// Notes that a run begins, so that its session is entered even if its process is killed before it could do so.
    ///
    /// # Errors
    /// Those of the database.
    pub fn begin(&mut self, pending: &Pending) -> Result<(), StoreError> {
        let transaction = self.write()?;
        transaction.execute(
            "INSERT OR REPLACE INTO pending VALUES (?1, ?2, ?3)",
            params![pending.path, pending.process, pending.process_started],
        )?;
        Ok(transaction.commit()?)
    }

    /// The runs that have begun and are not entered yet.
    ///
    /// # Errors
    /// Those of the database.
    pub fn pending(&self) -> Result<Vec<Pending>, StoreError> {
        let mut statement = self
            .connection
            .prepare("SELECT path, process, process_started FROM pending ORDER BY path")?;
        let rows = statement.query_map([], |row| {
            Ok(Pending {
                path: row.get(0)?,
                process: row.get(1)?,
                process_started: row.get(2)?,
            })
        })?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }

    /// Forgets runs whose sessions are not there or cannot be read: nothing of them can be entered.
    ///
    /// # Errors
    /// Those of the database.
    pub fn forget_pending(&mut self, paths: &[String]) -> Result<(), StoreError> {
        let transaction = self.write()?;
        for path in paths {
            transaction.execute("DELETE FROM pending WHERE path = ?1", [path])?;
        }
        Ok(transaction.commit()?)
    }

    /// Notes files that were written for a session. Those of them that do not lie `beside` it belong to it from now on, and none belongs to another
    /// session any more, whose file of that name is gone. A session that is not here has none.
    ///
    /// # Errors
    /// Those of the database.
    pub fn attach(
        &mut self,
        id: Id,
        paths: &[String],
        beside: &[String],
    ) -> Result<(), StoreError> {
        let transaction = self.write()?;
        if let Some(key) = key(&transaction, id)? {
            for path in paths {
                transaction.execute(
                    "DELETE FROM session_file WHERE path = ?2 AND session <> ?1",
                    params![key, path],
                )?;
                if !beside.contains(path) {
                    transaction.execute(
                        "INSERT OR IGNORE INTO session_file VALUES (?1, ?2)",
                        params![key, path],
                    )?;
                }
            }
        }
        Ok(transaction.commit()?)
    }

    /// Whether a file that lies beside a session of this trainee, or did, was written for a session of somebody else since.
    ///
    /// # Errors
    /// Those of the database.
    pub fn is_of_another(&self, path: &str, trainee: Id) -> Result<bool, StoreError> {
        let mut statement = self.connection.prepare_cached(
            "SELECT 1 FROM session_file JOIN session ON session_file.session = session.key
            WHERE session_file.path = ?1 AND session.trainee IS NOT (SELECT key FROM trainee WHERE id = ?2)",
        )?;
        Ok(statement.exists(params![path, trainee])?)
    }

    /// Files that belong to a session and do not lie beside it.
    ///
    /// # Errors
    /// Those of the database.
    pub fn attached(&self, id: Id) -> Result<Vec<String>, StoreError> {
        let mut statement = self.connection.prepare(
            "SELECT session_file.path FROM session_file JOIN session ON session_file.session = session.key
            WHERE session.id = ?1 ORDER BY session_file.path",
        )?;
        let rows = statement.query_map([id], |row| row.get(0))?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }

    /// Puts sessions in the place of all that have one of these ids or paths, in one transaction: what sessions on the disk show. Sessions
    /// that are not among them stay, as their files may be gone. Returns how many those are.
    ///
    /// # Errors
    /// Those of the database.
    pub fn rebuild(&mut self, sessions: &[Session]) -> Result<i64, StoreError> {
        let transaction = self.write()?;
        for session in sessions {
            // Another session lay here before.
            transaction.execute(
                "DELETE FROM session WHERE path = ?1 AND id <> ?2",
                params![session.path, session.id],
            )?;
            enter(&transaction, session)?;
        }
        let all: i64 =
            transaction.query_row("SELECT count(*) FROM session", [], |row| row.get(0))?;
        transaction.commit()?;
        Ok(all - sessions.len() as i64)
    }
}
