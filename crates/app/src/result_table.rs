//! Results as one tidy table: a row for each metric of each session, in SI.

use crate::date;
use crate::output::Problem;
use crate::replace_file::replace_by;
use microsim_store::{Filter, Measured, NamedSession, Store, StoreError};
use microsim_table::{Cell, Column, Format, Kind, TableError, TableWriter};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

const fn column(name: &'static str, kind: Kind) -> Column {
    Column { name, kind }
}

/// Columns; a session without metrics has one row, in which those of metrics are empty. `groups` are joined by semicolons, `failed` by blanks.
const COLUMNS: [Column; 28] = [
    column("session", Kind::Text),
    column("trainee", Kind::Text),
    column("name", Kind::Text),
    column("groups", Kind::Text),
    column("module", Kind::Text),
    column("level", Kind::Integer),
    column("started", Kind::Text),
    column("started_unix_s", Kind::Integer),
    column("seed", Kind::Text),
    column("input", Kind::Text),
    column("version", Kind::Text),
    column("synthetic", Kind::Text),
    column("verdict", Kind::Text),
    column("counts", Kind::Flag),
    column("failed", Kind::Text),
    column("duration_s", Kind::Real),
    column("session_score", Kind::Real),
    column("metric", Kind::Text),
    column("metric_title", Kind::Text),
    column("category", Kind::Text),
    column("direction", Kind::Text),
    column("value", Kind::Real),
    column("unit", Kind::Text),
    column("limit_min", Kind::Real),
    column("limit_max", Kind::Real),
    column("limit_decides", Kind::Flag),
    column("within", Kind::Flag),
    column("score", Kind::Real),
];

/// How many of the columns, the last ones, are of a metric.
const METRIC_COLUMNS: usize = 11;

/// An error of the store or of the table.
struct Failure(String);

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        Self(error.to_string())
    }
}

impl From<TableError> for Failure {
    fn from(error: TableError) -> Self {
        Self(error.to_string())
    }
}

/// Writes the table in the place of what is at `path`; returns how many sessions are in it.
pub fn write(
    store: &Store,
    filter: &Filter,
    names: bool,
    format: Format,
    path: &Path,
) -> Result<usize, Problem> {
    if let Some(group) = &filter.group {
        store.must_be_group(group)?;
    }
    let groups: BTreeMap<_, _> = store
        .trainees(None)?
        .into_iter()
        .map(|listed| (listed.trainee.id, listed.groups.join(";")))
        .collect();
    let mut sessions = 0;
    replace_by(path, |file| {
        let write = || -> Result<(), Failure> {
            let sink = std::io::BufWriter::new(file);
            let mut table = TableWriter::new(format, &COLUMNS, sink)?;
            store.each_session(filter, true, |named| -> Result<(), Failure> {
                sessions += 1;
                let groups = named.session.trainee.and_then(|id| groups.get(&id));
                let groups = groups.map_or("", String::as_str);
                rows(&named, groups, names, &mut table)?;
                Ok(())
            })?;
            let written = table.finish()?.flush();
            written.map_err(|e| Failure(e.to_string()))
        };
        write().map_err(|Failure(why)| std::io::Error::other(why))
    })?;
    Ok(sessions)
}

fn rows<W: Write + Send>(
    named: &NamedSession,
    groups: &str,
    names: bool,
    table: &mut TableWriter<W>,
) -> Result<(), TableError> {
    let session = &named.session;
    let id = session.id.to_string();
    let trainee = session.trainee.map(|id| id.to_string());
    let started = date::iso(session.started);
    let seed = session.seed.to_string();
    let failed = session.failed.join(" ");
    let of_session = [
        Cell::Text(&id),
        trainee.as_deref().into(),
        named.name.as_deref().filter(|_| names).into(),
        Cell::Text(groups),
        Cell::Text(&session.module),
        Cell::Integer(session.level.into()),
        Cell::Text(&started),
        Cell::Integer(session.started),
        Cell::Text(&seed),
        Cell::Text(&session.input),
        Cell::Text(&session.version),
        session.synthetic.as_deref().into(),
        Cell::Text(session.verdict.name()),
        Cell::Flag(session.counts),
        Cell::Text(&failed),
        Cell::Real(session.duration),
        session.score.into(),
    ];
    let metrics: Vec<[Cell<'_>; METRIC_COLUMNS]> = match session.metrics.is_empty() {
        true => vec![[Cell::Empty; METRIC_COLUMNS]],
        false => session.metrics.iter().map(cells).collect(),
    };
    table.group(&of_session, metrics.iter().map(|row| &row[..]))
}

fn cells(measured: &Measured) -> [Cell<'_>; METRIC_COLUMNS] {
    let metric = &measured.metric;
    [
        Cell::Text(&metric.id),
        Cell::Text(&metric.title),
        Cell::Text(&metric.category),
        Cell::Text(&metric.direction),
        measured.value.into(),
        Cell::Text(&metric.unit),
        measured.min.into(),
        measured.max.into(),
        measured.decides.into(),
        measured.within.into(),
        measured.score.into(),
    ]
}
