//! Rows of sessions, metrics and values: their columns, and how they are read, for queries and for the export alike.

use crate::session::{Measured, Metric, Session, Verdict};
use rusqlite::types::Type;
use rusqlite::{Error, Row};

/// Columns that [`session`] reads.
pub(crate) const SESSION: &str = "session.key, session.id, session.path, session.trainee, session.module, session.level, session.started,
    session.simulated, session.finished, session.seed, session.input, session.version, session.realtime, session.synthetic,
    session.state_hash, session.verdict, session.counts, session.failed, session.duration, session.targets_done, session.targets,
    session.score, session.started_subsec_ns";

/// How many those are: a query may have others behind them.
pub(crate) const SESSION_COLUMNS: usize = 23;

/// Columns that [`metric`] reads.
pub(crate) const METRIC: &str =
    "key, id, title, unit, display_unit, display_factor, direction, category, formula";

/// Columns that [`measured`] reads.
pub(crate) const MEASURED: &str =
    "session, metric, value, limit_min, limit_max, decides, within, score";

/// A row with its key.
pub(crate) struct Keyed<T> {
    pub key: i64,
    pub row: T,
}

/// A session without trainee, categories and metrics, and the key of its trainee.
pub(crate) fn session(row: &Row<'_>) -> rusqlite::Result<(Keyed<Session>, Option<i64>)> {
    let wrong =
        |column, what: String| Error::FromSqlConversionFailure(column, Type::Text, what.into());
    let seed: String = row.get(9)?;
    let verdict: String = row.get(15)?;
    let failed: String = row.get(17)?;
    let session = Session {
        id: row.get(1)?,
        path: row.get(2)?,
        trainee: None,
        module: row.get(4)?,
        level: row.get(5)?,
        started: row.get(6)?,
        simulated: row.get(7)?,
        finished: row.get(8)?,
        seed: seed.parse().map_err(|_| wrong(9, format!("seed {seed}")))?,
        input: row.get(10)?,
        version: row.get(11)?,
        realtime: row.get(12)?,
        synthetic: row.get(13)?,
        state_hash: row.get(14)?,
        verdict: Verdict::from_name(&verdict)
            .ok_or_else(|| wrong(15, format!("verdict {verdict}")))?,
        counts: row.get(16)?,
        failed: failed.lines().map(str::to_owned).collect(),
        duration: row.get(18)?,
        targets_done: row.get(19)?,
        targets: row.get(20)?,
        score: row.get(21)?,
        started_subsec_ns: row.get(22)?,
        categories: Vec::new(),
        metrics: Vec::new(),
    };
    let key = row.get(0)?;
    Ok((Keyed { key, row: session }, row.get(3)?))
}

/// What a metric is.
pub(crate) fn metric(row: &Row<'_>) -> rusqlite::Result<Keyed<Metric>> {
    Ok(Keyed {
        key: row.get(0)?,
        row: Metric {
            id: row.get(1)?,
            title: row.get(2)?,
            unit: row.get(3)?,
            display_unit: row.get(4)?,
            display_factor: row.get(5)?,
            direction: row.get(6)?,
            category: row.get(7)?,
            formula: row.get(8)?,
        },
    })
}

/// A value with the key of its metric, and that of its session.
pub(crate) fn measured(row: &Row<'_>) -> rusqlite::Result<Keyed<Measured<i64>>> {
    Ok(Keyed {
        key: row.get(0)?,
        row: Measured {
            metric: row.get(1)?,
            value: row.get(2)?,
            min: row.get(3)?,
            max: row.get(4)?,
            decides: row.get(5)?,
            within: row.get(6)?,
            score: row.get(7)?,
        },
    })
}
