//! Levels in the variant `dissertation`, beside themselves: what comes of all of their scripts.

use microsim_tests::{microsim, repository, scratch};
use serde_json::Value;
use std::fmt::Write as _;

/// The levels that have the variant.
const LEVELS: [(&str, u32); 2] = [("push-strip", 2), ("coordination", 2)];

/// Measures and describes it.
pub fn measure(text: &mut String) -> Result<crate::Drawings, String> {
    let _ = writeln!(
        text,
        "\n## Levels as in 2015\n\n`microsim run MODULE --level N --variant dissertation`: springs and volume forces with the printed constants of each element (4.1, 4.2), velocity Verlet, spatial hash, target forces, in coordination also grip by the box \
         and cutting by penetration, semi-progressive. All scripts of the level run on it as they are; nothing was tuned for the verdicts. Held: ticks that were held, that no try made valid, or in which tools stood. Verified: replayed to the bit.\n\n\
         | script | as shipped | score | variant | score | held | verified |\n|---|---|---|---|---|---|---|"
    );
    for (module, level) in LEVELS {
        for script in scripts(module, level)? {
            let shipped = run(module, level, &script, None)?;
            let variant = run(module, level, &script, Some("dissertation"))?;
            let _ = writeln!(
                text,
                "| {module} `{script}` | {} | {} | {} | {} | {} | {} |",
                shipped.verdict,
                shipped.score,
                variant.verdict,
                variant.score,
                variant.held,
                variant.verified,
            );
        }
    }
    Ok(Vec::new())
}

/// The scripts of a level.
fn scripts(module: &str, level: u32) -> Result<Vec<String>, String> {
    let folder = repository().join(format!("modules/{module}/scripts"));
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let names = entries
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names
        .filter(|name| name.starts_with(&format!("level{level}-")))
        .collect();
    names.sort();
    Ok(names)
}

struct Outcome {
    verdict: String,
    score: String,
    held: u64,
    verified: &'static str,
}

fn run(module: &str, level: u32, script: &str, variant: Option<&str>) -> Result<Outcome, String> {
    let folder = scratch();
    let session = folder.path().join("run.session");
    let session = session.to_string_lossy().into_owned();
    let (level, input) = (level.to_string(), format!("script:{script}"));
    let mut arguments = vec![
        "run",
        module,
        "--level",
        &level,
        "--input",
        &input,
        "--no-store",
        "--json",
        "--session",
        &session,
    ];
    if let Some(variant) = variant {
        arguments.extend(["--variant", variant]);
    }
    let finished = microsim(&arguments);
    let document: Value = serde_json::from_str(&finished.out).map_err(|_| finished.err.clone())?;
    let failed = document["failed"].as_array().into_iter().flatten();
    let failed: Vec<&str> = failed.filter_map(Value::as_str).collect();
    let verdict = document["verdict"].as_str().unwrap_or_default();
    let verdict = match failed.is_empty() {
        true => verdict.to_owned(),
        false => format!("{verdict}: {}", failed.join(", ")),
    };
    let score = document["score"]
        .as_f64()
        .map_or("–".into(), |score| format!("{score:.0}"));
    let count = |key: &str| document["solver"][key].as_u64().unwrap_or_default();
    // Those of the level itself are verified by the tests.
    let is_verified =
        variant.is_some() && microsim(["replay", &session, "--verify"]).code == Some(0);
    Ok(Outcome {
        verdict,
        score,
        held: count("held") + count("tools_stood") + count("invalid"),
        verified: if is_verified { "yes" } else { "no" },
    })
}
