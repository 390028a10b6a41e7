//! The tables, and how older ones become those of today.

use crate::error::StoreError;
use rusqlite::{Connection, TransactionBehavior};

/// `application_id` of the file: `MSIM`.
pub(crate) const APPLICATION: i64 = 0x4d53_494d;

/// One step from a version to the next: the SQL of index n makes version n + 1.
pub(crate) const MIGRATIONS: &[&str] = &[VERSION_1, VERSION_2];

/// Version of the tables that this program writes.
pub const VERSION: i64 = MIGRATIONS.len() as i64;

const VERSION_1: &str = "
CREATE TABLE trainee (
    key INTEGER PRIMARY KEY,
    id TEXT NOT NULL UNIQUE,
    -- NULL: anonymous.
    name TEXT UNIQUE,
    role TEXT NOT NULL DEFAULT 'trainee' CHECK (role IN ('operator', 'instructor', 'trainee')),
    created INTEGER NOT NULL
) STRICT;
CREATE TABLE trainee_group (
    key INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE
) STRICT;
CREATE TABLE membership (
    trainee_group INTEGER NOT NULL REFERENCES trainee_group (key) ON DELETE CASCADE,
    trainee INTEGER NOT NULL REFERENCES trainee (key) ON DELETE CASCADE,
    PRIMARY KEY (trainee_group, trainee)
) STRICT, WITHOUT ROWID;
CREATE TABLE course (
    key INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE,
    title_en TEXT NOT NULL,
    title_de TEXT NOT NULL,
    in_order INTEGER NOT NULL CHECK (in_order IN (0, 1))
) STRICT;
CREATE TABLE course_step (
    course INTEGER NOT NULL REFERENCES course (key) ON DELETE CASCADE,
    position INTEGER NOT NULL,
    module TEXT NOT NULL,
    level INTEGER NOT NULL,
    -- In a row, after which the level is mastered.
    passes INTEGER NOT NULL,
    PRIMARY KEY (course, position),
    UNIQUE (course, module, level)
) STRICT, WITHOUT ROWID;
CREATE TABLE enrolment (
    course INTEGER NOT NULL REFERENCES course (key) ON DELETE CASCADE,
    trainee INTEGER REFERENCES trainee (key) ON DELETE CASCADE,
    trainee_group INTEGER REFERENCES trainee_group (key) ON DELETE CASCADE,
    CHECK ((trainee IS NULL) <> (trainee_group IS NULL)),
    UNIQUE (course, trainee),
    UNIQUE (course, trainee_group)
) STRICT;
-- Levels that were opened by hand.
CREATE TABLE unlocked (
    course INTEGER NOT NULL REFERENCES course (key) ON DELETE CASCADE,
    trainee INTEGER NOT NULL REFERENCES trainee (key) ON DELETE CASCADE,
    module TEXT NOT NULL,
    level INTEGER NOT NULL,
    PRIMARY KEY (course, trainee, module, level)
) STRICT, WITHOUT ROWID;
-- A session and the result of its run: one row, as there is one of each.
CREATE TABLE session (
    key INTEGER PRIMARY KEY,
    id TEXT NOT NULL UNIQUE,
    path TEXT NOT NULL,
    trainee INTEGER REFERENCES trainee (key),
    module TEXT NOT NULL,
    level INTEGER NOT NULL,
    -- Wall clock, seconds since 1970.
    started INTEGER NOT NULL,
    -- Simulated time of all ticks, seconds.
    simulated REAL NOT NULL,
    -- 1: the session was closed; 0: its process was killed.
    finished INTEGER NOT NULL,
    -- As text: 64 bits without a sign.
    seed TEXT NOT NULL,
    input TEXT NOT NULL,
    version TEXT NOT NULL,
    realtime INTEGER NOT NULL,
    -- By what a synthetic trainee was made.
    synthetic TEXT,
    state_hash TEXT,
    verdict TEXT NOT NULL,
    -- Whether it counts as a result.
    counts INTEGER NOT NULL,
    -- Ids of the reasons, one a line.
    failed TEXT NOT NULL,
    -- Running time of the level, seconds.
    duration REAL NOT NULL,
    targets_done INTEGER NOT NULL,
    targets INTEGER NOT NULL,
    score REAL
) STRICT;
CREATE INDEX session_of_trainee ON session (trainee, started);
CREATE INDEX session_of_level ON session (module, level, started);
CREATE TABLE category_score (
    session INTEGER NOT NULL REFERENCES session (key) ON DELETE CASCADE,
    category TEXT NOT NULL,
    score REAL NOT NULL,
    PRIMARY KEY (session, category)
) STRICT, WITHOUT ROWID;
CREATE TABLE metric (
    key INTEGER PRIMARY KEY,
    id TEXT NOT NULL,
    title TEXT NOT NULL,
    -- SI unit of values and limits; a value times display_factor is in display_unit.
    unit TEXT NOT NULL,
    display_unit TEXT NOT NULL,
    display_factor REAL NOT NULL,
    direction TEXT NOT NULL,
    category TEXT NOT NULL,
    formula TEXT NOT NULL,
    UNIQUE (id, title, unit, display_unit, display_factor, direction, category, formula)
) STRICT;
CREATE TABLE metric_value (
    session INTEGER NOT NULL REFERENCES session (key) ON DELETE CASCADE,
    metric INTEGER NOT NULL REFERENCES metric (key),
    -- NULL: not applicable.
    value REAL,
    limit_min REAL,
    limit_max REAL,
    -- Whether the limit decides on a pass.
    decides INTEGER,
    within INTEGER,
    score REAL,
    PRIMARY KEY (session, metric)
) STRICT, WITHOUT ROWID;
-- Files that belong to a session and do not lie beside it: pictures, checkpoints, reports written elsewhere.
CREATE TABLE session_file (
    session INTEGER NOT NULL REFERENCES session (key) ON DELETE CASCADE,
    path TEXT NOT NULL,
    PRIMARY KEY (session, path)
) STRICT, WITHOUT ROWID;
-- Runs that have begun and are not entered yet.
CREATE TABLE pending (
    path TEXT PRIMARY KEY,
    process INTEGER NOT NULL,
    -- When that process began, in the units of its system; with its number it is that process alone.
    process_started INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE TABLE population (
    key INTEGER PRIMARY KEY,
    module TEXT NOT NULL,
    level INTEGER NOT NULL,
    metric TEXT NOT NULL,
    source TEXT NOT NULL,
    n INTEGER NOT NULL,
    mean REAL,
    deviation REAL,
    UNIQUE (module, level, metric, source)
) STRICT;
CREATE TABLE population_percentile (
    population INTEGER NOT NULL REFERENCES population (key) ON DELETE CASCADE,
    percent REAL NOT NULL,
    value REAL NOT NULL,
    PRIMARY KEY (population, percent)
) STRICT, WITHOUT ROWID;
-- Neither id nor name.
CREATE TABLE erasure (
    key INTEGER PRIMARY KEY,
    time INTEGER NOT NULL,
    what TEXT NOT NULL CHECK (what IN ('erased', 'anonymised')),
    sessions INTEGER NOT NULL,
    files INTEGER NOT NULL
) STRICT;
-- One row for each metric of each session, with names: what programs that read this file directly need most.
CREATE VIEW result AS
SELECT session.id AS session, trainee.id AS trainee, trainee.name AS name, session.module, session.level, session.started,
    session.synthetic, session.verdict, session.counts, session.score AS session_score, session.duration,
    metric.id AS metric, metric.unit, metric_value.value, metric_value.limit_min, metric_value.limit_max,
    metric_value.within, metric_value.score
FROM session
LEFT JOIN trainee ON trainee.key = session.trainee
LEFT JOIN metric_value ON metric_value.session = session.key
LEFT JOIN metric ON metric.key = metric_value.metric;
";

/// Runs that began within one second have an order.
const VERSION_2: &str =
    "ALTER TABLE session ADD COLUMN started_subsec_ns INTEGER NOT NULL DEFAULT 0;";

/// What makes a file of version n + 1 readable as one of the last version without a change of it, by index n: views of the connection's
/// own, which stand before tables of the same name.
pub(crate) const VIEWS_OF_EARLIER: [&str; VERSION as usize - 1] =
    ["CREATE TEMP VIEW session AS SELECT *, 0 AS started_subsec_ns FROM main.session;"];

/// Version of the tables of a file; 0 for an empty one.
pub(crate) fn version(connection: &Connection) -> Result<i64, StoreError> {
    Ok(connection.query_row("PRAGMA user_version", [], |row| row.get(0))?)
}

/// Refuses what is no store, and what is of a later version.
pub(crate) fn check(connection: &Connection, known: i64) -> Result<i64, StoreError> {
    // One statement reads one state of the file: another process may be making the tables.
    let (found, application, tables): (i64, i64, i64) = connection.query_row(
        "SELECT user_version, application_id, (SELECT count(*) FROM sqlite_schema) FROM pragma_user_version, pragma_application_id",
        [],
        |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)),
    )?;
    if application != APPLICATION && tables > 0 {
        return Err(StoreError::CannotOpen(
            "it is a database of another program".into(),
        ));
    }
    match found > known {
        true => Err(StoreError::Newer { found, known }),
        false => Ok(found),
    }
}

/// Brings the tables to the last version, in one transaction.
pub(crate) fn migrate(connection: &mut Connection, steps: &[&str]) -> Result<(), StoreError> {
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    // Another process may have done it meanwhile.
    let found = check(&transaction, steps.len() as i64)?;
    for step in &steps[found as usize..] {
        transaction.execute_batch(step)?;
    }
    transaction.pragma_update(None, "application_id", APPLICATION)?;
    transaction.pragma_update(None, "user_version", steps.len() as i64)?;
    Ok(transaction.commit()?)
}
