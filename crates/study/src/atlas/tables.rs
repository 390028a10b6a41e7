//! The results as tables: CSV with every bit, Markdown for reading.

use super::recovery::{Outcome, SIMULATED};
use super::recovery_figures::scheme_label;
use super::{Atlas, Damage, Limit, TOLERANCE, Variation, method_name};
use crate::page::PageInfo;
use microsim_drawing::{percent, significant, time};
use microsim_tissue::Method;
use microsim_tissue::stability::SAFETY;
use std::fmt::Write;

impl Atlas {
    /// The tables as CSV, with names of files. SI units; an empty field for what does not exist.
    pub fn to_csv(&self) -> Vec<(&'static str, String)> {
        vec![
            ("limits.csv", self.limits_csv()),
            ("large-steps.csv", self.large_steps_csv()),
            ("remedies.csv", self.remedies_csv()),
            ("recovery.csv", self.recovery_csv()),
        ]
    }

    fn limits_csv(&self) -> String {
        let mut out = String::from(
            "method,substance,variation,value,measured_s,exact_s,gershgorin_s,power_iteration_s,delingette_s,measured_over_exact\n",
        );
        for limit in &self.limits {
            let (what, value) = limit.variation.names();
            let numbers = [
                limit.measured.step(),
                Some(limit.exact),
                Some(limit.gershgorin),
                Some(limit.power),
                limit.delingette,
                limit.ratio(),
            ];
            let _ = writeln!(
                out,
                "{},{},{what},{value},{}",
                limit.method.name(),
                quoted(&limit.substance.name()),
                numbers.map(number).join(",")
            );
        }
        out
    }

    fn large_steps_csv(&self) -> String {
        let mut out = String::from(
            "method,substance,start,steps_per_period,step_s,step_over_explicit_limit,energy_share,predicted_share\n",
        );
        for run in &self.large_steps {
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{}",
                quoted(&method_name(&run.method)),
                quoted(&run.substance.name()),
                run.start.name(),
                run.per_period,
                run.step,
                run.over_limit,
                number(run.energy),
                number(run.predicted)
            );
        }
        out
    }

    fn remedies_csv(&self) -> String {
        let mut out = String::from(
            "substance,variation,value,remedy,step_s,step_over_limit,survived,added_mass_share,capped_share,smallest_factor,frequency_change\n",
        );
        for one in &self.remedies {
            let (what, value) = one.variation.names();
            let _ = writeln!(
                out,
                "{},{what},{value},{},{},{},{},{},{},{},{}",
                quoted(&one.substance.name()),
                one.remedy.name(),
                one.step,
                one.over_limit,
                one.survived,
                one.added_mass,
                one.capped,
                one.smallest_factor,
                one.frequency_change
            );
        }
        out
    }

    fn recovery_csv(&self) -> String {
        let mut out = String::from(
            "damage,method,substance,step_s,drag_per_s,relaxation_time_s,outcome,recovered_s,distance_share,inverted,at_rest,reason,cpu_s\n",
        );
        for one in &self.recoveries {
            let (outcome, recovered, distance, inverted, still, reason) = match &one.outcome {
                Outcome::Recovered(at) => ("recovered", Some(*at), None, None, None, ""),
                Outcome::Elsewhere {
                    distance,
                    inverted,
                    still,
                } => (
                    "elsewhere",
                    None,
                    Some(*distance),
                    Some(*inverted),
                    Some(*still),
                    "",
                ),
                Outcome::Failed { reason, .. } => {
                    ("failed", None, None, None, None, reason.as_str())
                }
                Outcome::TooSlow(_) => ("too slow", None, None, None, None, ""),
                Outcome::NotApplicable(reason) => {
                    ("not applicable", None, None, None, None, reason.as_str())
                }
            };
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{outcome},{},{},{},{},{},{}",
                one.damage.name(),
                quoted(&method_name(&one.scheme.method)),
                quoted(&one.scheme.substance.name()),
                one.step,
                one.scheme.drag,
                one.scheme.relaxation_time,
                number(recovered),
                number(distance),
                inverted.map_or(String::new(), |n| n.to_string()),
                still.map_or(String::new(), |s| s.to_string()),
                quoted(reason),
                one.cpu
            );
        }
        out
    }

    /// What was found, in sentences.
    pub fn findings(&self) -> Vec<String> {
        let mut found = Vec::new();
        let (compared, agreeing, worst) = self.agreement();
        if compared > 0 {
            found.push(format!(
                "{agreeing} of {compared} limits of infinitesimal motions agree with the exact prediction to {}; the largest difference is {}.",
                percent(TOLERANCE),
                percent(worst)
            ));
            let others = self.disagreeing();
            if !others.is_empty() {
                found.push(format!(
                    "Those that differ by more, or are stable against the prediction, are of {}.",
                    others.join(", ")
                ));
            }
        }
        found.extend(self.finite_motion());
        found.extend(self.fastest_recoveries());
        let failed = self
            .remedies
            .chunk_by(|a, b| a.substance == b.substance && a.variation == b.variation);
        let remedied = failed.filter(|group| !group[0].survived);
        let (mut bodies, mut saved) = (0, 0);
        for group in remedied {
            bodies += 1;
            saved += usize::from(group[1..].iter().all(|one| one.survived));
        }
        if bodies > 0 {
            found.push(format!(
                "{bodies} blocks with a bad element blow up at the step of the good block; {saved} of them survive with each of the remedies."
            ));
        }
        found
    }

    /// The materials with limits that are not as predicted, with the number of them.
    fn disagreeing(&self) -> Vec<String> {
        self.limits
            .chunk_by(|a, b| a.substance == b.substance)
            .filter_map(|limits| {
                let number = limits
                    .iter()
                    .filter(|limit| limit.agrees(TOLERANCE) == Some(false))
                    .count();
                (number > 0).then(|| format!("{} ({number})", limits[0].substance.name()))
            })
            .collect()
    }

    /// What the largest random offsets leave of the limit of Störmer–Verlet.
    fn finite_motion(&self) -> Option<String> {
        let large = |limit: &&Limit| {
            limit.method == Method::StoermerVerlet && limit.variation == Variation::Amplitude(0.2)
        };
        let all = || {
            self.limits
                .iter()
                .filter(large)
                .filter_map(|limit| Some((limit, limit.ratio()?)))
        };
        let (worst, least) = all().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let (best, most) = all().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let below = all().filter(|(_, ratio)| *ratio < SAFETY).count();
        Some(format!(
            "Random offsets of 20 % of a cell leave {} of the linear limit of Störmer–Verlet with {}, and {} with {}; {below} of {} materials then need less than the recommended fraction of {SAFETY}.",
            significant(most, 2),
            best.substance.name(),
            significant(least, 2),
            worst.substance.name(),
            all().count()
        ))
    }

    /// Which schemes recover from everything, and for each damage the one with inertia that needs the least CPU time.
    fn fastest_recoveries(&self) -> Vec<String> {
        let schemes = || self.recoveries.chunk_by(|a, b| a.scheme == b.scheme);
        let from_all =
            || schemes().filter(|runs| runs.iter().all(|one| one.outcome.is_recovered()));
        let in_time = from_all()
            .filter(|runs| runs.iter().all(|one| one.cpu <= SIMULATED))
            .count();
        let mut found = Vec::new();
        if schemes().next().is_some() {
            found.push(format!(
                "Of {} schemes {} recover the beam from every damage, {in_time} of them in at most {SIMULATED} CPU s each.",
                schemes().count(),
                from_all().count()
            ));
        }
        let each = Damage::ALL.into_iter().filter_map(|damage| {
            let moving = |one: &&super::Recovery| !matches!(one.scheme.method, Method::QuasiStatic(_));
            let all = || self.recoveries.iter().filter(move |one| one.damage == damage).filter(moving);
            let recovered = || all().filter(|one| one.outcome.is_recovered());
            let fastest = recovered().min_by(|a, b| a.cpu.total_cmp(&b.cpu))?;
            let Outcome::Recovered(at) = fastest.outcome else {
                return None;
            };
            Some(format!(
                "{}: {} of {} schemes with inertia recover; the cheapest is {} with {} CPU s, there after {}.",
                capital(damage.name()),
                recovered().count(),
                all().filter(|one| !matches!(one.outcome, Outcome::NotApplicable(_))).count(),
                scheme_label(&fastest.scheme, fastest.step),
                significant(fastest.cpu, 2),
                time(at)
            ))
        });
        found.extend(each);
        found
    }

    /// Everything as one Markdown document.
    pub fn to_markdown(&self, info: &PageInfo) -> String {
        let PageInfo {
            machine, command, ..
        } = info;
        let mut out = format!(
            "# Stability atlas\n\nCommand: `{command}`, on {machine}. CPU times are this machine's; all else is the same on every one.\n\n"
        );
        for sentence in self.findings() {
            let _ = writeln!(out, "- {sentence}");
        }
        for figure in self.figures() {
            let _ = write!(out, "\n## {}\n\n{}", figure.title, figure.to_markdown());
        }
        let _ = write!(
            out,
            "\n## Remedies for bad elements\n\n{}",
            self.remedies_markdown()
        );
        out
    }

    fn remedies_markdown(&self) -> String {
        let mut out = format!(
            "| {} |\n|{}\n",
            REMEDY_COLUMNS.join(" | "),
            "---|".repeat(REMEDY_COLUMNS.len())
        );
        for row in self.remedy_rows() {
            let _ = writeln!(out, "| {} |", row.join(" | "));
        }
        out
    }

    /// The table of remedies as text, under [`REMEDY_COLUMNS`].
    pub(super) fn remedy_rows(&self) -> Vec<[String; 8]> {
        let row = |one: &super::Remedied| {
            let (what, value) = one.variation.names();
            let fraction = |value: f64| {
                if value == 0.0 {
                    "–".into()
                } else {
                    percent(value)
                }
            };
            [
                one.substance.name(),
                format!("{what} {value}"),
                one.remedy.name().into(),
                time(one.step),
                significant(one.over_limit, 2),
                if one.survived {
                    "✓ holds"
                } else {
                    "✕ blows up"
                }
                .into(),
                match one.capped {
                    0.0 => fraction(one.added_mass),
                    capped => format!(
                        "{} of elements, down to ×{}",
                        percent(capped),
                        significant(one.smallest_factor, 2)
                    ),
                },
                fraction(one.frequency_change),
            ]
        };
        self.remedies.iter().map(row).collect()
    }
}

/// Columns of the table of remedies.
pub(super) const REMEDY_COLUMNS: [&str; 8] = [
    "Block of",
    "Bad element",
    "Remedy",
    "Step",
    "Step over limit",
    "2000 steps",
    "Added mass, or stiffness taken",
    "First frequency",
];

fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value.is_finite() => value.to_string(),
        _ => String::new(),
    }
}

/// A field of CSV that may hold a comma.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}
