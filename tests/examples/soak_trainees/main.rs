//! `cargo xtask soak trainees -- MODULE LEVEL N FIRST_SEED`: N synthetic experts and N novices on a level, or on `all` of a module, two at a time; of each metric, each
//! category and the score mean and standard deviation of both groups, the effect size, and whether it has the intended sign. Writes
//! `tests/results/trainees.md`, where each level has a section. Every run counts; fails if one shows a force that cannot be.
//!
//! `-- MODULE LEVEL N FIRST_SEED --sensitivity`: the same of each trainee at twice the iterations, half the tick and one step finer mesh
//! ([`sensitivity`]); into `tests/results/sensitivity.md` and a table of all runs beside it. It may be stopped: runs in that table are not played again, but for one of each kind at each change.
//! The limits are those that were frozen ([`limits`]). If it plays all runs of the level as shipped, and the level has these limits still, it writes their section of `trainees.md` too.
//!
//! The groups differ by the numbers in `config/trainees.toml`. That a metric separates them shows that it measures what it should in
//! these motions; that people differ so, it does not show.

mod limits;
mod sensitivity;

use microsim_tests::sensitivity::KINDS as PROFILES;
use microsim_tests::statistics::{Group, corrected, effect_error, effect_size, probability};
use microsim_tests::trainees::{self, ABSURD_FORCE, TIME_METRICS};
use microsim_tests::{repository, tree};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What stands above the sections.
const HEAD: &str = include_str!("page.md");
const SENSITIVITY_HEAD: &str = include_str!("sensitivity.md");

/// An effect below this is none (Cohen 1988: 0.2 is small).
const SMALL: f64 = 0.2;
/// Groups differ where an effect as large has a lower probability without a difference, corrected for the number of rows.
const SIGNIFICANT: f64 = 0.05;
/// Runs at the same time, a process each.
const WORKERS: usize = 2;
/// Kinds of trainees: profile, and what a group of them is called.
const KINDS: [(&str, &str); 2] = [(PROFILES[0], "experts"), (PROFILES[1], "novices")];
/// Rows of the score below those of the metrics.
const TOTALS: [&str; 3] = [
    "**score**",
    "**score without the metrics of time**",
    "score of the metrics of time alone",
];

/// What came of one run.
struct Run {
    /// Profile and number.
    name: String,
    passed: bool,
    /// Whether it ended without a verdict, and so without scores.
    not_judged: bool,
    /// Whether all targets were reached.
    finished: bool,
    reasons: Vec<String>,
    /// The largest force of a tool on a body \[N\].
    largest_force: f64,
    /// Forces that jump up for one tick.
    jumps: usize,
    /// By row: metrics in their display units, scores.
    values: BTreeMap<Row, f64>,
}

/// A row of the table: metrics, then categories, then totals.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Row {
    Metric(String),
    Category(String),
    Total(usize),
}

/// What is known of a row.
#[derive(Clone)]
struct Kind {
    title: String,
    direction: String,
    limited: bool,
}

/// The runs of one kind of trainees.
struct Results {
    runs: Vec<Run>,
}

impl Run {
    fn of(name: String, report: &Value, kinds: &mut BTreeMap<Row, Kind>) -> Self {
        let mut values = BTreeMap::new();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        for metric in report["metrics"].as_array().into_iter().flatten() {
            let Some(value) = metric["display_value"].as_f64() else {
                continue;
            };
            let row = Row::Metric(text(&metric["id"]));
            let unit = match text(&metric["display_unit"]) {
                unit if unit.is_empty() => unit,
                unit => format!(" [{unit}]"),
            };
            kinds.entry(row.clone()).or_insert_with(|| Kind {
                title: text(&metric["title"]["en"]) + &unit,
                direction: text(&metric["direction"]),
                limited: !metric["limit"].is_null(),
            });
            values.insert(row, value);
        }
        let mut scored = |row: Row, title: &str, value: f64| {
            kinds.entry(row.clone()).or_insert_with(|| Kind {
                title: title.to_owned(),
                direction: "higher-is-better".to_owned(),
                limited: false,
            });
            values.insert(row, value);
        };
        let mut all = trainees::scores(report, &[]);
        let total = all.pop().map_or(f64::NAN, |(_, total)| total);
        let printed = report["score"].as_f64().unwrap_or(f64::NAN);
        let not_judged = report["verdict"] == "not-judged";
        // Sums of a dozen numbers up to 100.
        assert!(
            not_judged || (total - printed).abs() < 1e-9,
            "{name}: the score is {printed}, formed again {total}"
        );
        for (title, score) in all.into_iter().filter(|_| !not_judged) {
            let shown = format!("*{title}*");
            scored(Row::Category(title), &shown, score);
        }
        let without = trainees::scores(report, &TIME_METRICS).pop();
        let without = without.map_or(f64::NAN, |(_, total)| total);
        let metrics = report["metrics"].as_array().into_iter().flatten();
        let time: Vec<f64> = metrics
            .filter(|m| TIME_METRICS.iter().any(|id| m["id"] == *id))
            .filter_map(|m| m["score"].as_f64())
            .collect();
        let time = time.iter().sum::<f64>() / time.len() as f64;
        let totals = [total, without, time].into_iter().enumerate();
        for (at, score) in totals.filter(|_| !not_judged) {
            scored(Row::Total(at), TOTALS[at], score);
        }
        Self {
            name,
            passed: report["verdict"] == "passed",
            not_judged,
            finished: report["targets_done"] == report["targets"],
            reasons: report["failed"]
                .as_array()
                .into_iter()
                .flatten()
                .map(text)
                .collect(),
            largest_force: trainees::largest_force(report),
            jumps: trainees::jumps(report),
            values,
        }
    }
}

impl Results {
    /// Over all runs in which it was measured.
    fn of(&self, row: &Row) -> Vec<f64> {
        let values = self.runs.iter().filter_map(|run| run.values.get(row));
        values.copied().collect()
    }

    fn line(&self, name: &str) -> String {
        let count = |of: fn(&Run) -> bool| self.runs.iter().filter(|run| of(run)).count();
        let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
        for reason in self.runs.iter().flat_map(|run| &run.reasons) {
            *reasons.entry(reason).or_default() += 1;
        }
        let reasons: Vec<String> = reasons.iter().map(|(r, n)| format!("{r} {n}")).collect();
        format!(
            "- {name}: {} of {} finished (all targets reached), {} passed, {} not judged; reasons against: {}; {} with forces that jump up for one tick, {} with forces above {ABSURD_FORCE} N",
            count(|run| run.finished),
            self.runs.len(),
            count(|run| run.passed),
            count(|run| run.not_judged),
            match reasons.is_empty() {
                true => "none".to_owned(),
                false => reasons.join(", "),
            },
            count(|run| run.jumps > 0),
            count(|run| run.largest_force > ABSURD_FORCE)
        )
    }
}

/// Makes and runs the trainees: the reports of experts, then of novices, with their names, in the order of their numbers.
fn play(module: &str, level: u32, count: usize, first_seed: u64) -> Vec<Vec<(String, Value)>> {
    let folder = tempfile::tempdir().expect("a folder");
    let reports: Mutex<BTreeMap<usize, Value>> = Mutex::default();
    let next = AtomicUsize::new(0);
    let seed = |job: usize| first_seed + (job % count) as u64;
    let name = |job: usize| format!("{} {}", KINDS[job / count].0, seed(job));
    let work = || {
        loop {
            let job = next.fetch_add(1, Ordering::Relaxed);
            if job >= KINDS.len() * count {
                return;
            }
            let profile = KINDS[job / count].0;
            let script = trainees::make(module, level, profile, seed(job), folder.path());
            let (session, _, report) = trainees::run(module, level, &script);
            eprintln!(
                "  {}: {} {}",
                name(job),
                report["verdict"],
                report["failed"]
            );
            // The report is all that is needed, and forty sessions are large.
            std::fs::remove_file(session).expect("the session that was written");
            reports.lock().expect("no panic").insert(job, report);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(work);
        }
    });
    let reports = reports.into_inner().expect("no panic");
    let named = reports.into_iter().map(|(job, report)| (name(job), report));
    let named: Vec<_> = named.collect();
    named.chunks(count).map(<[_]>::to_vec).collect()
}

/// Writes the section of a level from the reports of each kind of trainees, by their names; whether no force is absurd.
fn write_level(
    module: &str,
    level: u32,
    first_seed: u64,
    reports: &[Vec<(String, Value)>],
) -> Result<bool, String> {
    let mut kinds = BTreeMap::new();
    let mut groups = KINDS.map(|_| Results { runs: Vec::new() });
    for (results, reports) in groups.iter_mut().zip(reports) {
        let run = |(name, report): &(String, Value)| Run::of(name.clone(), report, &mut kinds);
        results.runs = reports.iter().map(run).collect();
    }
    let section = section(module, level, first_seed, &groups, &kinds);
    println!("{section}");
    write_section(HEAD, "trainees.md", &section)?;
    let runs = groups.iter().flat_map(|results| &results.runs);
    let absurd: Vec<String> = runs
        .filter(|run| run.largest_force > ABSURD_FORCE)
        .map(|run| format!("{}: {:.3} N", run.name, run.largest_force))
        .collect();
    if !absurd.is_empty() {
        let absurd = absurd.join(", ");
        eprintln!("forces above {ABSURD_FORCE} N are a fault of the computation: {absurd}");
    }
    Ok(absurd.is_empty())
}

/// The section of a level.
fn section(
    module: &str,
    level: u32,
    first_seed: u64,
    [experts, novices]: &[Results; KINDS.len()],
    kinds: &BTreeMap<Row, Kind>,
) -> String {
    let mut out = format!(
        "## {module}, level {level}: {} and {} synthetic trainees\n\n`cargo xtask soak trainees -- {module} {level} {} {first_seed}`\n\n",
        experts.runs.len(),
        novices.runs.len(),
        experts.runs.len()
    );
    for (results, (_, name)) in [experts, novices].into_iter().zip(KINDS) {
        out.push_str(&results.line(name));
        out.push('\n');
    }
    let shown = |values: &[f64]| match (Group::of(values), values) {
        (Some(group), _) => format!(
            "{:.4} ± {:.4} ({})",
            group.mean, group.deviation, group.count
        ),
        (None, [value]) => format!("{value:.4} (1)"),
        (None, _) => "–".to_owned(),
    };
    out.push_str("\n| synthetic trainees | limit | experts: mean ± SD (n) | novices: mean ± SD (n) | d ± SE | p, corrected | novices should have | does d point there? |\n|---|---|---|---|---|---|---|---|\n");
    let effects: Vec<Option<(f64, f64)>> = kinds
        .keys()
        .map(|row| {
            let (a, b) = (Group::of(&experts.of(row))?, Group::of(&novices.of(row))?);
            effect_size(&a, &b).map(|d| (d, effect_error(&a, &b, d)))
        })
        .collect();
    let raw: Vec<f64> = effects
        .iter()
        .flatten()
        .map(|(d, error)| probability(*d, *error))
        .collect();
    let mut corrected = corrected(&raw).into_iter();
    for ((row, kind), effect) in kinds.iter().zip(effects) {
        let (a, b) = (experts.of(row), novices.of(row));
        let effect = effect.and_then(|(d, error)| Some((d, error, corrected.next()?)));
        let intended = match kind.direction.as_str() {
            "lower-is-better" => Some(("more", 1.0)),
            "higher-is-better" => Some(("less", -1.0)),
            _ => None,
        };
        let points = match (effect, intended) {
            (None, _) | (_, None) => "–",
            (Some((d, ..)), _) if d.abs() < SMALL => "no difference",
            (Some((.., p)), _) if p > SIGNIFICANT => "not distinguished",
            (Some((d, ..)), Some((_, sign))) if d * sign > 0.0 => "yes",
            _ => "**wrong way**",
        };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {} | {} | {points} |",
            kind.title,
            if kind.limited { "yes" } else { "" },
            shown(&a),
            shown(&b),
            effect.map_or("–".into(), |(d, error, _)| format!(
                "{d:+.2} ± {error:.2}"
            )),
            effect.map_or("–".into(), |(.., p)| format!("{p:.3}")),
            intended.map_or("–", |(word, _)| word),
        );
    }
    out
}

/// The page with the section of a level in place of the one that was there.
fn with_section(head: &str, page: &str, section: &str) -> String {
    let title = |section: &str| {
        let first = section.lines().next().unwrap_or_default();
        first.split(':').next().unwrap_or_default().to_owned()
    };
    let old = page
        .split("\n## ")
        .skip(1)
        .map(|rest| format!("## {}", rest.trim_end()));
    // Of which code its figures are stands below its title.
    let row = page.split_once("\n| command |").map(|(_, rest)| rest);
    let row = row
        .and_then(|rest| rest.split_once("\n\n"))
        .map(|(row, _)| row);
    let head = match (row, head.split_once('\n')) {
        (Some(row), Some((title, rest))) => format!("{title}\n\n| command |{row}\n{rest}"),
        _ => head.to_owned(),
    };
    let mut sections: Vec<String> = old.filter(|old| title(old) != title(section)).collect();
    sections.push(section.trim_end().to_owned());
    sections.sort();
    format!("{head}\n{}\n", sections.join("\n\n"))
}

/// What is asked for.
struct Order {
    module: String,
    levels: Vec<u32>,
    /// Trainees of each kind.
    count: usize,
    first_seed: u64,
    sensitivity: bool,
}

impl Order {
    fn of(mut args: Vec<String>) -> Result<Self, String> {
        let expected = "expected MODULE LEVEL N FIRST_SEED [--sensitivity]: a number of a level or \"all\", two trainees of each kind or more";
        let sensitivity = args.pop_if(|last| last == "--sensitivity").is_some();
        let [module, level, count, first_seed] = &args[..] else {
            return Err(expected.to_owned());
        };
        let levels = match (&level[..], level.parse()) {
            (_, Ok(level)) => vec![level],
            ("all", _) => levels_of(module)?,
            _ => return Err(expected.to_owned()),
        };
        match (count.parse(), first_seed.parse()) {
            (Ok(count @ 2..), Ok(first_seed)) => Ok(Self {
                module: module.clone(),
                levels,
                count,
                first_seed,
                sensitivity,
            }),
            _ => Err(expected.to_owned()),
        }
    }
}

/// The levels of a module, 1 and so on.
fn levels_of(module: &str) -> Result<Vec<u32>, String> {
    let folder = tree().join("modules").join(module).join("levels");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    // Beside them may lie a folder of meshes, and variants.
    let is_level = |path: &std::path::Path| path.is_file() && !microsim_tests::is_variant(path);
    let files = entries.flatten().filter(|entry| is_level(&entry.path()));
    Ok((1..=files.count() as u32).collect())
}

fn main() -> ExitCode {
    let order = match Order::of(std::env::args().skip(1).collect()) {
        Ok(order) => order,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    eprintln!("in {}", tree().display());
    let mut sound = true;
    for &level in &order.levels {
        let done = match order.sensitivity {
            true => study_sensitivity(&order, level),
            false => {
                let reports = play(&order.module, level, order.count, order.first_seed);
                write_level(&order.module, level, order.first_seed, &reports)
            }
        };
        match done {
            Ok(no_absurd_force) => sound &= no_absurd_force,
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    if sound {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Studies a level; whether no force as shipped is absurd.
fn study_sensitivity(order: &Order, level: u32) -> Result<bool, String> {
    let Order {
        module,
        count,
        first_seed,
        ..
    } = order;
    let csv = format!("tests/results/sensitivity/{module}-{level}.csv");
    let mut sound = true;
    sensitivity::study(
        module,
        level,
        *count,
        *first_seed,
        &repository().join(csv),
        |reports| {
            sound = write_level(module, level, *first_seed, reports)?;
            Ok(())
        },
        |section| {
            println!("{section}");
            write_section(SENSITIVITY_HEAD, "sensitivity.md", section)
        },
    )?;
    Ok(sound)
}

/// Puts the section of a level into its page.
fn write_section(head: &str, page: &str, section: &str) -> Result<(), String> {
    let path = repository().join("tests/results").join(page);
    let page = std::fs::read_to_string(&path).unwrap_or_default();
    std::fs::write(&path, with_section(head, &page, section))
        .map_err(|error| format!("{}: {error}", path.display()))
}
