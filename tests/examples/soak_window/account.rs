//! What is read of a window from outside: its memory, and its log.

use microsim_tests::report_beside;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Resident memory \[MB\] of 10⁶ bytes, over time \[s\].
#[derive(Debug, Default)]
pub struct Memory {
    pub all: Vec<(f64, f64)>,
    /// In the launcher, after each level: what a level needs is given back by then.
    pub resting: Vec<(f64, f64)>,
}

/// A straight line through measurements, at least four: its slope, and the standard error of that.
pub fn slope(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    if points.len() < 4 {
        return None;
    }
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let [x, y] = [mean(|p| p.0), mean(|p| p.1)];
    let spread: f64 = points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    let rest = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2));
    let error = (rest.sum::<f64>() / (n - 2.0) / spread).sqrt();
    Some((slope, error))
}

/// Looks at the memory of a process every second.
pub struct Watch {
    process: u32,
    start: Instant,
    is_over: Arc<AtomicBool>,
    thread: JoinHandle<()>,
    memory: Arc<Mutex<Memory>>,
}

/// Resident memory of a process now \[MB\] of 10⁶ bytes; none where it has ended.
pub fn resident(process: u32) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kib * 1024.0 / 1e6)
}

pub fn watch(process: u32) -> Watch {
    let (is_over, memory) = (
        Arc::new(AtomicBool::new(false)),
        Arc::new(Mutex::new(Memory::default())),
    );
    let start = Instant::now();
    let seat = (Arc::clone(&is_over), Arc::clone(&memory));
    let thread = std::thread::spawn(move || {
        while !seat.0.load(Ordering::Relaxed) {
            if let Some(now) = resident(process) {
                let mut memory = seat.1.lock().expect("no panic");
                memory.all.push((start.elapsed().as_secs_f64(), now));
            }
            std::thread::sleep(Duration::from_secs(1));
        }
    });
    Watch {
        process,
        start,
        is_over,
        thread,
        memory,
    }
}

impl Watch {
    /// Notes what it is now, in the launcher.
    pub fn rest(&self) {
        if let Some(now) = resident(self.process) {
            let mut memory = self.memory.lock().expect("no panic");
            memory
                .resting
                .push((self.start.elapsed().as_secs_f64(), now));
        }
    }

    pub fn stop(self) -> Memory {
        self.is_over.store(true, Ordering::Relaxed);
        self.thread.join().expect("no panic");
        std::mem::take(&mut self.memory.lock().expect("no panic"))
    }
}

/// A run as the log states it.
#[derive(Clone, Debug)]
pub struct Shown {
    pub module: String,
    pub level: u32,
    /// Its recording.
    pub session: PathBuf,
    /// Length of a tick \[ms\]: simulated time over ticks.
    pub tick: f64,
    pub values: BTreeMap<String, String>,
}

impl Shown {
    /// A number; not a number where the log has none.
    pub fn number(&self, name: &str) -> f64 {
        self.values
            .get(name)
            .and_then(|value| value.parse().ok())
            .unwrap_or(f64::NAN)
    }
}

/// The whole log.
pub fn log(folder: &Path) -> Result<String, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .map_err(failed)?
        .flatten()
        .map(|entry| entry.path())
        .collect();
    files.sort();
    files
        .iter()
        .map(|file| fs::read_to_string(file).map_err(failed))
        .collect()
}

/// Lines about a panic, or an error, each with how often it is there; times of lines of the log are left out.
pub fn panics(text: &str) -> Vec<String> {
    let is = |line: &&str| {
        line.contains("panicked at") || line.contains(" ERROR ") || line.starts_with("ERROR")
    };
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for line in text.lines().filter(is) {
        let begin = line.find("ERROR").unwrap_or_default();
        *counts.entry(&line[begin..]).or_default() += 1;
    }
    let counts = counts.into_iter();
    counts
        .map(|(line, count)| format!("it reports {count} times: {line}"))
        .collect()
}

/// When a session was begun \[ms since 1970\], and of what level, by its name.
fn begin(session: &Path) -> Option<(u64, String, u32)> {
    let name = session.file_stem()?.to_str()?;
    let (rest, _) = name.rsplit_once('-')?;
    let (level, begin) = rest.rsplit_once('-')?;
    let (module, level) = level.rsplit_once("-level")?;
    Some((begin.parse().ok()?, module.into(), level.parse().ok()?))
}

/// Milliseconds since 1970 of a moment as the log writes it, such as `2026-11-26T23:07:42.464980Z` (days from the civil calendar after Hinnant 2013).
fn moment(text: &str) -> Option<u64> {
    let number = |range: std::ops::Range<usize>| text.get(range)?.parse::<u64>().ok();
    let [year, month, day] = [number(0..4)?, number(5..7)?, number(8..10)?];
    let [hours, minutes, seconds, millis] = [
        number(11..13)?,
        number(14..16)?,
        number(17..19)?,
        number(20..23)?,
    ];
    // Years begin in March.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day - 1;
    let days = days.checked_sub(719_468)?;
    Some((((days * 24 + hours) * 60 + minutes) * 60 + seconds) * 1000 + millis)
}

/// The runs of the log, each with its level: that of the session that was begun last before its line. One that was left before it was begun to be played has no line.
pub fn shown(log: &str, sessions: &BTreeSet<PathBuf>) -> Vec<Shown> {
    let mut begun: Vec<_> = sessions
        .iter()
        .filter_map(|path| Some((begin(path)?, path)))
        .collect();
    begun.sort();
    let lines = log.lines().filter(|line| line.contains("a run was shown"));
    let of = |line: &str| {
        let now = moment(line)?;
        let ((_, module, level), path) = begun.iter().rev().find(|((then, ..), _)| *then <= now)?;
        let pairs = line
            .split_whitespace()
            .filter_map(|word| word.split_once('='));
        let pairs =
            pairs.map(|(name, value)| (name.to_owned(), value.trim_matches('"').to_owned()));
        let mut run = Shown {
            module: module.clone(),
            level: *level,
            session: (*path).clone(),
            tick: f64::NAN,
            values: pairs.collect(),
        };
        // A window that broke down leaves no report.
        let has_report = path.with_extension("json").exists();
        let report = has_report.then(|| report_beside(path));
        let simulated = report.and_then(|report| report["simulated"].as_f64());
        run.tick = 1e3 * simulated.unwrap_or(f64::NAN) / run.number("ticks");
        Some(run)
    };
    lines.filter_map(of).collect()
}
