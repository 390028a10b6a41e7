//! Populations as CSV: a row for each metric of a level, with mean and standard deviation, percentiles, or both.

use microsim_store::PopulationRecord;

/// Columns that have to be there.
const NEEDED: [&str; 7] = ["module", "level", "metric", "source", "n", "mean", "sd"];

/// Reads a table; an error begins with the line, as in `:3: …`.
pub fn read_populations(bytes: &[u8]) -> Result<Vec<PopulationRecord>, String> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let header = reader.headers().map_err(|e| format!(": {e}"))?.clone();
    let at = |name: &str| header.iter().position(|column| column == name);
    let mut places = [0; NEEDED.len()];
    for (place, name) in places.iter_mut().zip(NEEDED) {
        *place = at(name).ok_or_else(|| {
            format!(
                ":1: no column `{name}`; expected {}, and percentiles such as p10",
                NEEDED.join(", ")
            )
        })?;
    }
    let mut percentiles = Vec::new();
    for (column, name) in header
        .iter()
        .enumerate()
        .filter(|(column, _)| !places.contains(column))
    {
        let percent = name.strip_prefix('p').and_then(|p| p.parse::<f64>().ok());
        match percent.filter(|percent| (0.0..=100.0).contains(percent)) {
            Some(percent) => percentiles.push((percent, column)),
            None => {
                return Err(format!(
                    ":1: column `{name}`; expected {}, or a percentile from p0 to p100",
                    NEEDED.join(", ")
                ));
            }
        }
    }
    percentiles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut records = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|e| format!(": {e}"))?;
        let line = row.position().map_or(0, csv::Position::line);
        let cell = |column: usize| row.get(column).unwrap_or_default();
        let wrong = |name: &str, column: usize, expected: &str| {
            format!(
                ":{line}: column `{name}`: found \"{}\", expected {expected}",
                cell(column)
            )
        };
        let number = |name: &str, column: usize| -> Result<Option<f64>, String> {
            match cell(column) {
                "" => Ok(None),
                text => match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(Some(value)),
                    _ => Err(wrong(name, column, "a number, or nothing")),
                },
            }
        };
        let [module, level, metric, source, n, mean, deviation] = places;
        let text = |name: &str, column: usize| match cell(column) {
            "" => Err(wrong(name, column, "a text")),
            text => Ok(text.to_owned()),
        };
        let whole = |name: &str, column: usize| {
            cell(column)
                .parse::<u32>()
                .map_err(|_| wrong(name, column, "a whole number"))
        };
        let mut values = Vec::new();
        for (percent, column) in &percentiles {
            if let Some(value) = number(&format!("p{percent}"), *column)? {
                values.push((*percent, value));
            }
        }
        let record = PopulationRecord {
            module: text("module", module)?,
            level: whole("level", level)?,
            metric: text("metric", metric)?,
            source: text("source", source)?,
            n: whole("n", n)?,
            mean: number("mean", mean)?,
            deviation: number("sd", deviation)?,
            percentiles: values,
        };
        if let Err(expected) = record.population() {
            return Err(format!(":{line}: expected {expected}"));
        }
        records.push(record);
    }
    Ok(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_and_percentiles_are_read() {
        let text = "module,level,metric,source,n,mean,sd,p90,p10\n\
                    touch-spheres,1,time,\"experts, 2025\",12,30,4.5,,\n\
                    touch-spheres,1,path-length,experts,12,,,0.9,0.3\n";
        let records = read_populations(text.as_bytes()).expect("a table");
        assert_eq!(records.len(), 2);
        assert_eq!(
            (records[0].mean, records[0].deviation),
            (Some(30.0), Some(4.5))
        );
        assert_eq!(records[0].source, "experts, 2025");
        assert_eq!(records[1].percentiles, [(10.0, 0.3), (90.0, 0.9)]);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let head = "module,level,metric,source,n,mean,sd,p10\n";
        for (text, expected) in [
            ("module,level\n".to_owned(), ":1: no column `metric`"),
            (head.replace("p10", "q10"), ":1: column `q10`"),
            (
                format!("{head}a,1,time,x,3,1,0.5,\na,one,time,x,3,1,0.5,\n"),
                ":3: column `level`: found \"one\"",
            ),
            (
                format!("{head}a,1,time,x,3,nan,0.5,\n"),
                ":2: column `mean`",
            ),
            (
                format!("{head}a,1,time,x,3,1,0,\n"),
                ":2: expected a standard deviation above 0",
            ),
            (
                format!("{head}a,1,time,x,3,,,\n"),
                ":2: expected at least two percentiles",
            ),
            (format!("{head}a,1,time,,3,1,1,\n"), ":2: column `source`"),
        ] {
            let error = read_populations(text.as_bytes())
                .map(drop)
                .expect_err(&text);
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
