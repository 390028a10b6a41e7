//! All runs of a chart, and the views of them: the table as CSV, and for each scene and variant a panel with its answers.

use crate::front::{Point, cheapest, pareto_front};
use crate::row::real_time;
use crate::row::{Against, GroupResult, Row, Status};
use microsim_drawing::{percent, significant, time};
use microsim_settings::{Chart, ChartScene, ChartVariant};
use std::fmt::Write;

/// Errors below this are no better than each other: what is left of a solver's tolerance and of rounding.
const LEAST_ERROR: f64 = 1e-6;

/// An error must be smaller by this fraction to be worth its cost.
const VISIBLE: f64 = 0.02;

/// The errors for which the cheapest run is named.
pub const ERRORS: [f64; 3] = [0.10, 0.03, 0.01];

/// What was run, and what came out.
#[derive(Clone, Debug)]
pub struct Results {
    /// The plan; the indices of the runs mean its lists.
    pub chart: Chart,
    /// In the order of the plan.
    pub groups: Vec<GroupResult>,
}

/// The runs of one variant of a scene.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// All results.
    pub results: &'a Results,
    /// The scene.
    pub scene: &'a ChartScene,
    /// Its index.
    pub scene_index: usize,
    /// The variant.
    pub variant: &'a ChartVariant,
    /// Its index.
    pub variant_index: usize,
    /// Its runs, in the order of the plan.
    pub rows: Vec<&'a Row>,
}

impl Results {
    /// One panel for each scene and variant of which something was run, in the order of the plan.
    pub fn panels(&self) -> Vec<Panel<'_>> {
        let mut panels = Vec::new();
        for (scene_index, scene) in self.chart.scene.iter().enumerate() {
            for (variant_index, variant) in scene.variant.iter().enumerate() {
                let of_panel = |group: &&GroupResult| {
                    group.key.scene == scene_index && group.key.variant == variant_index
                };
                let groups = self.groups.iter().filter(of_panel);
                let rows: Vec<&Row> = groups.flat_map(|group| &group.rows).collect();
                if !rows.is_empty() {
                    panels.push(Panel {
                        results: self,
                        scene,
                        scene_index,
                        variant,
                        variant_index,
                        rows,
                    });
                }
            }
        }
        panels
    }

    /// Title of a row's method.
    pub fn method_title(&self, row: &Row) -> &str {
        &self.chart.method[row.key.method].title
    }

    /// Title of a row's material.
    pub fn material_title(&self, row: &Row) -> &str {
        &self.chart.material[row.key.group.material].title
    }

    /// Whether both material and method of a row are those of the dissertation.
    pub fn is_of_the_dissertation(&self, row: &Row) -> bool {
        let material = &self.chart.material[row.key.group.material];
        material.dissertation && self.chart.method[row.key.method].dissertation
    }

    /// Name of a row's mesh.
    pub fn resolution_name(&self, row: &Row) -> &str {
        let key = &row.key.group;
        &self.chart.scene[key.scene].resolution[key.resolution].name
    }

    /// A run in words: method, material, mesh, step.
    pub fn describe(&self, row: &Row) -> String {
        format!(
            "{}, {}, mesh {}, {}",
            self.method_title(row),
            self.material_title(row),
            self.resolution_name(row),
            self.parameters(row)
        )
    }

    /// Step and iterations of a run in words.
    pub fn parameters(&self, row: &Row) -> String {
        let mut words = if row.step.is_finite() {
            format!("step {}", time(row.step))
        } else {
            "no step".into()
        };
        if let Some(limit) = row.iteration_limit {
            let plural = if limit == 1 { "" } else { "s" };
            let _ = write!(words, ", {limit} iteration{plural}");
        }
        words
    }

    /// The table: one line per run, and one per exact solution, whose method is `exact`. Everything in SI.
    pub fn to_csv(&self) -> String {
        let measures = self.chart.scene.iter().map(|s| s.measure.len()).max();
        let measures = measures.unwrap_or(0);
        let mut out = String::from(
            "scene,variant,resolution,elements,material,method,step_s,iteration_limit,status,status_time_s,reason,\
             error_reference,error_same_mesh,cpu_s,simulated_s,cpu_s_per_simulated_s,iterations_per_step,energy_drift",
        );
        for k in 1..=measures {
            let _ = write!(
                out,
                ",measure_{k},value_{k},reference_{k},exact_same_mesh_{k}"
            );
        }
        out.push('\n');
        for group in &self.groups {
            let scene = &self.chart.scene[group.key.scene];
            let head = [
                scene.name.clone(),
                scene.variant[group.key.variant].name.clone(),
                scene.resolution[group.key.resolution].name.clone(),
            ];
            let material = &self.chart.material[group.key.material].name;
            let mut line = |fields: Vec<String>, measures_of: &[crate::row::Measured]| {
                let mut fields: Vec<String> = head.iter().cloned().chain(fields).collect();
                for (k, measure) in scene.measure.iter().enumerate() {
                    let of = measures_of.get(k).copied().unwrap_or_default();
                    fields.push(measure.title.clone());
                    fields.extend([of.value, of.reference, of.exact].map(optional));
                }
                fields.resize(18 + 4 * measures, String::new());
                let fields: Vec<String> = fields.iter().map(|f| quoted(f)).collect();
                let _ = writeln!(out, "{}", fields.join(","));
            };
            if !group.exact.is_empty() || group.exact_failure.is_some() {
                let mut fields = vec![String::new(); 15];
                fields[0] = group.elements.to_string();
                fields[1] = material.clone();
                fields[2] = "exact".into();
                fields[5] = if group.exact_failure.is_some() {
                    "not applicable"
                } else {
                    "ok"
                }
                .into();
                fields[7] = group.exact_failure.clone().unwrap_or_default();
                fields[8] = optional(group.exact_error());
                line(fields, &group.exact);
            }
            for row in &group.rows {
                let (at, reason) = match &row.status {
                    Status::Ok => (None, ""),
                    Status::Diverged { time, reason } => (Some(*time), reason.as_str()),
                    Status::OverBudget { time } => (Some(*time), ""),
                    Status::NotApplicable { reason } => (None, reason.as_str()),
                };
                let fields = vec![
                    row.elements.to_string(),
                    material.clone(),
                    self.chart.method[row.key.method].name.clone(),
                    number(row.step),
                    row.iteration_limit
                        .map(|l| l.to_string())
                        .unwrap_or_default(),
                    row.status.name().into(),
                    optional(at),
                    reason.into(),
                    optional(row.error(Against::Reference)),
                    optional(row.error(Against::SameMesh)),
                    number(row.cpu),
                    number(row.simulated),
                    optional(row.cost()),
                    optional(row.iterations),
                    optional(row.energy_drift),
                ];
                line(fields, &row.measures);
            }
        }
        out
    }
}

/// A number for a machine; nothing for what is none.
fn number(value: f64) -> String {
    if value.is_finite() {
        value.to_string()
    } else {
        String::new()
    }
}

fn optional(value: Option<f64>) -> String {
    value.map(number).unwrap_or_default()
}

/// A field as RFC 4180 wants it.
fn quoted(field: &str) -> String {
    if field.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

impl Panel<'_> {
    /// A name for people.
    pub fn title(&self) -> String {
        if self.scene.variant.len() == 1 {
            self.scene.title.clone()
        } else {
            let variant = self.variant.name.replace(' ', "\u{a0}");
            format!("{}, {variant}", self.scene.title)
        }
    }

    /// A name for files and links.
    pub fn id(&self) -> String {
        if self.scene.variant.len() == 1 {
            self.scene.name.clone()
        } else {
            format!("{}-{}", self.scene.name, self.variant_index + 1)
        }
    }

    /// Whether anything is known from outside.
    pub fn has_reference(&self) -> bool {
        !self.variant.reference.is_empty()
    }

    /// The runs that have both a cost and an error; the index is that in `rows`.
    pub fn points(&self, against: Against) -> Vec<Point> {
        let point = |(index, row): (usize, &&Row)| {
            Some(Point {
                cost: row.cost()?,
                error: row.error(against)?.max(LEAST_ERROR),
                index,
            })
        };
        self.rows.iter().enumerate().filter_map(point).collect()
    }

    /// The runs that no other run beats, by ascending cost; those that are better by less than a reader could see, and
    /// answer nothing, are left out.
    pub fn front(&self, against: Against) -> Vec<Point> {
        let mut front: Vec<Point> = Vec::new();
        for point in pareto_front(&self.points(against)) {
            let better = |last: &Point| {
                let answers = ERRORS.iter().any(|e| last.error > *e && point.error <= *e);
                answers || point.error < (1.0 - VISIBLE) * last.error
            };
            if front.last().is_none_or(better) {
                front.push(point);
            }
        }
        front
    }

    /// The cheapest run for an error.
    pub fn cheapest(&self, against: Against, error: f64) -> Option<&Row> {
        let point = cheapest(&self.front(against), error)?;
        Some(self.rows[point.index])
    }

    /// What the sentence, and a user, compare with: the reference where there is one.
    pub fn main_comparison(&self) -> Against {
        if self.has_reference() {
            Against::Reference
        } else {
            Against::SameMesh
        }
    }

    /// The answer in words.
    pub fn sentence(&self) -> String {
        let against = self.main_comparison();
        let front = self.front(against);
        let mut words = String::new();
        if !self.has_reference() {
            words.push_str("Nothing is known from outside, so errors are against the exact solution on the same mesh. ");
        }
        let Some(best) = front.last() else {
            words.push_str("No run came to an end with an error that can be stated.");
            return words + &self.failures();
        };
        match cheapest(&front, 0.03) {
            Some(point) => {
                let row = self.rows[point.index];
                let _ = write!(
                    words,
                    "An error of 3 % costs least with {}: {} CPU s per simulated s, {} (error {}).",
                    self.results.describe(row),
                    significant(point.cost, 2),
                    real_time(point.cost),
                    percent(point.error)
                );
                if point.cost > 1.0 {
                    words.push_str(" That is not real time on this machine.");
                    let real = front.iter().rfind(|p| p.cost <= 1.0);
                    match real {
                        Some(real) => {
                            let row = self.rows[real.index];
                            let _ = write!(
                                words,
                                " In real time the best is {} with {}.",
                                self.results.describe(row),
                                percent(real.error)
                            );
                        }
                        None => words.push_str(" Nothing here runs in real time."),
                    }
                }
                if best.error > 0.01 {
                    let _ = write!(
                        words,
                        " Nothing reaches 1 %; the best has {}.",
                        percent(best.error)
                    );
                }
            }
            None => {
                let row = self.rows[best.index];
                let _ = write!(
                    words,
                    "Nothing reaches 3 %. The smallest error is {}, with {}: {} CPU s per simulated s, {}.",
                    percent(best.error),
                    self.results.describe(row),
                    significant(best.cost, 2),
                    real_time(best.cost)
                );
            }
        }
        words + &self.failures()
    }

    /// Which methods diverged, were cut off or could not be used, and how often.
    fn failures(&self) -> String {
        let mut words = String::new();
        for status in ["diverged", "over budget", "not applicable"] {
            let mut methods: Vec<(usize, usize, usize)> = Vec::new();
            for row in &self.rows {
                let failed = usize::from(row.status.name() == status);
                match methods
                    .iter_mut()
                    .find(|(method, ..)| *method == row.key.method)
                {
                    Some((_, count, all)) => {
                        *count += failed;
                        *all += 1;
                    }
                    None => methods.push((row.key.method, failed, 1)),
                }
            }
            let list: Vec<String> = methods
                .iter()
                .filter(|(_, count, _)| *count > 0)
                .map(|(method, count, all)| {
                    let title = &self.results.chart.method[*method].title;
                    format!("{title} ({count} of {all} runs)")
                })
                .collect();
            if !list.is_empty() {
                let mut name = status.to_owned();
                name[..1].make_ascii_uppercase();
                let _ = write!(words, " {name}: {}.", list.join(", "));
            }
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::results;

    /// Fields of a line of CSV as RFC 4180 has them.
    fn fields(line: &str) -> Vec<String> {
        let (mut fields, mut quoted) = (vec![String::new()], false);
        let mut letters = line.chars().peekable();
        while let Some(letter) = letters.next() {
            let field = fields.last_mut().expect("there is a field");
            match letter {
                '"' if quoted && letters.peek() == Some(&'"') => {
                    letters.next();
                    field.push('"');
                }
                '"' => quoted = !quoted,
                ',' if !quoted => fields.push(String::new()),
                letter => field.push(letter),
            }
        }
        assert!(!quoted, "{line}");
        fields
    }

    #[test]
    fn the_table_holds_every_run_with_all_its_figures() {
        let results = results();
        let csv = results.to_csv();
        let lines: Vec<Vec<String>> = csv.lines().map(fields).collect();
        let rows: usize = results.groups.iter().map(|g| g.rows.len()).sum();
        assert_eq!(
            lines.len(),
            1 + rows + results.groups.len(),
            "and one line per exact solution"
        );
        assert!(lines.iter().all(|line| line.len() == lines[0].len()));
        let column = |name: &str| lines[0].iter().position(|f| f == name).expect(name);
        let diverged: Vec<_> = lines
            .iter()
            .filter(|l| l[column("status")] == "diverged")
            .collect();
        assert_eq!(diverged.len(), 9, "one of each group");
        for line in diverged {
            assert_eq!(line[column("reason")], "gains energy, \"much\"");
            assert_eq!(line[column("status_time_s")], "0.02");
            assert_eq!(line[column("error_reference")], "");
            assert_ne!(line[column("cpu_s_per_simulated_s")], "");
        }
        let exact = lines
            .iter()
            .find(|l| l[column("method")] == "exact")
            .expect("one");
        let error: f64 = exact[column("error_reference")].parse().expect("a number");
        assert!((error - 0.01).abs() < 1e-12, "{error}");
        assert_eq!(exact[column("reference_1")], "0.0345");
    }

    #[test]
    fn the_cheapest_run_for_an_error_is_that_of_the_table() {
        let results = results();
        let panel = &results.panels()[0];
        for (error, cost) in [(0.10, 0.125), (0.03, 0.5), (0.01, 1.0)] {
            let row = panel.cheapest(Against::Reference, error).expect("a run");
            assert_eq!(row.cost(), Some(cost), "for {error}");
        }
        assert_eq!(panel.cheapest(Against::Reference, 1e-4), None);
        assert_eq!(results.panels()[2].cheapest(Against::Reference, 1.0), None);
    }

    #[test]
    fn what_diverged_has_no_error_but_stays() {
        let results = results();
        let panel = &results.panels()[0];
        let diverged = panel.rows.iter().filter(|r| r.status.name() == "diverged");
        assert_eq!(diverged.clone().count(), 4);
        assert!(
            diverged
                .into_iter()
                .all(|r| r.error(Against::Reference).is_none() && r.cost().is_some())
        );
    }
}
