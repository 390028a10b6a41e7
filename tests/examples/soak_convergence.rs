//! `cargo xtask soak convergence`: how far the solver comes in every shipped script of a level with tissue, as the level is and with one
//! iteration in 48 ms, and what becomes of the verdict. Writes `tests/results/convergence.csv`.

use microsim_tests::changed_levels::{ChangedLevels, crippled};
use microsim_tests::digests::{Subject, all};
use microsim_tests::{repository, scratch};
use serde_json::Value;
use std::fmt::Write as _;

fn main() {
    let folder = scratch();
    let mut csv = String::from(
        "levels,script,verdict,failed,ticks,above_tolerance,repeated,invalid,contact_failures,residual_p50,residual_p99,residual_max,\
         force_residual_p50,force_residual_p99,force_residual_max\n",
    );
    let mut worst = Vec::new();
    for module in ["coordination", "push-strip"] {
        for (levels, change) in [
            ("shipped", str::to_owned as fn(&str) -> String),
            ("crippled", crippled),
        ] {
            let tree = ChangedLevels::new(module, change);
            let mut judged = [0, 0];
            for subject in all() {
                let Subject::Script(of, script) = subject else {
                    continue;
                };
                if of != module {
                    continue;
                }
                let level = script.trim_start_matches("level");
                let level: String = level.chars().take_while(char::is_ascii_digit).collect();
                let path = repository().join(format!("modules/{module}/scripts/{script}.toml"));
                let input = format!("script:{}", path.display());
                let session = folder
                    .path()
                    .join(format!("{levels}-{module}-{script}.session"));
                let printed = tree.run(&session, &["--level", &level, "--input", &input]);
                let row = row(levels, &format!("{module}/{script}"), &printed);
                print!("{row}");
                csv.push_str(&row);
                judged[usize::from(printed["verdict"] == "not-judged")] += 1;
            }
            let [judged, not_judged] = judged;
            worst.push(format!(
                "{module}, levels as {levels}: {judged} judged, {not_judged} not judged"
            ));
        }
    }
    let file = repository().join("tests/results/convergence.csv");
    std::fs::write(&file, csv).expect("tests/results can be written");
    println!("{}\n{}", worst.join("\n"), file.display());
}

fn row(levels: &str, script: &str, printed: &Value) -> String {
    let solver = &printed["solver"];
    let failed = printed["failed"].as_array().map_or(&[][..], Vec::as_slice);
    let failed: Vec<&str> = failed.iter().filter_map(Value::as_str).collect();
    let mut row = format!(
        "{levels},{script},{},{},{},{},{},{},{}",
        printed["verdict"].as_str().unwrap_or_default(),
        failed.join(" "),
        solver["ticks"],
        solver["unconverged"],
        solver["repeated"],
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
