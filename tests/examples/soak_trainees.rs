//! `cargo xtask soak trainees -- MODULE LEVEL N`: N synthetic experts and N novices on a level; of each metric mean and standard
//! deviation of both groups, the effect size, and whether it lies in the intended direction. Writes
//! `tests/results/trainees.md`, where each level has a section.
//!
//! The groups differ by the numbers in `config/trainees.toml`. That a metric tells them apart shows that it measures what it should in
//! these motions; that people differ so, it does not show.

use microsim_tests::statistics::{Group, effect_size};
use microsim_tests::{repository, trainees};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitCode;

/// What stands above the sections.
const HEAD: &str = "# Synthetic trainees

`cargo xtask soak trainees -- MODULE LEVEL N`: N *experts* and N *novices* of `config/trainees.toml`, made from the passing script of the level
by `microsim trainee`. Both follow the same plan; they differ in tremor, pace, pauses, aim, detours and grip, by numbers that were set before
the first run and not changed afterwards. Cohen's d is the difference of the means over the pooled standard deviation, positive where novices
have the larger value.

**Synthetic groups validate nothing**: what tells them apart follows from their numbers. The table shows whether the metrics notice it, and in
the intended direction; *yes* and *no* from |d| ≥ 0.2 on (a small effect, Cohen 1988), *none* below.
";

/// An effect below this is none (Cohen 1988: 0.2 is small).
const SMALL: f64 = 0.2;

/// The results of a group.
#[derive(Default)]
struct Results {
    /// Values by metric.
    values: BTreeMap<String, Vec<f64>>,
    scores: Vec<f64>,
    passed: usize,
    /// How often each reason was named.
    reasons: BTreeMap<String, usize>,
}

impl Results {
    fn of(
        module: &str,
        level: u32,
        profile: &str,
        count: u64,
        kinds: &mut BTreeMap<String, Metric>,
    ) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let mut results = Self::default();
        for seed in 1..=count {
            let script = trainees::make(module, level, profile, seed, folder.path());
            let (_, report) = trainees::run(module, level, &script);
            results.add(&report, kinds);
            eprintln!(
                "  {profile} {seed}: {} {}",
                report["verdict"], report["failed"]
            );
        }
        results
    }

    fn add(&mut self, report: &Value, kinds: &mut BTreeMap<String, Metric>) {
        self.passed += usize::from(report["verdict"] == "passed");
        self.scores.extend(report["score"].as_f64());
        for reason in report["failed"].as_array().into_iter().flatten() {
            let reason = reason.as_str().unwrap_or_default().to_owned();
            *self.reasons.entry(reason).or_default() += 1;
        }
        for metric in report["metrics"].as_array().into_iter().flatten() {
            let Some(value) = metric["display_value"].as_f64() else {
                continue;
            };
            let text = |key: &str| metric[key].as_str().unwrap_or_default().to_owned();
            let id = text("id");
            kinds.entry(id.clone()).or_insert_with(|| Metric {
                title: metric["title"]["en"]
                    .as_str()
                    .unwrap_or_default()
                    .to_owned(),
                unit: text("display_unit"),
                direction: text("direction"),
                limited: !metric["limit"].is_null(),
            });
            self.values.entry(id).or_default().push(value);
        }
    }

    fn group(&self, metric: &str) -> Option<Group> {
        Group::of(self.values.get(metric)?)
    }
}

/// What a metric is.
struct Metric {
    title: String,
    unit: String,
    direction: String,
    limited: bool,
}

/// The section of a level.
fn section(module: &str, level: u32, count: u64) -> String {
    let mut kinds = BTreeMap::new();
    let experts = Results::of(module, level, "expert", count, &mut kinds);
    let novices = Results::of(module, level, "novice", count, &mut kinds);
    let mut out = format!("## {module}, level {level}: {count} and {count}\n\n");
    let shown = |group: Option<Group>| match group {
        Some(group) => format!(
            "{:.4} ± {:.4} ({})",
            group.mean, group.deviation, group.count
        ),
        None => "–".to_owned(),
    };
    out.push_str("| metric | limit | experts: mean ± SD (n) | novices: mean ± SD (n) | d | intended |\n|---|---|---|---|---|---|\n");
    for (id, metric) in &kinds {
        let (a, b) = (experts.group(id), novices.group(id));
        let effect = a.zip(b).and_then(|(a, b)| effect_size(&a, &b));
        let intended = match (effect, metric.direction.as_str()) {
            (None, _) | (_, "informative" | "range") => "–",
            (Some(d), _) if d.abs() < SMALL => "none",
            (Some(d), "lower-is-better") if d > 0.0 => "yes",
            (Some(d), "higher-is-better") if d < 0.0 => "yes",
            _ => "no",
        };
        let unit = match metric.unit.as_str() {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        let _ = writeln!(
            out,
            "| {}{unit} | {} | {} | {} | {} | {intended} |",
            metric.title,
            if metric.limited { "yes" } else { "" },
            shown(a),
            shown(b),
            effect.map_or("–".into(), |d| format!("{d:+.2}"))
        );
    }
    let scores = |results: &Results| shown(Group::of(&results.scores));
    let score = Group::of(&experts.scores).zip(Group::of(&novices.scores));
    let _ = writeln!(
        out,
        "| **score** | | {} | {} | {} | |",
        scores(&experts),
        scores(&novices),
        score
            .and_then(|(a, b)| effect_size(&a, &b))
            .map_or("–".into(), |d| format!("{d:+.2}"))
    );
    out.push('\n');
    for (name, results) in [("experts", &experts), ("novices", &novices)] {
        let reasons: Vec<String> = results
            .reasons
            .iter()
            .map(|(reason, n)| format!("{reason} {n}"))
            .collect();
        let _ = writeln!(
            out,
            "- {name}: {} of {count} passed{}{}",
            results.passed,
            if reasons.is_empty() {
                ""
            } else {
                "; reasons: "
            },
            reasons.join(", ")
        );
    }
    out
}

/// The page with the section of a level in place of the one that was there.
fn with_section(page: &str, section: &str) -> String {
    let title = |section: &str| section.split(':').next().unwrap_or_default().to_owned();
    let old = page
        .split("\n## ")
        .skip(1)
        .map(|rest| format!("## {}", rest.trim_end()));
    let mut sections: Vec<String> = old.filter(|old| title(old) != title(section)).collect();
    sections.push(section.trim_end().to_owned());
    sections.sort();
    format!("{HEAD}\n{}\n", sections.join("\n\n"))
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (module, level, count) = match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => ("coordination", Some(4), Some(20)),
        [module, level, count] => (module, level.parse().ok(), count.parse().ok()),
        _ => ("", None, None),
    };
    let (Some(level), Some(count)) = (level, count) else {
        eprintln!("expected MODULE LEVEL N");
        return ExitCode::from(2);
    };
    let section = section(module, level, count);
    println!("{section}");
    let path = repository().join("tests/results/trainees.md");
    let page = std::fs::read_to_string(&path).unwrap_or_default();
    match std::fs::write(&path, with_section(&page, &section)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", path.display());
            ExitCode::from(2)
        }
    }
}
