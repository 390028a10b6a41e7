//! The table of runs as a file of comma-separated values. Each run is added when it ends, so that a study goes on where an earlier one was stopped.

use super::{Key, Outcome, Runs, header, line, read, run};
use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The runs in a file, and the file.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    file: File,
    /// Ids of metrics, in the order of columns.
    metrics: Vec<String>,
    rows: Runs,
}

impl Table {
    /// Opens a table, or begins one.
    ///
    /// # Errors
    /// Where it has other metrics, or lines that are none of it.
    pub fn open(path: &Path, metrics: Vec<String>) -> Result<Self, String> {
        let at = |error: std::io::Error| format!("{}: {error}", path.display());
        let found = read(path)?;
        let is_new = found.is_none();
        let (columns, rows) = found.unwrap_or_else(|| (metrics.clone(), Runs::new()));
        if columns != metrics {
            return Err(format!(
                "{}: the table has other columns; remove it to begin one",
                path.display()
            ));
        }
        fs::create_dir_all(path.parent().unwrap_or(path)).map_err(at)?;
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(path)
            .map_err(at)?;
        if is_new {
            writeln!(file, "{}", header(&metrics)).map_err(at)?;
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            metrics,
            rows,
        })
    }

    /// Whether a run is there.
    pub fn has(&self, key: &Key) -> bool {
        self.rows.contains_key(key)
    }

    /// All runs that are there.
    pub fn runs(&self) -> &Runs {
        &self.rows
    }

    /// Adds a run.
    ///
    /// # Errors
    /// Where the table has another outcome of it: the computation is not that of the rows that are there.
    pub fn add(&mut self, key: Key, outcome: &Outcome) -> Result<(), String> {
        let line = line(&key, outcome, &self.metrics);
        let written = run(&line, &self.metrics).map(|(_, written)| written);
        let written = written.ok_or_else(|| format!("no line of a table: {line}"))?;
        let path = self.path.display();
        match self.rows.get(&key) {
            Some(there) if *there == written => return Ok(()),
            Some(_) => {
                let (kind, seed, level) = key;
                return Err(format!(
                    "{path}: {kind} {seed}, {level}: the run has another outcome than the table, which is of another computation; remove it to begin one"
                ));
            }
            None => {}
        }
        writeln!(self.file, "{line}").map_err(|error| format!("{path}: {error}"))?;
        self.rows.insert(key, written);
        Ok(())
    }

    /// Writes the runs in their order, in whatever order they ended.
    ///
    /// # Errors
    /// The file that cannot be written.
    pub fn sort(&self) -> Result<(), String> {
        let mut text = header(&self.metrics) + "\n";
        for (key, outcome) in &self.rows {
            let _ = writeln!(text, "{}", line(key, outcome, &self.metrics));
        }
        fs::write(&self.path, text).map_err(|error| format!("{}: {error}", self.path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(verdict: &str, value: f64) -> Outcome {
        Outcome {
            verdict: verdict.to_owned(),
            failed: "torn too-slow".to_owned(),
            values: [("time".to_owned(), value)].into(),
        }
    }

    /// A study that was stopped goes on: what has ended is there, in whatever order; a half line is an error, and so is the outcome of another
    /// computation.
    #[test]
    fn a_table_goes_on_where_it_was_stopped() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("new/table.csv");
        let metrics = || vec!["time".to_owned(), "torn".to_owned()];
        let key = |seed| ("novice".to_owned(), seed, "half the tick".to_owned());
        let mut table = Table::open(&path, metrics()).expect("a table");
        table.add(key(2), &outcome("failed", 1.5)).expect("added");
        table.add(key(1), &outcome("passed", 0.25)).expect("added");
        drop(table);
        let mut table = Table::open(&path, metrics()).expect("a table");
        assert!(table.has(&key(1)) && table.has(&key(2)) && !table.has(&key(3)));
        assert_eq!(table.runs()[&key(1)], outcome("passed", 0.25));
        table
            .add(key(2), &outcome("failed", 1.5))
            .expect("the same");
        let error = table.add(key(2), &outcome("failed", 1.6));
        assert!(error.expect_err("another").contains("another computation"));
        table.sort().expect("written");
        let text = "kind,seed,level,verdict,failed,time,torn\n\
            novice,1,half the tick,passed,torn too-slow,0.25000,\n\
            novice,2,half the tick,failed,torn too-slow,1.50000,\n";
        assert_eq!(fs::read_to_string(&path).expect("the table"), text);
        assert!(Table::open(&path, vec!["time".to_owned()]).is_err());
        fs::write(&path, &text[..text.len() - 9]).expect("written");
        let error = Table::open(&path, metrics()).expect_err("half a line");
        assert!(error.contains("line 3"), "{error}");
    }
}
