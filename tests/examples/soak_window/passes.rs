//! Every level, played with mouse and keyboard until it is passed.

use crate::player::{Player, data_folder};
use crate::strokes::Strokes;
use crate::{Level, levels};
use microsim_host::assemble::known_metrics;
use microsim_settings::{load_desktop, load_level, load_manifest, load_script};
use microsim_tests::desktop::Display;
use microsim_tests::peers::Peer;
use microsim_tests::{command, finish, repository, scratch};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How often somebody tries.
const ATTEMPTS: u32 = 3;
/// How long the level may go on once all is done \[s\].
const REST: u64 = 12;

/// One attempt.
#[derive(Debug)]
pub struct Attempt {
    level: Level,
    number: u32,
    /// The report, or why there is none.
    report: Result<Value, String>,
    /// Whether its recording leads to the same states in a fresh process, where it was passed.
    replays: Option<bool>,
}

impl Attempt {
    fn passed(&self) -> bool {
        matches!(&self.report, Ok(report) if report["verdict"] == "passed")
    }
}

/// What the player does for a level.
fn strokes(level: &Level) -> Result<Vec<(Vec<String>, f64)>, String> {
    let root = repository();
    let module = root.join("modules").join(&level.module);
    let manifest = load_manifest(&module.join("module.toml")).map_err(|e| e.to_string())?;
    let file = module.join(format!("levels/level{}.toml", level.number));
    let settings = load_level(&file, &manifest.settings, &known_metrics());
    let settings = settings.map_err(|e| e.to_string())?.settings;
    let script = module.join(format!("scripts/level{}-pass.toml", level.number));
    let script = load_script(&script).map_err(|e| e.to_string())?.settings;
    let script = script.motion().map_err(|e| e.to_string())?;
    let desktop = load_desktop(&root.join("config/desktop.toml")).map_err(|e| e.to_string())?;
    let tools = settings.tool.iter().map(|tool| tool.name.clone()).collect();
    Ok(Strokes::new(tools, settings.view, desktop.settings).of(&script))
}

fn attempt(player: &mut Player<'_>, level: &Level) -> Result<(Value, PathBuf), String> {
    let commands = strokes(level)?;
    player.focus()?;
    let session = player.begin_at_once(level.place, level.number)?;
    player.perform(&session, &commands)?;
    let start = Instant::now();
    while !player.has_ended(&session) && start.elapsed() < Duration::from_secs(REST) {
        player.wait(0.2);
    }
    // For whoever wants to know what it looked like.
    let name = format!("soak-window-{}-{}", level.module, level.number);
    let seen = std::env::temp_dir().join(name);
    player.display.keep(&seen.with_extension("png"));
    player.end(&session)?;
    player.to_modules()?;
    let recorded = seen.with_extension("session");
    fs::copy(&session, &recorded).map_err(|e| format!("{}: {e}", recorded.display()))?;
    let report = session.with_extension("json");
    let text = fs::read(&report).map_err(|e| format!("{}: {e}", report.display()))?;
    let report: Value =
        serde_json::from_slice(&text).map_err(|e| format!("{}: {e}", report.display()))?;
    let begun = &report["session"];
    if begun["module"] != level.module.as_str() || begun["level"] != level.number {
        return Err(format!("{begun} was begun"));
    }
    Ok((report, session))
}

/// Plays the levels of those modules whose names begin so, or those of one number, in a new window, each until it is passed or was tried often enough.
pub fn play(module: &str, number: Option<u32>) -> Result<Vec<Attempt>, String> {
    let levels: Vec<Level> = levels()
        .into_iter()
        .filter(|level| level.module.starts_with(module))
        .filter(|level| number.is_none_or(|only| only == level.number))
        .collect();
    if levels.is_empty() {
        let level = number.map_or_else(String::new, |number| format!(" with a level {number}"));
        return Err(format!("no module's name begins with \"{module}\"{level}"));
    }
    let folder = scratch();
    let data = data_folder(folder.path())?;
    let display = Display::open()?;
    let mut window = display.program(&data, ["window", "--lang", "en", "--size", "1280x720"]);
    let window = window.spawn().map_err(|e| format!("the program: {e}"))?;
    let _window = Peer(window);
    let mut player = Player::new(&display, 1, &data);
    player.focus()?;
    player.wait(3.0);
    let mut attempts: Vec<Attempt> = Vec::new();
    for level in levels {
        for number in 1..=ATTEMPTS {
            let (report, replays) = match attempt(&mut player, &level) {
                Ok((report, session)) => {
                    let passed = report["verdict"] == "passed";
                    let replays = passed.then(|| {
                        let mut replay = command(["replay", "--verify", "--threads", "1"]);
                        finish(replay.arg(&session)).code == Some(0)
                    });
                    (Ok(report), replays)
                }
                Err(why) => (Err(why), None),
            };
            let last = Attempt {
                level: level.clone(),
                number,
                report,
                replays,
            };
            eprint!("{}", line(&last));
            let is_over = last.passed() || last.report.is_err();
            attempts.push(last);
            if is_over {
                break;
            }
        }
    }
    Ok(attempts)
}

fn line(attempt: &Attempt) -> String {
    let level = format!("{} {}", attempt.level.module, attempt.level.number);
    match &attempt.report {
        Err(why) => format!(
            "| {level} | {} | broken off: {why} | | | | |\n",
            attempt.number
        ),
        Ok(report) => {
            let verdict = report["verdict"].as_str().unwrap_or("none");
            let reasons = report["reasons"].as_array().into_iter().flatten();
            let reasons: Vec<String> = reasons
                .map(|r| {
                    r["en"]
                        .as_str()
                        .map_or_else(|| r.to_string(), str::to_owned)
                })
                .collect();
            let solver = &report["solver"];
            let ticks = match solver["ticks"].as_u64() {
                Some(ticks) => format!("{} of {ticks}", solver["held"]),
                None => "no tissue".into(),
            };
            format!(
                "| {level} | {} | {verdict} | {} | {:.1} | {ticks} | {} |\n",
                attempt.number,
                reasons.join("; "),
                report["simulated"].as_f64().unwrap_or(f64::NAN),
                match attempt.replays {
                    None => "",
                    Some(true) => "same states",
                    Some(false) => "differs",
                }
            )
        }
    }
}

/// The page of all attempts, and whether all is as it should be.
pub fn page(attempts: &[Attempt]) -> (String, bool) {
    let mut table = "| level | attempt | verdict | reasons | simulated s | ticks held | replay |\n|---|---|---|---|---|---|---|\n".to_owned();
    let mut faults = Vec::new();
    let mut passed = 0;
    let mut played = 0;
    for (n, attempt) in attempts.iter().enumerate() {
        table += &line(attempt);
        let is_last = attempts
            .get(n + 1)
            .is_none_or(|next| next.level != attempt.level);
        let level = format!("{} level {}", attempt.level.module, attempt.level.number);
        if is_last {
            played += 1;
            match attempt.passed() {
                true => passed += 1,
                false => faults.push(format!("{level} was not passed")),
            }
        }
        if attempt.replays == Some(false) {
            faults.push(format!("{level} does not replay"));
        }
        // Modules without tissue have no solver.
        let held = attempt.report.as_ref().ok();
        let held = held
            .and_then(|report| report["solver"]["held"].as_u64())
            .unwrap_or_default();
        if attempt.passed() && held > 0 {
            faults.push(format!("{level} was passed with {held} ticks held"));
        }
    }
    let faults_text = match faults.is_empty() {
        true => "none".into(),
        false => faults.join("; "),
    };
    let text = format!(
        "# Every level passed with mouse and keyboard\n\nCommand: `cargo xtask soak window -- passes`. One window of 1280 × 720 pixels in low quality, on a display and with a driver of the processor, moved from outside by pointer and keys; \
         nothing in the program knows of it. The player does what the script that passes does, with one hand after the other (where both move at once in the script: in turns), without looking, as somebody who practised it; it begins with \
         the pose in which the window has the instruments. Of three attempts at most the first is taken that passes; the last column compares the states of its recording with a fresh process on one thread.\n\n\
         {passed} of {played} levels were passed, in {} attempts. Faults: {faults_text}.\n\n{table}",
        attempts.len(),
    );
    (text, faults.is_empty())
}
