//! Finding results.

use crate::error::{StoreError, refuse};
use crate::group;
use crate::id::Id;
use crate::rows::{self, Keyed, MEASURED, METRIC, SESSION, SESSION_COLUMNS};
use crate::session::{Measured, Metric, Session};
use crate::store::Store;
use rusqlite::types::{Type, Value};
use rusqlite::{Connection, Statement, params_from_iter};
use std::collections::BTreeMap;
use std::sync::Arc;

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

/// The metrics that sessions have values of, by key, each with its place in the order of ids.
type Metrics = BTreeMap<i64, (usize, Arc<Metric>)>;

fn metrics(connection: &Connection) -> rusqlite::Result<Metrics> {
    let sql = format!("SELECT {METRIC} FROM metric ORDER BY id, key");
    let mut statement = connection.prepare(&sql)?;
    let rows = statement.query_map([], rows::metric)?;
    let rows = rows.enumerate().map(|(place, row)| {
        let Keyed { key, row } = row?;
        Ok((key, (place, Arc::new(row))))
    });
    rows.collect()
}

/// The values of a session, in the order of the ids of their metrics.
fn values(
    key: i64,
    statement: &mut Statement<'_>,
    metrics: &Metrics,
) -> rusqlite::Result<Vec<Measured>> {
    let mut found = Vec::new();
    let mut rows = statement.query([key])?;
    while let Some(row) = rows.next()? {
        let value = rows::measured(row)?.row;
        let (place, metric) = metrics.get(&value.metric).ok_or_else(|| {
            let what = format!("a value of metric {}, which is not there", value.metric);
            rusqlite::Error::FromSqlConversionFailure(1, Type::Integer, what.into())
        })?;
        found.push((*place, value.of(Arc::clone(metric))));
    }
    found.sort_by_key(|(place, _)| *place);
    Ok(found.into_iter().map(|(_, value)| value).collect())
}

/// Keys of sessions in the order of [`Session::order`]. Sorted here: the database would sort whole rows, in files.
fn keys(connection: &Connection, condition: &str, values: &[Value]) -> rusqlite::Result<Vec<i64>> {
    let sql = format!(
        "SELECT session.started, session.started_subsec_ns, session.id, session.key FROM session WHERE {condition}"
    );
    let mut statement = connection.prepare(&sql)?;
    let rows = statement.query_map(params_from_iter(values), |row| {
        Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?))
    })?;
    let mut rows = rows.collect::<rusqlite::Result<Vec<(i64, u32, Id, i64)>>>()?;
    rows.sort_unstable();
    Ok(rows.into_iter().map(|(_, _, _, key)| key).collect())
}

/// What reads sessions by their keys.
struct Reading<'a> {
    sessions: Statement<'a>,
    categories: Statement<'a>,
    values: Option<(Statement<'a>, Metrics)>,
}

impl<'a> Reading<'a> {
    fn new(connection: &'a Connection, with_metrics: bool) -> rusqlite::Result<Self> {
        let sessions = format!(
            "SELECT {SESSION}, trainee.id, trainee.name FROM session LEFT JOIN trainee ON trainee.key = session.trainee
            WHERE session.key = ?1"
        );
        let categories =
            "SELECT category, score FROM category_score WHERE session = ?1 ORDER BY category";
        let values = with_metrics.then(|| {
            let sql = format!("SELECT {MEASURED} FROM metric_value WHERE session = ?1");
            Ok::<_, rusqlite::Error>((connection.prepare(&sql)?, metrics(connection)?))
        });
        Ok(Self {
            sessions: connection.prepare(&sessions)?,
            categories: connection.prepare(categories)?,
            values: values.transpose()?,
        })
    }

    fn session(&mut self, key: i64) -> rusqlite::Result<NamedSession> {
        let mut named = self.sessions.query_row([key], |row| {
            let mut session = rows::session(row)?.0.row;
            session.trainee = row.get(SESSION_COLUMNS)?;
            let name = row.get(SESSION_COLUMNS + 1)?;
            Ok(NamedSession { session, name })
        })?;
        let scores = self
            .categories
            .query_map([key], |row| Ok((row.get(0)?, row.get(1)?)))?;
        named.session.categories = scores.collect::<rusqlite::Result<_>>()?;
        if let Some((statement, metrics)) = &mut self.values {
            named.session.metrics = values(key, statement, metrics)?;
        }
        Ok(named)
    }
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
        // All of it from one moment, whatever other processes write meanwhile.
        let now = self.connection.unchecked_transaction().map_err(failed)?;
        let mut reading = Reading::new(&now, metrics).map_err(failed)?;
        for key in keys(&now, condition, values).map_err(failed)? {
            each(reading.session(key).map_err(failed)?)?;
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
