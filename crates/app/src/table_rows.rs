//! Tables in CSV as rows of JSON: what the file has, for programs that read standard output.

use crate::output::Problem;
use serde_json::{Map, Value, json};

/// One object a row, by the names of the columns: numbers as numbers, empty cells as null.
pub fn table_rows(csv: &str) -> Result<Vec<Value>, Problem> {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let names = reader.headers()?.clone();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let cells = names.iter().zip(record.iter());
        let row: Map<String, Value> = cells
            .map(|(name, cell)| (name.to_owned(), value(cell)))
            .collect();
        rows.push(Value::Object(row));
    }
    Ok(rows)
}

fn value(cell: &str) -> Value {
    match cell.parse::<f64>() {
        _ if cell.is_empty() => Value::Null,
        Ok(number) if number.is_finite() => json!(number),
        _ => cell.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::table_rows;
    use serde_json::json;

    #[test]
    fn cells_are_numbers_texts_or_nothing() {
        let rows = table_rows("name,step_s,reason\n\"a, b\",1e-3,\nc,inf,2x\n").expect("a table");
        let expected = vec![
            json!({ "name": "a, b", "step_s": 0.001, "reason": null }),
            json!({ "name": "c", "step_s": "inf", "reason": "2x" }),
        ];
        assert_eq!(rows, expected);
    }
}
