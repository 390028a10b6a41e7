//! One measured run, how the scripts print it, and the table of all of them as CSV.

use serde_json::Value;
use std::fmt::Write as _;

/// One run; what was not measured is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Name of the engine.
    pub engine: String,
    /// Empty where nothing was run.
    pub version: String,
    pub method: String,
    /// S, M, L, or `own` where an engine does not use the tetrahedra.
    pub mesh: String,
    /// \[s\]
    pub step: f64,
    /// Whether the first peak was asked for, and coming to rest.
    pub asks: [bool; 2],
    /// CPU time per simulated time, from release until the first peak is over.
    pub cpu_s_per_s: Option<f64>,
    /// Height of the first peak against the exact one of the same mesh and material, relative to it.
    pub peak_error: Option<f64>,
    /// The same of its time.
    pub peak_time_error: Option<f64>,
    /// CPU time from release until the sag is at rest \[s\].
    pub cpu_s_to_rest: Option<f64>,
    /// The sag in the end against the exact one, relative to it.
    pub rest_error: Option<f64>,
    pub settings: String,
    pub note: String,
}

impl Row {
    /// A run that a script lists, and why it is left out unless everything is asked for.
    pub fn planned(engine: &str, line: &str) -> Result<(Self, Option<String>), String> {
        let run = object(line)?;
        let step = number(&run, "step")?.filter(|step| *step > 0.0);
        let asks = match &run["measures"] {
            Value::Array(asked) => ["peak", "rest"].map(|name| asked.contains(&name.into())),
            _ => [false; 2],
        };
        if asks == [false; 2] {
            return Err("\"measures\" names neither peak nor rest".into());
        }
        let row = Self {
            engine: engine.into(),
            method: text(&run, "method")?.ok_or("\"method\" is missing")?,
            mesh: text(&run, "mesh")?.ok_or("\"mesh\" is missing")?,
            step: step.ok_or("\"step\" is not above zero")?,
            asks,
            settings: text(&run, "settings")?.unwrap_or_default(),
            ..Self::default()
        };
        Ok((row, text(&run, "slow")?))
    }

    /// Takes what a script has measured.
    pub fn fill(&mut self, line: &str) -> Result<(), String> {
        let result = object(line)?;
        self.version = text(&result, "version")?.unwrap_or_default();
        self.note = text(&result, "note")?.unwrap_or_default();
        self.cpu_s_per_s = number(&result, "cpu_s_per_s")?;
        self.peak_error = number(&result, "peak_error")?;
        self.peak_time_error = number(&result, "peak_time_error")?;
        self.cpu_s_to_rest = number(&result, "cpu_s_to_rest")?;
        self.rest_error = number(&result, "rest_error")?;
        if self.note.is_empty() && self.cpu_s_per_s.or(self.cpu_s_to_rest).is_none() {
            return Err("it holds neither a measure nor a reason".into());
        }
        Ok(())
    }

    /// The larger one of the two errors of the peak.
    pub fn peak(&self) -> Option<f64> {
        Some(self.peak_error?.abs().max(self.peak_time_error?.abs()))
    }
}

fn object(line: &str) -> Result<Value, String> {
    let value: Value = serde_json::from_str(line).map_err(|e| format!("no JSON: {e}"))?;
    Some(value)
        .filter(Value::is_object)
        .ok_or("no JSON object".into())
}

fn number(object: &Value, key: &str) -> Result<Option<f64>, String> {
    match &object[key] {
        Value::Null => Ok(None),
        value => Ok(Some(
            value
                .as_f64()
                .ok_or_else(|| format!("\"{key}\" is not a number"))?,
        )),
    }
}

fn text(object: &Value, key: &str) -> Result<Option<String>, String> {
    match &object[key] {
        Value::Null => Ok(None),
        Value::String(text) => Ok(Some(text.clone())),
        _ => Err(format!("\"{key}\" is not a text")),
    }
}

/// All rows as CSV.
pub fn csv(rows: &[Row]) -> String {
    let mut table = String::from(
        "engine,version,method,mesh,step,cpu_s_per_s,peak_error,peak_time_error,cpu_s_to_rest,rest_error,settings,note\n",
    );
    let number = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.5e}"));
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    for row in rows {
        let _ = writeln!(
            table,
            "{},{},{},{},{},{},{},{},{},{},{},{}",
            row.engine,
            row.version,
            quoted(&row.method),
            row.mesh,
            // Steps are given in whole microseconds.
            (row.step * 1e6).round() / 1e6,
            number(row.cpu_s_per_s),
            number(row.peak_error),
            number(row.peak_time_error),
            number(row.cpu_s_to_rest),
            number(row.rest_error),
            quoted(&row.settings),
            quoted(&row.note)
        );
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: &str =
        r#"{"method": "a, b", "mesh": "S", "step": 0.002, "measures": ["peak"], "slow": null}"#;

    #[test]
    fn a_run_goes_from_its_plan_to_the_table() {
        let (mut row, slow) = Row::planned("E", PLAN).unwrap();
        assert_eq!((row.asks, slow), ([true, false], None));
        row.fill(r#"{"version": "1", "cpu_s_per_s": 0.25, "peak_error": -0.5, "peak_time_error": 0.125}"#)
            .unwrap();
        assert_eq!(row.peak(), Some(0.5));
        row.note = "a \"note\"".into();
        let lines = csv(&[row]);
        assert_eq!(
            lines.lines().nth(1),
            Some(r#"E,1,"a, b",S,0.002,2.50000e-1,-5.00000e-1,1.25000e-1,,,"","a ""note""""#)
        );
    }

    #[test]
    fn bad_lines_are_told_by_what_is_wrong_with_them() {
        let plan = |from: &str, to: &str| {
            assert!(PLAN.contains(from));
            Row::planned("E", &PLAN.replace(from, to)).unwrap_err()
        };
        assert_eq!(plan("0.002", "0"), "\"step\" is not above zero");
        assert_eq!(plan("0.002", "\"2 ms\""), "\"step\" is not a number");
        assert_eq!(plan("\"method\"", "\"name\""), "\"method\" is missing");
        assert_eq!(plan("null", "7"), "\"slow\" is not a text");
        assert_eq!(
            plan("\"peak\"", "\"top\""),
            "\"measures\" names neither peak nor rest"
        );
        assert!(plan("}", "").starts_with("no JSON: "));

        let filled = |line: &str| Row::default().fill(line).unwrap_err();
        assert_eq!(filled("[]"), "no JSON object");
        // Python writes what is not finite so.
        assert!(filled(r#"{"cpu_s_per_s": NaN}"#).starts_with("no JSON: "));
        assert_eq!(
            filled(r#"{"cpu_s_per_s": "fast"}"#),
            "\"cpu_s_per_s\" is not a number"
        );
        assert_eq!(
            filled(r#"{"version": "1"}"#),
            "it holds neither a measure nor a reason"
        );
        assert_eq!(Row::default().fill(r#"{"note": "comes apart"}"#), Ok(()));
    }
}
