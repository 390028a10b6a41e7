//! `cargo xtask soak convergence`: how far the solver comes in every shipped script of a level with tissue, as the level is, at twice the iterations, half the tick,
//! on a finer mesh, and with one iteration in 48 ms, and what becomes of the verdict. Writes `tests/results/convergence.md` and `convergence.csv`.

use microsim_tests::changed_levels::{CHANGES, ChangedLevels, crippled};
use microsim_tests::digests::{Subject, all};
use microsim_tests::{report_beside, repository, scratch};
use serde_json::Value;
use std::fmt::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Runs at the same time, a process each.
const WORKERS: usize = 2;

/// The page, but for its table and list.
const PAGE: &str = include_str!("page.md");

/// Metrics of the largest forces \[mN\].
const PEAKS: [&str; 2] = ["peak-force", "peak-grip"];

/// What a run printed, and its peaks.
type Run = (Value, [Option<f64>; 2]);

fn main() {
    let folder = scratch();
    let mut csv = String::from(
        "levels,script,verdict,failed,ticks,above_tolerance,repeated,ruptured,invalid,contact_failures,residual_p50,residual_p99,residual_max,\
         force_residual_p50,force_residual_p99,force_residual_max,peak_force_mN,peak_grip_mN\n",
    );
    let mut others = Vec::new();
    let mut summary = String::from(
        "| module | levels | scripts | end as they are named | not judged | invalid ticks | change of peak force: median, 9 of 10, most | change of peak grip |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for module in ["coordination", "push-strip"] {
        let scripts: Vec<String> = all()
            .into_iter()
            .filter_map(|subject| match subject {
                Subject::Script(of, script) if of == module => Some(script),
                _ => None,
            })
            .collect();
        let mut shipped: Option<Vec<Run>> = None;
        for (levels, change) in CHANGES.into_iter().chain([("crippled", crippled as _)]) {
            let tree = ChangedLevels::new(module, change);
            let play = |script: &str| {
                let level = script.trim_start_matches("level");
                let level: String = level.chars().take_while(char::is_ascii_digit).collect();
                let path = repository().join(format!("modules/{module}/scripts/{script}.toml"));
                let input = format!("script:{}", path.display());
                let name = format!("{}-{module}-{script}.session", levels.replace(' ', "-"));
                let session = folder.path().join(name);
                let printed = tree.run(&session, &["--level", &level, "--input", &input]);
                let report = report_beside(&session);
                std::fs::remove_file(session).expect("the session that was written");
                (printed, PEAKS.map(|id| metric(&report, id)))
            };
            let runs = in_order(&scripts, play);
            let count = |is: &dyn Fn(&str, &Value) -> bool| {
                let runs = scripts.iter().zip(&runs);
                runs.filter(|(script, (printed, _))| is(script, printed))
                    .count()
            };
            let invalid = runs
                .iter()
                .filter_map(|(printed, _)| printed["solver"]["invalid"].as_u64());
            let peaks = match (&shipped, levels) {
                (Some(shipped), "twice the iterations" | "half the tick" | "finer mesh") => {
                    [0, 1].map(|peak| changes(shipped, &runs, peak)).join(" | ")
                }
                _ => " | ".to_owned(),
            };
            let line = format!(
                "| {module} | {levels} | {} | {} | {} | {} | {peaks} |",
                runs.len(),
                count(&ends_as_named),
                count(&|_, printed| printed["verdict"] == "not-judged"),
                invalid.sum::<u64>()
            );
            println!("{line}");
            let _ = writeln!(summary, "{line}");
            for (script, (printed, peaks)) in scripts.iter().zip(&runs) {
                if levels != "crippled" && !ends_as_named(script, printed) {
                    let verdict = printed["verdict"].as_str().unwrap_or_default();
                    let line = format!(
                        "- {module}, {levels}, `{script}`: {verdict} {}",
                        printed["failed"]
                    );
                    println!("{line}");
                    others.push(line);
                }
                csv.push_str(&row(levels, &format!("{module}/{script}"), printed, peaks));
            }
            shipped.get_or_insert(runs);
        }
    }
    if others.is_empty() {
        others.push("none.".to_owned());
    }
    let page = PAGE.replace("{table}", summary.trim_end());
    let page = page.replace("{others}", &others.join("\n"));
    let results = repository().join("tests/results");
    for (name, text) in [("convergence.csv", csv), ("convergence.md", page)] {
        std::fs::write(results.join(name), text).expect("tests/results can be written");
    }
    println!("{summary}\n{}", results.join("convergence.md").display());
}

/// The results of all scripts, in their order.
fn in_order(scripts: &[String], play: impl Fn(&str) -> Run + Sync) -> Vec<Run> {
    let results: Mutex<Vec<Run>> = Mutex::new(vec![Run::default(); scripts.len()]);
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some((at, script)) = {
            let at = next.fetch_add(1, Ordering::Relaxed);
            scripts.get(at).map(|script| (at, script))
        } {
            let result = play(script);
            results.lock().expect("no panic")[at] = result;
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(work);
        }
    });
    results.into_inner().expect("no panic")
}

/// Whether a script passes, or fails for the reason in its name alone.
fn ends_as_named(script: &str, printed: &Value) -> bool {
    let failed = printed["failed"].as_array().map_or(&[][..], Vec::as_slice);
    match script.split_once("-fail-") {
        // Also those that miss reference values.
        None => printed["verdict"] == "passed",
        Some((_, reason)) => printed["verdict"] == "failed" && failed == [Value::from(reason)],
    }
}

/// A metric in its display unit, where it was measured.
fn metric(report: &Value, id: &str) -> Option<f64> {
    let mut metrics = report["metrics"].as_array()?.iter();
    metrics.find(|metric| metric["id"] == id)?["display_value"].as_f64()
}

/// By how much a peak differs from that of the level as shipped, relative to it: median, what nine of ten runs do not exceed (nearest ranks), most.
fn changes(shipped: &[Run], runs: &[Run], peak: usize) -> String {
    let both = shipped.iter().zip(runs);
    let mut changes: Vec<f64> = both
        .filter_map(|((_, before), (_, after))| {
            let before = before[peak].filter(|before| *before > 0.0)?;
            Some((after[peak]? / before - 1.0).abs())
        })
        .collect();
    changes.sort_by(f64::total_cmp);
    let Some(most) = changes.last() else {
        return "–".to_owned();
    };
    let rank = |percent: usize| changes[(changes.len() * percent).div_ceil(100).max(1) - 1];
    let shown = [rank(50), rank(90), *most].map(|change| format!("{:.1}", 100.0 * change));
    format!("{} % of {}", shown.join(", "), changes.len())
}

fn row(levels: &str, script: &str, printed: &Value, peaks: &[Option<f64>; 2]) -> String {
    let solver = &printed["solver"];
    let failed = printed["failed"].as_array().map_or(&[][..], Vec::as_slice);
    let failed: Vec<&str> = failed.iter().filter_map(Value::as_str).collect();
    let mut row = format!(
        "{levels},{script},{},{},{},{},{},{},{},{}",
        printed["verdict"].as_str().unwrap_or_default(),
        failed.join(" "),
        solver["ticks"],
        solver["unconverged"],
        solver["repeated"],
        solver["ruptured"],
        solver["invalid"],
        solver["contact_failures"],
    );
    for quantiles in ["residual", "force_residual"] {
        for name in ["p50", "p99", "max"] {
            let value = solver[quantiles][name].as_f64().unwrap_or_default();
            let _ = write!(row, ",{value:.2e}");
        }
    }
    for peak in peaks {
        let _ = write!(
            row,
            ",{}",
            peak.map_or(String::new(), |peak| format!("{peak:.3}"))
        );
    }
    row.push('\n');
    row
}
