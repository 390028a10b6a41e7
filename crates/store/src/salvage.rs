//! Reading tables row by row, also where some rows cannot be read: a range of keys that fails is halved until what fails is a single key.

use rusqlite::{Connection, Row};

/// Failing reads after which a table is given up, as most of it is gone.
const FAILURES: u32 = 100_000;

/// Largest key that is looked for where the largest one cannot be read.
const LARGEST: i64 = 1 << 24;

/// Rows of a table, and how many keys were lost.
pub(crate) struct Salvaged<T> {
    pub rows: Vec<T>,
    pub lost: Lost,
}

/// What of a table cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lost {
    Nothing,
    /// So many keys; some may never have had a row.
    Keys(u32),
    /// All, or so much that the rest was not looked for.
    Most,
}

/// Reads a table by ranges of `key`, an integer that its rows lie in the order of.
pub(crate) fn read<T>(
    connection: &Connection,
    table: &str,
    key: &str,
    columns: &str,
    read: &mut dyn FnMut(&Row<'_>) -> rusqlite::Result<T>,
) -> Salvaged<T> {
    let bound = |which: &str| {
        let sql = format!("SELECT coalesce({which}({key}), 0) FROM {table}");
        connection.query_row(&sql, [], |row| row.get::<_, i64>(0))
    };
    let (first, last) = (bound("min").unwrap_or(0), bound("max").unwrap_or(LARGEST));
    let sql = format!(
        "SELECT {columns} FROM {table} NOT INDEXED WHERE {key} BETWEEN ?1 AND ?2 ORDER BY {key}"
    );
    let mut rows = Vec::new();
    let mut failures = 0;
    let mut lost = 0;
    let mut open = vec![(first, last)];
    while let Some((from, to)) = open.pop() {
        let before = rows.len();
        let mut range = || -> rusqlite::Result<()> {
            let mut statement = connection.prepare_cached(&sql)?;
            let mut found = statement.query([from, to])?;
            while let Some(row) = found.next()? {
                rows.push(read(row)?);
            }
            Ok(())
        };
        if range().is_ok() {
            continue;
        }
        failures += 1;
        if failures > FAILURES {
            rows.truncate(before);
            return Salvaged {
                rows,
                lost: Lost::Most,
            };
        }
        if from == to {
            // What stands in one row together is read together.
            lost += 1;
            continue;
        }
        rows.truncate(before);
        let middle = from + (to - from) / 2;
        open.push((middle + 1, to));
        open.push((from, middle));
    }
    Salvaged {
        rows,
        lost: match lost {
            0 => Lost::Nothing,
            n => Lost::Keys(n),
        },
    }
}
