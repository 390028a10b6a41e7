//! A run of a random player, and what came of it.

use super::Player;
use super::cost::{Costs, PICTURE};
use super::hand::{Track, script};
use super::stage::Stage;
use crate::measured;
use crate::trainees::{ABSURD_FORCE, largest_force};
use crate::{command, report_beside};
use microsim_bus::{Frames, kind_id};
use microsim_host::record::Session;
use microsim_message::{Message, TissueCut, decode};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Pause between two looks at a running process.
const LOOK: Duration = Duration::from_millis(20);
/// How long a run that was asked to end may take to close its session and to write its report.
const GRACE: Duration = Duration::from_secs(90);
/// Before the first tick and after the last one a run may take so much CPU time \[s\].
const AROUND: f64 = 3.0;
/// Time within which what a profile is named for has to meet tissue to count as done on it \[s\].
const MEETS: f64 = 0.1;

/// When a run is too slow to wait for.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    /// CPU time per simulated time.
    pub cpu: f64,
    /// Wall-clock time per simulated time: for a process that waits for ever, on a machine that has other work.
    pub wall: f64,
}

impl Default for Guard {
    fn default() -> Self {
        Self {
            cpu: 20.0,
            wall: 100.0,
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ended {
    /// With a report.
    Report,
    /// It was too slow and was ended.
    Stalled,
    /// Otherwise: status and the end of standard error.
    Broken(String),
}

/// What the solver reported, in ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Solver {
    /// Ticks that were computed.
    pub ticks: u64,
    /// Ticks that left work to the next ones; `None` where the program does not report them.
    pub over_budget: Option<u64>,
    /// Ticks in which the bodies were held.
    pub held: u64,
    /// Ticks above the tolerance.
    pub unconverged: u64,
    /// Ticks whose forces mean nothing.
    pub invalid: u64,
    /// Ticks that were computed again.
    pub repeated: u64,
    /// The largest residual relative to the forces.
    pub worst_residual: f64,
}

/// What came of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Who played.
    pub player: Player,
    /// How it ended.
    pub ended: Ended,
    /// Verdict; empty without a report.
    pub verdict: String,
    /// Reasons against it.
    pub failed: Vec<String>,
    /// Targets reached, of all.
    pub targets: [u64; 2],
    /// Of a level that was passed: what its limited metrics came to.
    pub passed_by: String,
    /// Simulated time \[s\].
    pub simulated: f64,
    /// The solver; `None` of a level without tissue, and without a report.
    pub solver: Option<Solver>,
    /// Largest force of each tool on tissue \[N\].
    pub peaks: Vec<(String, f64)>,
    /// Largest grip \[N\].
    pub grip: f64,
    /// Ticks with a force of a tool above [`ABSURD_FORCE`].
    pub too_strong: u64,
    /// Whether all forces are finite.
    pub is_finite: bool,
    /// Ticks in which a tool touches tissue.
    pub contact: u64,
    /// What the profile is named for: how often, and how often on tissue.
    pub acts: [u64; 2],
    /// Full closures, and those on tissue.
    pub closures: [u64; 2],
    /// Ticks and tools that cut, from the session.
    pub cuts: u64,
    /// Contacts of tool with tool; `None` where the program does not report them.
    pub tools_touched: Option<u64>,
    /// CPU time of pictures.
    pub costs: Costs,
    /// CPU time of all ticks \[s\].
    pub cpu: f64,
    /// CPU time of the whole process, reading, report and trace included \[s\].
    pub process_cpu: f64,
}

impl Outcome {
    /// Largest force of a tool \[N\].
    pub fn peak(&self) -> f64 {
        self.peaks
            .iter()
            .map(|(_, force)| *force)
            .fold(0.0, f64::max)
    }

    /// Simulated time over the CPU time of its ticks.
    pub fn real_time_factor(&self) -> f64 {
        self.simulated / self.cpu
    }

    /// Ticks that were played.
    pub fn ticks(&self, stage: &Stage) -> u64 {
        (self.simulated / stage.tick).round() as u64
    }
}

/// Writes the script of a player into a folder; its path, and what its tools do.
///
/// # Errors
/// The file that cannot be written.
pub fn write(
    player: &Player,
    stage: &Stage,
    folder: &Path,
) -> Result<(PathBuf, Vec<Track>), String> {
    let (text, tracks) = script(player, stage);
    let path = folder.join(format!("{}.toml", player.name()));
    fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok((path, tracks))
}

/// Plays a player in a process of its own, all files in `folder`; what came of it, and its session.
///
/// # Errors
/// Why the run could not begin.
pub fn play(
    player: &Player,
    stage: &Stage,
    folder: &Path,
    guard: Guard,
) -> Result<(Outcome, PathBuf), String> {
    let (script, tracks) = write(player, stage, folder)?;
    let file = |extension: &str| script.with_extension(extension);
    let [session, trace, out, err] = ["session", "trace", "out", "err"].map(file);
    let mut run = command(["run", &player.module, "--json", "--no-pictures", "--level"]);
    run.arg(player.level.number.to_string());
    if let Some(variant) = &player.level.variant {
        run.arg("--variant").arg(variant);
    }
    run.arg("--input");
    run.arg(format!("script:{}", script.display()));
    run.arg("--session")
        .arg(&session)
        .arg("--trace")
        .arg(&trace);
    let create = |path: &Path| File::create(path).map_err(|e| format!("{}: {e}", path.display()));
    run.stdin(Stdio::null())
        .stdout(create(&out)?)
        .stderr(create(&err)?);
    let mut child = run.spawn().map_err(|e| format!("{run:?}: {e}"))?;
    let (ended, process_cpu) = watch(&mut child, player.seconds, guard)?;
    let read = |path: &Path| fs::read(path).unwrap_or_default();
    let errors = String::from_utf8_lossy(&read(&err)).into_owned();
    let printed: Value = serde_json::from_slice(&read(&out)).unwrap_or_default();
    let has_report = printed["report"].is_string() && file("json").is_file();
    let is_sound = !errors.contains("panicked") && printed["failure"].is_null();
    let ended = match ended {
        None => Ended::Stalled,
        Some(0) if has_report && is_sound => Ended::Report,
        Some(code) => {
            let last = errors.lines().rev().take(3).collect::<Vec<_>>();
            Ended::Broken(format!("status {code}: {}", last.join("; ")))
        }
    };
    let report = match has_report {
        true => report_beside(&session),
        false => Value::Null,
    };
    let (costs, cpu, ticks) = costs(&String::from_utf8_lossy(&read(&trace)), stage.tick);
    let outcome = Outcome {
        player: player.clone(),
        ended,
        verdict: printed["verdict"].as_str().unwrap_or_default().to_owned(),
        failed: texts(&printed["failed"]),
        targets: ["targets_done", "targets"].map(|key| printed[key].as_u64().unwrap_or_default()),
        passed_by: match printed["verdict"] == "passed" {
            true => limited(&report),
            false => String::new(),
        },
        simulated: stage.tick * ticks as f64,
        solver: solver(&printed["solver"]),
        cuts: cuts(&read(&session)),
        costs,
        cpu,
        process_cpu,
        ..touched(player, &report, &tracks)
    };
    Ok((outcome, session))
}

/// Waits for a run; its status, -1 for a signal, or `None` if it was ended because it was too slow; and its CPU time \[s\].
fn watch(child: &mut Child, seconds: f64, guard: Guard) -> Result<(Option<i32>, f64), String> {
    let start = Instant::now();
    let mut told: Option<Instant> = None;
    loop {
        let cpu = measured::cpu_time(child.id());
        if let Some((cpu, true)) = cpu {
            let status = child.wait().map_err(|e| e.to_string())?;
            let code = status.code().unwrap_or(-1);
            return Ok((told.is_none().then_some(code), cpu));
        }
        let used = cpu.map_or(0.0, |(cpu, _)| cpu);
        match told {
            None if used > guard.cpu * seconds + AROUND
                || start.elapsed().as_secs_f64() > guard.wall * (seconds + AROUND) =>
            {
                // As Ctrl-C: the level is aborted, session and report are written.
                let mut kill = Command::new("kill");
                let sent = kill.args(["-TERM", &child.id().to_string()]).status();
                sent.map_err(|e| format!("kill: {e}"))?;
                told = Some(Instant::now());
            }
            Some(told) if told.elapsed() > GRACE => child.kill().map_err(|e| e.to_string())?,
            _ => {}
        }
        std::thread::sleep(LOOK);
    }
}

/// CPU time of each tick in a trace, added up by pictures; all of it \[s\]; the number of ticks. A trace that breaks off counts until there.
fn costs(trace: &str, tick: f64) -> (Costs, f64, u64) {
    let (mut costs, mut all, mut ticks, mut picture) = (Costs::default(), 0.0, 0, 0.0);
    let per_picture = ((PICTURE / tick).round() as u64).max(1);
    for line in trace.lines().filter(|line| line.contains("\"cpu_us\"")) {
        let Ok(event) = serde_json::from_str::<Value>(line.trim_end_matches(',')) else {
            continue;
        };
        if event["name"] != "tick" || event["ph"] != "E" {
            continue;
        }
        let cpu = event["args"]["cpu_us"].as_str();
        let Some(cpu) = cpu.and_then(|cpu| cpu.parse::<f64>().ok()) else {
            continue;
        };
        all += 1e-6 * cpu;
        picture += 1e-3 * cpu;
        ticks += 1;
        if ticks % per_picture == 0 {
            costs.add(picture);
            picture = 0.0;
        }
    }
    (costs, all, ticks)
}

fn texts(list: &Value) -> Vec<String> {
    let list = list.as_array().into_iter().flatten();
    list.filter_map(Value::as_str).map(str::to_owned).collect()
}

fn solver(solver: &Value) -> Option<Solver> {
    let count = |key: &str| solver[key].as_u64();
    Some(Solver {
        ticks: count("ticks")?,
        over_budget: count("over_budget"),
        held: count("held")?,
        unconverged: count("unconverged")?,
        invalid: count("invalid")?,
        repeated: count("repeated")?,
        worst_residual: solver["residual"]["max"].as_f64()?,
    })
}

/// The metrics that have a limit, as an explanation of a verdict.
fn limited(report: &Value) -> String {
    let metrics = report["metrics"].as_array().into_iter().flatten();
    let limited = metrics.filter(|metric| !metric["limit"].is_null());
    let shown = limited.map(|metric| {
        let number = |key: &str| metric[key].as_f64();
        let unit = metric["display_unit"].as_str().unwrap_or_default();
        let value = number("display_value").map_or("not measured".into(), |v| format!("{v:.3}"));
        let bound = |sign: &str, key: &str| number(key).map(|b| format!(" {sign} {b:.3}"));
        let bounds = bound("≤", "display_max").or_else(|| bound("≥", "display_min"));
        format!(
            "{} {value}{} {unit}",
            metric["id"].as_str().unwrap_or_default(),
            bounds.unwrap_or_default()
        )
    });
    shown.collect::<Vec<_>>().join(", ")
}

/// Ticks and tools that cut.
fn cuts(session: &[u8]) -> u64 {
    let Ok(session) = Session::read(session) else {
        return 0;
    };
    let of_tick = |log: &[u8]| {
        let frames = Frames::new(log).filter_map(Result::ok);
        let cuts = frames.filter(|frame| frame.header.kind == kind_id(TissueCut::KIND));
        // What tore by itself has no tool.
        let by_tool = cuts.filter(|frame| {
            let cut = decode::<TissueCut>(frame).and_then(Result::ok);
            cut.is_some_and(|cut| !cut.tool.is_empty())
        });
        by_tool.count() as u64
    };
    session
        .ticks
        .iter()
        .map(|(_, tick)| of_tick(&tick.log))
        .sum()
}

/// What tools did to tissue, by the report; all else empty.
fn touched(player: &Player, report: &Value, tracks: &[Track]) -> Outcome {
    let tick = report["session"]["tick_s"].as_f64().unwrap_or(8e-3);
    let number = |time: f64| (time / tick).round() as u64;
    let mut all = BTreeSet::new();
    let mut outcome = Outcome {
        player: player.clone(),
        ended: Ended::Report,
        verdict: String::new(),
        failed: Vec::new(),
        targets: [0; 2],
        passed_by: String::new(),
        simulated: 0.0,
        solver: None,
        peaks: Vec::new(),
        grip: 0.0,
        too_strong: 0,
        is_finite: true,
        contact: 0,
        acts: [0; 2],
        closures: [0; 2],
        cuts: 0,
        tools_touched: report["solver"]["tool_contacts"].as_u64(),
        costs: Costs::default(),
        cpu: 0.0,
        process_cpu: 0.0,
    };
    for track in tracks {
        let forces = report["forces"].as_array().into_iter().flatten();
        let (mut peak, mut touched) = (0.0_f64, BTreeSet::new());
        for series in forces.filter(|series| series["tool"] == track.tool.as_str()) {
            let list = |key: &str| series[key].as_array().cloned().unwrap_or_default();
            let value = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
            touched.extend(list("time").iter().map(|time| number(value(time))));
            // What means nothing is in no metric and in no plot, and has to be a number all the same.
            let valid = list("valid");
            for (force, valid) in list("peak").iter().map(value).zip(&valid) {
                outcome.is_finite &= force.is_finite();
                if *valid == Value::Bool(true) {
                    outcome.too_strong += u64::from(force > ABSURD_FORCE);
                    peak = peak.max(force);
                }
            }
            for (grip, valid) in list("grip").iter().map(value).zip(&valid) {
                outcome.is_finite &= grip.is_finite();
                if *valid == Value::Bool(true) {
                    outcome.grip = outcome.grip.max(grip);
                }
            }
        }
        let end = report["simulated"].as_f64().unwrap_or_default();
        let count = |times: &[f64]| {
            let done = times.iter().filter(|time| **time <= end);
            let around = |time: f64| number((time - MEETS).max(0.0))..=number(time + MEETS);
            let on_tissue = done
                .clone()
                .filter(|time| touched.range(around(**time)).next().is_some());
            [done.count() as u64, on_tissue.count() as u64]
        };
        for (sum, times) in [
            (&mut outcome.acts, &track.acts),
            (&mut outcome.closures, &track.closures),
        ] {
            let counted = count(times);
            sum[0] += counted[0];
            sum[1] += counted[1];
        }
        outcome.peaks.push((track.tool.clone(), peak));
        all.extend(touched);
    }
    outcome.contact = all.len() as u64;
    debug_assert!(outcome.peak() <= largest_force(report) || report.is_null());
    outcome
}

#[cfg(test)]
mod tests {
    use super::costs;

    /// Ticks of 8 ms: two make a picture of 3 ms, the third begins another, and the last line breaks off.
    #[test]
    fn ticks_of_a_trace_make_pictures() {
        let tick = |ph: &str, us: u32| {
            format!(
                "{{\"name\":\"tick\",\"ph\":\"{ph}\",\"args\":{{\"tick\":\"1\",\"cpu_us\":\"{us}\"}}}},\n"
            )
        };
        let begin = "{\"name\":\"tick\",\"ph\":\"B\",\"args\":{\"tick\":\"1\"}},\n";
        let ticks = [1000, 2000, 500].map(|us| format!("{begin}{}", tick("E", us)));
        let trace = format!("[\n{}{begin}{}", ticks.concat(), &tick("E", 9)[..40]);
        let (costs, cpu, ticks) = costs(&trace, 8e-3);
        assert_eq!((costs.count(), costs.most, ticks), (1, 3.0, 3));
        assert!((cpu - 3.5e-3).abs() < 1e-12);
    }
}
