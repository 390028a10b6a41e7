//! Tables for statistics: what stands in them is what the report of the session has.

use microsim_tests::report_beside;
use microsim_tests::stations::Station;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::fs;
use std::path::Path;

/// Rows of a Parquet file as texts, an empty one for what is not there; the header first.
fn rows_of_parquet(path: &Path) -> Vec<Vec<String>> {
    let bytes = bytes::Bytes::from(fs::read(path).expect("a file"));
    let reader = SerializedFileReader::new(bytes).expect("Parquet");
    let mut rows = Vec::new();
    for row in reader.get_row_iter(None).expect("rows") {
        let row = row.expect("a row");
        if rows.is_empty() {
            rows.push(
                row.get_column_iter()
                    .map(|(name, _)| name.clone())
                    .collect(),
            );
        }
        let cells = row.get_column_iter().map(|(_, field)| match field {
            Field::Null => String::new(),
            Field::Str(text) => text.clone(),
            Field::Double(value) => value.to_string(),
            Field::Long(value) => value.to_string(),
            Field::Bool(value) => value.to_string(),
            other => panic!("{other:?}"),
        });
        rows.push(cells.collect());
    }
    rows
}

fn rows_of_csv(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_path(path)
        .expect("a table");
    let rows = reader
        .records()
        .map(|row| row.expect("a row").iter().map(str::to_owned).collect());
    rows.collect()
}

/// Both formats hold the same, and that is what the report has.
#[test]
fn a_session_is_one_tidy_table() {
    let station = Station::new();
    let input = "script:level1-pass.toml";
    let mut run = station.command(&["run", "push-strip", "--json", "--input", input]);
    microsim_tests::finish(run.arg("--session").arg(station.session("1"))).expect(0);
    let session = station.session("1");
    let session = session.to_str().expect("text");
    let tables = ["series.csv", "series.parquet"].map(|name| station.folder().join(name));
    for table in &tables {
        station
            .microsim(&["report", session, "--table", table.to_str().expect("text")])
            .expect(0);
    }
    let (csv, parquet) = (rows_of_csv(&tables[0]), rows_of_parquet(&tables[1]));
    assert_eq!(csv, parquet);
    assert_eq!(
        csv[0],
        [
            "time_s", "source", "with", "part", "quantity", "unit", "value", "valid", "text"
        ]
    );
    let report = report_beside(Path::new(session));
    let samples: usize = report["series"]
        .as_array()
        .expect("tools")
        .iter()
        .map(|s| s["time"].as_array().map_or(0, Vec::len))
        .sum();
    let forces: usize = report["forces"]
        .as_array()
        .expect("forces")
        .iter()
        .map(|s| s["time"].as_array().map_or(0, Vec::len))
        .sum();
    let events = report["events"].as_array().map_or(0, Vec::len);
    assert!(
        samples > 100 && forces > 10 && events > 0,
        "{samples} {forces} {events}"
    );
    assert_eq!(csv.len() - 1, 4 * samples + 6 * forces + events);
    let value = report["series"][0]["position"][7][1].as_f64();
    let row = csv
        .iter()
        .skip(1)
        .filter(|r| r[4] == "y")
        .nth(7)
        .expect("a row");
    assert_eq!(row[6].parse::<f64>().ok(), value);
    assert_eq!(
        row[0].parse::<f64>().ok(),
        report["series"][0]["time"][7].as_f64()
    );
    let peak = report["forces"][0]["peak"][3].as_f64();
    let row = csv
        .iter()
        .filter(|r| r[4] == "peak-force")
        .nth(3)
        .expect("a row");
    assert_eq!(row[6].parse::<f64>().ok(), peak);
}

#[test]
fn results_are_the_same_in_both_formats() {
    let station = Station::new();
    station.add("=A. Muster");
    station
        .run("1", "pass", &["--trainee", "=A. Muster"])
        .output()
        .expect("a run");
    station
        .run("2", "fail-too-slow", &[])
        .output()
        .expect("a run");
    let tables = ["results.csv", "results.parquet"].map(|name| station.folder().join(name));
    for table in &tables {
        station
            .microsim(&["results", "--export", table.to_str().expect("text")])
            .expect(0);
    }
    let (mut csv, parquet) = (rows_of_csv(&tables[0]), rows_of_parquet(&tables[1]));
    let named = |row: &&Vec<String>| row[2] == "=A. Muster";
    assert!(parquet.iter().any(|row| named(&row)));
    assert!(csv.iter().any(|row| row[2] == "'=A. Muster") && !csv.iter().any(|row| named(&row)));
    for row in &mut csv {
        for cell in row {
            if let Some(text) = cell.strip_prefix('\'') {
                *cell = text.to_owned();
            }
        }
    }
    assert_eq!(csv, parquet);
    let wrong = station
        .microsim(&["results", "--export", "results.xlsx"])
        .expect(2);
    assert!(wrong.err.contains(".csv or .parquet"), "{}", wrong.err);
}
