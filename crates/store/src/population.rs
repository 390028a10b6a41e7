//! Populations that others have measured, to which values are compared.

use crate::error::{StoreError, refuse};
use crate::store::Store;
use microsim_training::Population;
use rusqlite::{Connection, params};
use serde::{Deserialize, Serialize};

/// The distribution of a metric of a level in a population.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PopulationRecord {
    /// Module.
    pub module: String,
    /// Level.
    pub level: u32,
    /// Id of the metric; numbers are in its SI unit.
    pub metric: String,
    /// Who was measured, and where that stands.
    pub source: String,
    /// How many.
    pub n: u32,
    /// Mean.
    pub mean: Option<f64>,
    /// Standard deviation.
    pub deviation: Option<f64>,
    /// Percent of the population and the value up to which it lies.
    pub percentiles: Vec<(f64, f64)>,
}

impl PopulationRecord {
    /// The distribution.
    ///
    /// # Errors
    /// What is expected instead, in words.
    pub fn population(&self) -> Result<Population, &'static str> {
        let moments = self.mean.zip(self.deviation);
        Population::new(moments, self.percentiles.clone())
    }
}

pub(crate) fn put(connection: &Connection, record: &PopulationRecord) -> Result<(), StoreError> {
    if let Err(expected) = record.population() {
        return refuse(format!(
            "the population of {} (level {}, {}, \"{}\"): expected {expected}",
            record.module, record.level, record.metric, record.source
        ));
    }
    let key: i64 = connection.query_row(
        "INSERT INTO population (module, level, metric, source, n, mean, deviation) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)
        ON CONFLICT (module, level, metric, source) DO UPDATE SET n = ?5, mean = ?6, deviation = ?7 RETURNING key",
        params![record.module, record.level, record.metric, record.source, record.n, record.mean, record.deviation],
        |row| row.get(0),
    )?;
    connection.execute(
        "DELETE FROM population_percentile WHERE population = ?1",
        [key],
    )?;
    for (percent, value) in &record.percentiles {
        connection.execute(
            "INSERT INTO population_percentile VALUES (?1, ?2, ?3)",
            params![key, percent, value],
        )?;
    }
    Ok(())
}

impl Store {
    /// Puts populations in the place of those of the same level, metric and source, all or none.
    ///
    /// # Errors
    /// Numbers that are no distribution, and those of the database.
    pub fn put_populations(&mut self, records: &[PopulationRecord]) -> Result<(), StoreError> {
        let transaction = self.write()?;
        for record in records {
            put(&transaction, record)?;
        }
        Ok(transaction.commit()?)
    }

    /// All populations, or those of a level.
    ///
    /// # Errors
    /// Those of the database.
    pub fn populations(
        &self,
        of: Option<(&str, u32)>,
    ) -> Result<Vec<PopulationRecord>, StoreError> {
        let mut statement = self.connection.prepare(
            "SELECT key, module, level, metric, source, n, mean, deviation FROM population
            WHERE ?1 IS NULL OR (module = ?1 AND level = ?2) ORDER BY module, level, metric, source",
        )?;
        let mut percentiles = self.connection.prepare(
            "SELECT percent, value FROM population_percentile WHERE population = ?1 ORDER BY percent",
        )?;
        let of = of.unzip();
        let rows = statement.query_map(params![of.0, of.1], |row| {
            let key: i64 = row.get(0)?;
            let rows = percentiles.query_map([key], |row| Ok((row.get(0)?, row.get(1)?)))?;
            Ok(PopulationRecord {
                module: row.get(1)?,
                level: row.get(2)?,
                metric: row.get(3)?,
                source: row.get(4)?,
                n: row.get(5)?,
                mean: row.get(6)?,
                deviation: row.get(7)?,
                percentiles: rows.collect::<rusqlite::Result<_>>()?,
            })
        })?;
        Ok(rows.collect::<rusqlite::Result<_>>()?)
    }
}
