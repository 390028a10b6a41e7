//! The report as tables: CSV with a header, a comma between fields, a point in numbers, SI units in the names of columns.

use crate::Report;
use std::borrow::Cow;

impl Report {
    /// One row for each metric; value and limits in the SI unit of the row, and once more in the unit that people read. In each row
    /// of both tables `synthetic` names what made a synthetic trainee; it is empty for people.
    pub fn metrics_csv(&self) -> String {
        let mut table = Table::new(&[
            "id",
            "title_en",
            "title_de",
            "category",
            "direction",
            "value",
            "unit",
            "min",
            "max",
            "display_value",
            "display_unit",
            "display_min",
            "display_max",
            "within",
            "score",
            "provisional",
            "decides",
            "limit_source",
            "formula",
            "source",
            "not_applicable_en",
            "not_applicable_de",
            "advice_en",
            "advice_de",
            "synthetic",
        ]);
        for metric in &self.metrics {
            let record = &metric.record;
            let limit = record.limit.as_ref();
            let none = record.not_applicable.as_ref();
            table.row(&[
                record.id.clone(),
                record.title.en.to_string(),
                record.title.de.to_string(),
                record.category.clone(),
                record.direction.clone(),
                cell(record.value),
                record.unit.clone(),
                cell(limit.and_then(|limit| limit.min)),
                cell(limit.and_then(|limit| limit.max)),
                cell(metric.display_value),
                record.display_unit.clone(),
                cell(metric.display_min),
                cell(metric.display_max),
                cell(record.within),
                cell(record.score),
                cell(limit.map(|limit| limit.provisional)),
                cell(limit.map(|limit| limit.decides)),
                cell(limit.map(|limit| &limit.source)),
                record.formula.clone(),
                record.source.clone(),
                cell(none.map(|text| &text.en)),
                cell(none.map(|text| &text.de)),
                record.advice.en.to_string(),
                record.advice.de.to_string(),
                cell(self.session.synthetic.as_ref()),
            ]);
        }
        table.finish()
    }

    /// All series in full, one row for each sample. `series` is `motion` (tool, position, speed; `part` is the segment) or
    /// `force` (tool, body, force, peak, depth, indentation, sustained force; `part` is the contact); columns of the other one are empty.
    pub fn series_csv(&self) -> String {
        let mut table = Table::new(&[
            "series",
            "tool",
            "body",
            "time_s",
            "part",
            "x_m",
            "y_m",
            "z_m",
            "speed_m_per_s",
            "force_n",
            "peak_n",
            "depth_m",
            "indentation_m",
            "sustained_n",
            "synthetic",
        ]);
        let empty = String::new;
        for motion in &self.series {
            for (k, [x, y, z]) in motion.position.iter().enumerate() {
                table.row(&[
                    "motion".into(),
                    motion.tool.clone(),
                    empty(),
                    motion.time[k].to_string(),
                    motion.segment[k].to_string(),
                    x.to_string(),
                    y.to_string(),
                    z.to_string(),
                    cell(motion.speed[k]),
                    empty(),
                    empty(),
                    empty(),
                    empty(),
                    empty(),
                    cell(self.session.synthetic.as_ref()),
                ]);
            }
        }
        for force in &self.forces {
            for (k, magnitude) in force.force.iter().enumerate() {
                table.row(&[
                    "force".into(),
                    force.tool.clone(),
                    force.body.clone(),
                    force.time[k].to_string(),
                    force.contact[k].to_string(),
                    empty(),
                    empty(),
                    empty(),
                    empty(),
                    magnitude.to_string(),
                    force.peak[k].to_string(),
                    force.depth[k].to_string(),
                    force.indentation[k].to_string(),
                    force.sustained[k].to_string(),
                    cell(self.session.synthetic.as_ref()),
                ]);
            }
        }
        table.finish()
    }
}

/// A value, or nothing.
fn cell(value: Option<impl ToString>) -> String {
    value.map(|value| value.to_string()).unwrap_or_default()
}

/// A text that a spreadsheet would take for a formula gets an apostrophe before it (OWASP, "CSV injection"); numbers stay numbers.
fn no_formula(cell: &str) -> Cow<'_, str> {
    let begins = cell.starts_with(['=', '+', '-', '@', '\t', '\r']);
    match begins && cell.parse::<f64>().is_err() {
        true => format!("'{cell}").into(),
        false => cell.into(),
    }
}

/// A CSV document in memory, where writing cannot fail as long as all rows are equally long.
struct Table(csv::Writer<Vec<u8>>);

impl Table {
    fn new(header: &[&str]) -> Self {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(header).expect("writing into memory");
        Self(writer)
    }

    fn row(&mut self, cells: &[String]) {
        let cells = cells.iter().map(|cell| no_formula(cell));
        let cells: Vec<_> = cells.collect();
        let bytes = cells.iter().map(|cell| cell.as_bytes());
        self.0.write_record(bytes).expect("rows of equal length");
    }

    fn finish(self) -> String {
        let bytes = self.0.into_inner().expect("writing into memory");
        String::from_utf8(bytes).expect("made of strings")
    }
}

#[cfg(test)]
mod tests {
    use crate::Report;
    use crate::testing::{contact, failed_result, input, log, text};
    use microsim_message::{ContactForces, Pose, ToolSample};

    fn column(csv: &str, name: &str) -> Vec<String> {
        let mut reader = csv::Reader::from_reader(csv.as_bytes());
        let at = reader
            .headers()
            .expect("a header")
            .iter()
            .position(|h| h == name)
            .unwrap_or_else(|| panic!("no column {name}"));
        reader
            .records()
            .map(|row| row.expect("a row")[at].to_string())
            .collect()
    }

    /// Fields with commas, quotes and line breaks come back as they were; numbers come back to the bit.
    #[test]
    fn metrics_come_back() {
        let mut result = failed_result(&["depth"]);
        result.metrics[0].advice = text("First, \"stop\";\nthen go.");
        result.metrics[0].value = Some(0.1 + 0.2);
        let log = log(&[&result]);
        let csv = Report::build(&input(), [(0, &log[..])]).metrics_csv();
        assert_eq!(column(&csv, "id"), ["path-length", "depth", "tremor"]);
        assert_eq!(column(&csv, "advice_en")[0], result.metrics[0].advice.en);
        assert_eq!(column(&csv, "value")[0].parse(), Ok(0.1 + 0.2));
        assert_eq!(column(&csv, "display_max")[1].parse(), Ok(500.0));
        assert_eq!(column(&csv, "within"), ["true", "false", ""]);
        assert_eq!(
            column(&csv, "not_applicable_en")[2],
            "no instrument was tracked"
        );
    }

    /// Each row of both tables of a synthetic trainee is marked; those of people have an empty field.
    #[test]
    fn synthetic_trainees_are_labelled() {
        let forces = ContactForces {
            contacts: vec![contact("right", "strip", [0.0, 3.0, 4.0])],
            ..ContactForces::default()
        };
        let sample = ToolSample {
            tool: "right".into(),
            time: 0.0,
            tracked: true,
            pose: Pose::default(),
            opening: 0.0,
        };
        let log = log(&[&sample, &forces, &failed_result(&["depth"])]);
        for made in [None, Some("profile novice, seed 3".to_owned())] {
            let label = made.clone().unwrap_or_default();
            let session = crate::ReportInput {
                synthetic: made,
                ..input()
            };
            let report = Report::build(&session, [(0, &log[..])]);
            let metrics = column(&report.metrics_csv(), "synthetic");
            assert_eq!(metrics, [&label[..]; 3]);
            assert_eq!(column(&report.series_csv(), "synthetic"), [&label[..]; 2]);
        }
    }

    /// What a script calls itself reaches a spreadsheet as text.
    #[test]
    fn no_text_is_a_formula() {
        for (text, expected) in [
            ("=HYPERLINK(\"http://x\")", "'=HYPERLINK(\"http://x\")"),
            ("@SUM(1)", "'@SUM(1)"),
            ("+cmd|'/c calc'!A0", "'+cmd|'/c calc'!A0"),
            ("-2+3", "'-2+3"),
            ("novice", "novice"),
            ("-2.5e-3", "-2.5e-3"),
        ] {
            let session = crate::ReportInput {
                synthetic: Some(text.into()),
                ..input()
            };
            let log = log(&[&failed_result(&["depth"])]);
            let report = Report::build(&session, [(0, &log[..])]);
            assert_eq!(column(&report.metrics_csv(), "synthetic")[0], expected);
        }
    }

    #[test]
    fn series_come_back() {
        let sample = |time, x| ToolSample {
            tool: "left, right".into(),
            time,
            tracked: true,
            pose: Pose {
                position: [x, 0.0, 0.0],
                ..Pose::default()
            },
            opening: 0.0,
        };
        let forces = ContactForces {
            contacts: vec![contact("right", "strip", [0.0, 3.0, 4.0])],
            ..ContactForces::default()
        };
        let log = log(&[&sample(0.0, 1.0), &sample(0.5, 2.0), &forces]);
        let csv = Report::build(&input(), [(0, &log[..])]).series_csv();
        assert_eq!(column(&csv, "series"), ["motion", "motion", "force"]);
        assert_eq!(column(&csv, "tool")[0], "left, right");
        assert_eq!(column(&csv, "speed_m_per_s"), ["", "2", ""]);
        assert_eq!(column(&csv, "force_n"), ["", "", "5"]);
        assert_eq!(column(&csv, "body")[2], "strip");
    }
}
