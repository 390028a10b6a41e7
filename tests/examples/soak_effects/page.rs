//! The page, from the tables of all levels that have one.

use microsim_tests::changed_levels::COMPUTATIONS;
use microsim_tests::sensitivity::{KINDS, Outcome, Runs, read};
use microsim_tests::statistics::{Group, hedges, pooled};
use microsim_tests::{repository, tree};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use toml::{Table, Value};

/// The column of the score.
pub const SCORE: &str = "score";

const PAGE: &str = include_str!("page.md");

/// The fraction of verdicts that may change.
const AIM: f64 = 0.05;

/// A level with its runs.
struct Level {
    module: String,
    level: u32,
    /// In the order of columns, the score first.
    metrics: Vec<String>,
    /// Metrics with a limit, and whether it decides.
    limits: BTreeMap<String, bool>,
    runs: Runs,
}

/// The metrics that a level limits, each with whether the limit decides.
///
/// # Errors
/// The file that cannot be read.
pub fn limits(module: &str, level: u32) -> Result<BTreeMap<String, bool>, String> {
    let path = tree().join(format!("modules/{module}/levels/level{level}.toml"));
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let table: Table = text
        .parse()
        .map_err(|e| format!("{}: {e}", path.display()))?;
    let limits = table.get("limit").and_then(Value::as_array);
    let limit = |of: &Value| {
        let metric = of.get("metric")?.as_str()?.to_owned();
        Some((metric, of.get("decides") != Some(&Value::Boolean(false))))
    };
    Ok(limits.into_iter().flatten().filter_map(limit).collect())
}

/// Writes the page.
///
/// # Errors
/// The file that cannot be read or written.
pub fn write() -> Result<(), String> {
    let results = repository().join("tests/results");
    let folder = results.join("effects");
    let entries = fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut levels = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        let named = stem.and_then(|stem| stem.rsplit_once('-'));
        let Some((module, level)) = named else {
            continue;
        };
        let number = level
            .parse()
            .map_err(|e| format!("{}: {e}", path.display()))?;
        if let Some((metrics, runs)) = read(&path)? {
            levels.push(Level {
                module: module.to_owned(),
                level: number,
                metrics,
                limits: limits(module, number)?,
                runs,
            });
        }
    }
    levels.sort_by(|a, b| (&a.module, a.level).cmp(&(&b.module, b.level)));
    let path = results.join("effects.md");
    fs::write(&path, page(&levels)).map_err(|e| format!("{}: {e}", path.display()))
}

fn page(levels: &[Level]) -> String {
    let changes: Vec<Changes> = levels
        .iter()
        .map(|level| Changes::of(&level.runs))
        .collect();
    let summary: String = levels
        .iter()
        .zip(&changes)
        .map(|(level, changes)| summary(level, changes))
        .collect();
    let modules = levels.chunk_by(|a, b| a.module == b.module);
    let modules: String = modules.map(summary_of_module).collect();
    let tables: Vec<String> = levels.iter().map(table).collect();
    let complete = changes.into_iter().filter(Changes::in_all_computations);
    let all = complete.fold(Changes::default(), Changes::and);
    PAGE.replace("{share}", &all.sentence())
        .replace("{modules}", modules.trim_end())
        .replace("{summary}", summary.trim_end())
        .replace("{tables}", tables.join("\n").trim_end())
}

/// Pairs of runs of the same motions, as shipped and in another computation, and how many of them have another verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Changes([[usize; 2]; COMPUTATIONS.len() - 1]);

impl Changes {
    fn of(runs: &Runs) -> Self {
        Self(std::array::from_fn(|at| {
            let change = COMPUTATIONS[at + 1].0;
            let mut counts = [0; 2];
            for ((kind, seed, _), other) in runs.iter().filter(|((.., of), _)| of == change) {
                let shipped = (kind.clone(), *seed, COMPUTATIONS[0].0.to_owned());
                if let Some(shipped) = runs.get(&shipped) {
                    counts[0] += usize::from(shipped.verdict != other.verdict);
                    counts[1] += 1;
                }
            }
            counts
        }))
    }

    /// Whether the level was played in each computation. One without tissue never is: it has no iterations, and no verdict that could be another.
    fn in_all_computations(&self) -> bool {
        self.0.iter().all(|[_, all]| *all > 0)
    }

    fn and(mut self, other: Self) -> Self {
        for (sum, more) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *sum += more;
        }
        self
    }

    fn shown([changed, all]: [usize; 2]) -> String {
        let percent = 100.0 * changed as f64 / all as f64;
        match all {
            0 => "–".to_owned(),
            _ => format!("{changed} of {all} ({percent:.1} %)"),
        }
    }

    fn sentence(&self) -> String {
        let played = self.0.iter().zip(&COMPUTATIONS[1..]);
        let played = played.filter(|([_, all], _)| *all > 0);
        let parts: Vec<String> = played
            .map(|(counts, (name, _))| format!("at {name} {}", Self::shown(*counts)))
            .collect();
        let most = self
            .0
            .iter()
            .any(|[changed, all]| *changed as f64 > AIM * *all as f64);
        let aim = if most { "missed" } else { "met" };
        format!(
            "Verdicts other than those of the same motions as shipped, over all levels with tissue that were played in each computation: {}. The aim, at most {:.0} % each, is {aim}.",
            parts.join(", "),
            100.0 * AIM
        )
    }
}

/// The values of a kind of trainees in a computation; runs that were not judged are left out.
fn group(level: &Level, kind: &str, computation: usize, metric: &str) -> Option<Group> {
    let name = COMPUTATIONS[computation].0;
    let of_it = level.runs.iter().filter(|((of, _, change), run)| {
        of == kind && change == name && run.verdict != "not-judged"
    });
    let values: Vec<f64> = of_it
        .filter_map(|(_, run)| run.values.get(metric).copied())
        .collect();
    Group::of(&values)
}

fn shown(group: Option<Group>) -> String {
    group.map_or("–".to_owned(), |of| {
        format!("{:.4} ± {:.4} ({})", of.mean, of.deviation, of.count)
    })
}

/// Hedges' g of novices against experts, with its standard error.
fn effect(level: &Level, computation: usize, metric: &str) -> Option<(f64, f64)> {
    let [a, b] = KINDS.map(|kind| group(level, kind, computation, metric));
    a.zip(b).and_then(|(a, b)| hedges(&a, &b))
}

fn shown_effect(effect: Option<(f64, f64)>) -> String {
    effect.map_or("–".to_owned(), |(g, error)| {
        format!("{g:+.2} ± {error:.2}")
    })
}

/// The row of a level.
fn summary(level: &Level, changes: &Changes) -> String {
    let name = format!("{}, level {}", level.module, level.level);
    row(&name, std::slice::from_ref(level), changes, |at| {
        effect(level, at, SCORE)
    })
}

/// The row of a module: the runs of its levels together, and the mean effect within them.
fn summary_of_module(levels: &[Level]) -> String {
    let changes = levels.iter().map(|level| Changes::of(&level.runs));
    let changes = changes.fold(Changes::default(), Changes::and);
    row(&levels[0].module, levels, &changes, |at| {
        let effects = levels.iter().filter_map(|level| effect(level, at, SCORE));
        pooled(&effects.collect::<Vec<_>>())
    })
}

fn row(
    name: &str,
    levels: &[Level],
    changes: &Changes,
    effect: impl Fn(usize) -> Option<(f64, f64)>,
) -> String {
    let shipped = |kind: &str| {
        let all = levels.iter().flat_map(|level| &level.runs);
        let of_kind = all.filter(|((of, _, change), _)| of == kind && change == COMPUTATIONS[0].0);
        of_kind.map(|(_, run)| run).collect::<Vec<&Outcome>>()
    };
    let mut row = format!("| {name} |");
    for kind in KINDS {
        let runs = shipped(kind);
        let count = |verdict: &str| runs.iter().filter(|run| run.verdict == verdict).count();
        let _ = write!(
            row,
            " {}, {}, {} |",
            count("passed"),
            count("failed"),
            count("not-judged")
        );
    }
    for at in 0..COMPUTATIONS.len() {
        let _ = write!(row, " {} |", shown_effect(effect(at)));
    }
    for counts in changes.0 {
        let _ = write!(row, " {} |", Changes::shown(counts));
    }
    row + "\n"
}

/// The section of a level.
fn table(level: &Level) -> String {
    let mut out = format!(
        "## {}, level {}\n\n| metric | limited | experts: mean ± SD (n) | novices: mean ± SD (n) |",
        level.module, level.level
    );
    for (name, _) in COMPUTATIONS {
        let _ = write!(out, " g ± SE, {name} |");
    }
    let _ = writeln!(out, "\n|{}", "---|".repeat(4 + COMPUTATIONS.len()));
    for metric in &level.metrics {
        let limited = match level.limits.get(metric) {
            None => "",
            Some(true) => "yes",
            Some(false) => "reference value",
        };
        let [a, b] = KINDS.map(|kind| shown(group(level, kind, 0, metric)));
        let _ = write!(out, "| {metric} | {limited} | {a} | {b} |");
        for at in 0..COMPUTATIONS.len() {
            let _ = write!(out, " {} |", shown_effect(effect(level, at, metric)));
        }
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(of: &[(&str, u64, usize, &str, f64)]) -> Level {
        let run = |(kind, seed, change, verdict, score): &(&str, u64, usize, &str, f64)| {
            let outcome = Outcome {
                verdict: (*verdict).to_owned(),
                failed: String::new(),
                values: [(SCORE.to_owned(), *score)].into(),
            };
            let change = COMPUTATIONS[*change].0.to_owned();
            (((*kind).to_owned(), *seed, change), outcome)
        };
        Level {
            module: "module".to_owned(),
            level: 1,
            metrics: vec![SCORE.to_owned()],
            limits: BTreeMap::new(),
            runs: of.iter().map(run).collect(),
        }
    }

    /// By hand: experts 7 and 9, novices 1 and 3: d = -6/√2, g = (1 - 3/7) d = -2.42, its error 4/7 √(1 + 18/8) = 1.03. At twice the iterations one of four verdicts is
    /// another, and the novice that was not judged has no score.
    #[test]
    fn effects_and_verdicts_that_change() {
        let runs = [
            ("expert", 1, 0, "passed", 7.0),
            ("expert", 2, 0, "passed", 9.0),
            ("novice", 1, 0, "failed", 1.0),
            ("novice", 2, 0, "failed", 3.0),
            ("expert", 1, 1, "passed", 7.0),
            ("expert", 2, 1, "passed", 9.0),
            ("novice", 1, 1, "failed", 1.0),
            ("novice", 2, 1, "not-judged", 9.0),
        ];
        let levels = [1, 2].map(|number| Level {
            level: number,
            ..level(&runs)
        });
        let level = &levels[0];
        let changes = Changes::of(&level.runs);
        assert_eq!(changes, Changes([[1, 4], [0, 0]]));
        assert_eq!(
            summary(level, &changes),
            "| module, level 1 | 2, 0, 0 | 0, 2, 0 | -2.42 ± 1.03 | – | – | 1 of 4 (25.0 %) | – |\n"
        );
        // Of two levels alike the same effect, with an error that is smaller by √2.
        assert_eq!(
            summary_of_module(&levels),
            "| module | 4, 0, 0 | 0, 4, 0 | -2.42 ± 0.73 | – | – | 2 of 8 (25.0 %) | – |\n"
        );
        let both = changes.and(Changes([[0, 36], [1, 40]]));
        assert_eq!(both, Changes([[1, 40], [1, 40]]));
        assert!(both.sentence().ends_with("is met."), "{}", both.sentence());
        assert!(changes.sentence().ends_with("is missed."));
        assert!(both.in_all_computations() && !changes.in_all_computations());
        let page = table(level);
        let row = "| score |  | 8.0000 ± 1.4142 (2) | 2.0000 ± 1.4142 (2) | -2.42 ± 1.03 | – | – |";
        assert!(page.contains(row), "{page}");
    }
}
