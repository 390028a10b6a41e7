//! `cargo xtask soak convergence`: how far the solver comes in every shipped script of a level with tissue, as the level is, at twice the iterations, half the tick,
//! on a finer mesh, and with one iteration in 48 ms, and what becomes of the verdict. Writes `tests/results/convergence.csv`.

use microsim_tests::changed_levels::{CHANGES, ChangedLevels, crippled};
use microsim_tests::digests::{Subject, all};
use microsim_tests::{repository, scratch};
use serde_json::Value;
use std::fmt::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Runs at the same time, a process each.
const WORKERS: usize = 2;

fn main() {
    let folder = scratch();
    let mut csv = String::from(
        "levels,script,verdict,failed,ticks,above_tolerance,repeated,ruptured,invalid,contact_failures,residual_p50,residual_p99,residual_max,\
         force_residual_p50,force_residual_p99,force_residual_max\n",
    );
    let mut summary = String::from(
        "| module | levels | scripts | end as they are named | not judged | invalid ticks |\n|---|---|---|---|---|---|\n",
    );
    for module in ["coordination", "push-strip"] {
        let scripts: Vec<String> = all()
            .into_iter()
            .filter_map(|subject| match subject {
                Subject::Script(of, script) if of == module => Some(script),
                _ => None,
            })
            .collect();
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
                std::fs::remove_file(session).expect("the session that was written");
                printed
            };
            let runs = in_order(&scripts, play);
            let count = |is: &dyn Fn(&str, &Value) -> bool| {
                let runs = scripts.iter().zip(&runs);
                runs.filter(|(script, printed)| is(script, printed)).count()
            };
            let invalid = runs
                .iter()
                .filter_map(|run| run["solver"]["invalid"].as_u64());
            let line = format!(
                "| {module} | {levels} | {} | {} | {} | {} |",
                runs.len(),
                count(&ends_as_named),
                count(&|_, printed| printed["verdict"] == "not-judged"),
                invalid.sum::<u64>()
            );
            println!("{line}");
            let _ = writeln!(summary, "{line}");
            for (script, printed) in scripts.iter().zip(&runs) {
                if levels != "crippled" && !ends_as_named(script, printed) {
                    println!("  {script}: {} {}", printed["verdict"], printed["failed"]);
                }
                csv.push_str(&row(levels, &format!("{module}/{script}"), printed));
            }
        }
    }
    let file = repository().join("tests/results/convergence.csv");
    std::fs::write(&file, csv).expect("tests/results can be written");
    println!("{summary}\n{}", file.display());
}

/// The results of all scripts, in their order.
fn in_order(scripts: &[String], play: impl Fn(&str) -> Value + Sync) -> Vec<Value> {
    let results: Mutex<Vec<Value>> = Mutex::new(vec![Value::Null; scripts.len()]);
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
        None => printed["verdict"] == "passed",
        Some((_, reason)) => printed["verdict"] == "failed" && failed == [Value::from(reason)],
    }
}

fn row(levels: &str, script: &str, printed: &Value) -> String {
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
    row.push('\n');
    row
}
