//! Finding results.

use crate::error::{StoreError, refuse};
use crate::group;
use crate::id::Id;
use crate::session::{Measured, Metric, Session, Verdict};
use crate::store::Store;
use rusqlite::types::Value;
use rusqlite::{Row, params_from_iter};

/// Which sessions are wanted: those that are all that is named.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    /// Of this trainee.
    pub trainee: Option<Id>,
    /// Of the members of this group.
    pub group: Option<String>,
    /// Of this module.
    pub module: Option<String>,
    /// Of this level.
    pub level: Option<u32>,
    /// Started at this time or later, seconds since 1970.
    pub since: Option<i64>,
}

impl Filter {
    /// Condition on `session`, with its values.
    fn condition(&self) -> (String, Vec<Value>) {
        let mut parts = Vec::new();
        let mut values: Vec<Value> = Vec::new();
        let mut add = |sql: &str, value: Value| {
            values.push(value);
            parts.push(sql.replace('?', &format!("?{}", values.len())));
        };
        if let Some(id) = self.trainee {
            add(
                "session.trainee = (SELECT key FROM trainee WHERE id = ?)",
                id.to_string().into(),
            );
        }
        if let Some(group) = &self.group {
            add(
                "session.trainee IN (SELECT membership.trainee FROM membership JOIN trainee_group
                    ON membership.trainee_group = trainee_group.key WHERE trainee_group.name = ?)",
                group.clone().into(),
            );
        }
        if let Some(module) = &self.module {
            add("session.module = ?", module.clone().into());
        }
        if let Some(level) = self.level {
            add("session.level = ?", i64::from(level).into());
        }
        if let Some(since) = self.since {
            add("session.started >= ?", since.into());
        }
        match parts.is_empty() {
            true => ("true".into(), values),
            false => (parts.join(" AND "), values),
        }
    }
}

/// A session with the name of its trainee.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSession {
    /// The session.
    pub session: Session,
    /// Name of the trainee, if one is known.
    pub name: Option<String>,
}

const SESSION: &str = "session.id, session.path, trainee.id, session.module, session.level, session.started, session.simulated,
    session.finished, session.seed, session.input, session.version, session.realtime, session.synthetic, session.state_hash,
    session.verdict, session.counts, session.failed, session.duration, session.targets_done, session.targets, session.score,
    trainee.name, session.key";

const MEASURED: &str = "metric.id, metric.title, metric.unit, metric.display_unit, metric.display_factor, metric.direction,
    metric.category, metric.formula, metric_value.value, metric_value.limit_min, metric_value.limit_max, metric_value.decides,
    metric_value.within, metric_value.score";

/// By time, and by id where that is the same.
const ORDER: &str = "session.started, session.id";

const CATEGORIES: &str =
    "SELECT category, score FROM category_score WHERE session = ?1 ORDER BY category";

/// The metrics of a session, by id.
fn measures() -> String {
    format!(
        "SELECT {MEASURED} FROM metric_value JOIN metric ON metric.key = metric_value.metric
        WHERE metric_value.session = ?1 ORDER BY metric.id"
    )
}

fn session(row: &Row<'_>) -> rusqlite::Result<NamedSession> {
    let wrong = |column, what: String| {
        let kind = rusqlite::types::Type::Text;
        rusqlite::Error::FromSqlConversionFailure(column, kind, what.into())
    };
    let seed: String = row.get(8)?;
    let verdict: String = row.get(14)?;
    let failed: String = row.get(16)?;
    Ok(NamedSession {
        session: Session {
            id: row.get(0)?,
            path: row.get(1)?,
            trainee: row.get(2)?,
            module: row.get(3)?,
            level: row.get(4)?,
            started: row.get(5)?,
            simulated: row.get(6)?,
            finished: row.get(7)?,
            seed: seed.parse().map_err(|_| wrong(8, format!("seed {seed}")))?,
            input: row.get(9)?,
            version: row.get(10)?,
            realtime: row.get(11)?,
            synthetic: row.get(12)?,
            state_hash: row.get(13)?,
            verdict: Verdict::from_name(&verdict)
                .ok_or_else(|| wrong(14, format!("verdict {verdict}")))?,
            counts: row.get(15)?,
            failed: failed.lines().map(str::to_owned).collect(),
            duration: row.get(17)?,
            targets_done: row.get(18)?,
            targets: row.get(19)?,
            score: row.get(20)?,
            categories: Vec::new(),
            metrics: Vec::new(),
        },
        name: row.get(21)?,
    })
}

fn measured(row: &Row<'_>) -> rusqlite::Result<Measured> {
    Ok(Measured {
        metric: Metric {
            id: row.get(0)?,
            title: row.get(1)?,
            unit: row.get(2)?,
            display_unit: row.get(3)?,
            display_factor: row.get(4)?,
            direction: row.get(5)?,
            category: row.get(6)?,
            formula: row.get(7)?,
        },
        value: row.get(8)?,
        min: row.get(9)?,
        max: row.get(10)?,
        decides: row.get(11)?,
        within: row.get(12)?,
        score: row.get(13)?,
    })
}

impl Store {
    /// Calls `each` with every session, by time, with categories and, if wanted, metrics; one session is in memory at a time. What `each`
    /// refuses ends it.
    ///
    /// # Errors
    /// A group that is not there, what `each` returns, and those of the database.
    pub fn each_session<E: From<StoreError>>(
        &self,
        filter: &Filter,
        metrics: bool,
        mut each: impl FnMut(NamedSession) -> Result<(), E>,
    ) -> Result<(), E> {
        if let Some(name) = &filter.group {
            group::must_be(&self.connection, name)?;
        }
        let (condition, values) = filter.condition();
        self.each_where(&condition, &values, metrics, &mut each)
    }

    fn each_where<E: From<StoreError>>(
        &self,
        condition: &str,
        values: &[Value],
        metrics: bool,
        each: &mut dyn FnMut(NamedSession) -> Result<(), E>,
    ) -> Result<(), E> {
        let failed = |error: rusqlite::Error| E::from(StoreError::from(error));
        let sql = format!(
            "SELECT {SESSION} FROM session LEFT JOIN trainee ON trainee.key = session.trainee WHERE {condition} ORDER BY {ORDER}"
        );
        let mut sessions = self.connection.prepare(&sql).map_err(failed)?;
        let mut categories = self.connection.prepare(CATEGORIES).map_err(failed)?;
        let mut measures = self.connection.prepare(&measures()).map_err(failed)?;
        let mut rows = sessions.query(params_from_iter(values)).map_err(failed)?;
        while let Some(row) = rows.next().map_err(failed)? {
            let mut read = || -> rusqlite::Result<NamedSession> {
                let mut named = session(row)?;
                let key: i64 = row.get(22)?;
                let rows = categories.query_map([key], |row| Ok((row.get(0)?, row.get(1)?)))?;
                named.session.categories = rows.collect::<rusqlite::Result<_>>()?;
                if metrics {
                    let rows = measures.query_map([key], measured)?;
                    named.session.metrics = rows.collect::<rusqlite::Result<_>>()?;
                }
                Ok(named)
            };
            each(read().map_err(failed)?)?;
        }
        Ok(())
    }

    /// The sessions, by time, with categories and, if wanted, metrics.
    ///
    /// # Errors
    /// A group that is not there, and those of the database.
    pub fn results(&self, filter: &Filter, metrics: bool) -> Result<Vec<NamedSession>, StoreError> {
        let mut found = Vec::new();
        self.each_session(filter, metrics, |named| {
            found.push(named);
            Ok::<(), StoreError>(())
        })?;
        Ok(found)
    }

    /// The session whose id begins with a text, or that lies at it.
    ///
    /// # Errors
    /// [`StoreError::Refused`] if there is none or more than one, and those of the database.
    pub fn find_session(&self, asked: &str) -> Result<NamedSession, StoreError> {
        // Only digits are left, so that nothing in it is a pattern.
        let is_prefix = !asked.is_empty() && asked.bytes().all(|b| b.is_ascii_hexdigit());
        let condition = "session.path = ?1 OR (?2 AND session.id GLOB ?1 || '*')";
        let values = [Value::from(asked.to_owned()), Value::from(is_prefix)];
        let mut found = Vec::new();
        self.each_where(condition, &values, true, &mut |named| {
            found.push(named);
            Ok::<(), StoreError>(())
        })?;
        match found.len() {
            0 => refuse(format!(
                "no session \"{asked}\" in the store; expected the beginning of an id as `microsim results` shows it, or the file of a session"
            )),
            1 => Ok(found.remove(0)),
            n => refuse(format!(
                "{n} sessions begin with \"{asked}\"; give more of the id"
            )),
        }
    }

    /// Files of all sessions, with their ids, by path.
    ///
    /// # Errors
    /// Those of the database.
    pub fn session_paths(&self) -> Result<Vec<(String, Id)>, StoreError> {
        let mut statement = self
            .connection
            .prepare("SELECT path, id FROM session ORDER BY path")?;
        let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }
}
