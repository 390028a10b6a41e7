//! Training after training in one process: shipped scripts of all modules in random order, each run recorded, some of them replayed. What one run
//! leaves behind in a process would be found in the next ones: a result that is not the script's, a hash that is not that of the same run before, memory that grows.

use crate::digests::{Subject, all};
use crate::{repository, scratch, tree};
use microsim_bus::Frames;
use microsim_host::assemble::{Input, Installation, Request, assemble, locate};
use microsim_host::plan::RunPlan;
use microsim_host::record::SessionReader;
use microsim_host::replay::{ReplayOptions, replay};
use microsim_host::run::{RunError, RunOptions, run};
use microsim_message::{ContactForces, SolverTick, TrainingResult, decode};
use microsim_random::SplitMix64;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Of so many runs one is replayed.
pub const REPLAYED: usize = 10;

/// A script of a level.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Exercise {
    /// The module.
    pub module: String,
    /// The level, from 1.
    pub level: u32,
    /// Name of the script, which begins with that of the level.
    pub script: String,
}

/// The order in which scripts are played: in each round every module once, in random order, with a random script.
#[derive(Debug)]
pub struct Order {
    modules: Vec<Vec<Exercise>>,
    random: SplitMix64,
    /// What is left of this round, the next one last.
    round: Vec<usize>,
}

impl Order {
    /// Of all shipped scripts, from a seed.
    pub fn new(seed: u64) -> Self {
        let mut modules: BTreeMap<String, Vec<Exercise>> = BTreeMap::new();
        for subject in all() {
            if let Subject::Script(module, script) = subject {
                let digits = script.trim_start_matches("level").chars();
                let digits: String = digits.take_while(char::is_ascii_digit).collect();
                let level = digits.parse().expect("a script of a level");
                let scripts = modules.entry(module.clone()).or_default();
                scripts.push(Exercise {
                    module,
                    level,
                    script,
                });
            }
        }
        Self::of(modules.into_values().collect(), seed)
    }

    fn of(modules: Vec<Vec<Exercise>>, seed: u64) -> Self {
        Self {
            modules,
            random: SplitMix64(seed),
            round: Vec::new(),
        }
    }
}

impl Iterator for Order {
    type Item = Exercise;

    /// There is always another one.
    fn next(&mut self) -> Option<Exercise> {
        if self.round.is_empty() {
            self.round = (0..self.modules.len()).collect();
            // Fisher and Yates.
            for last in (1..self.round.len()).rev() {
                let other = self.random.below(last as u64 + 1) as usize;
                self.round.swap(last, other);
            }
        }
        let scripts = &self.modules[self.round.pop()?];
        let which = self.random.below(scripts.len() as u64) as usize;
        scripts.get(which).cloned()
    }
}

/// What came of a run.
#[derive(Clone, Debug)]
pub struct Played {
    /// What was played.
    pub exercise: Exercise,
    /// Simulated time \[s\].
    pub simulated: f64,
    /// Time that it took \[s\].
    pub wall: f64,
    /// The physics digest.
    pub digest: String,
    /// Ticks with tissue.
    pub tissue: u64,
    /// Ticks in which the bodies were held, as nothing else contained their divergence.
    pub held: u64,
    /// Ticks whose forces mean nothing.
    pub invalid: u64,
    /// Whether it was replayed.
    pub replayed: bool,
    /// Resident memory before it, at most while it ran, and after it \[bytes\].
    pub memory: [u64; 3],
    /// What is wrong with it.
    pub faults: Vec<String>,
}

/// All runs so far, in this process.
#[derive(Debug)]
pub struct Training {
    installation: Installation,
    folder: tempfile::TempDir,
    /// Physics digests of scripts by their first runs.
    digests: BTreeMap<Exercise, String>,
    /// The runs.
    pub played: Vec<Played>,
}

impl Training {
    /// Nothing yet.
    ///
    /// # Errors
    /// Why the built tree cannot be used.
    pub fn new() -> Result<Self, String> {
        let installation = Installation::open(&tree(), None).map_err(|e| e.to_string())?;
        Ok(Self {
            installation,
            folder: scratch(),
            digests: BTreeMap::new(),
            played: Vec::new(),
        })
    }

    /// Plays a script, records it, looks through what was recorded and, every so many runs, computes it again.
    ///
    /// # Errors
    /// Why it could not begin, or nothing can be measured here.
    pub fn play(&mut self, exercise: Exercise) -> Result<&Played, String> {
        let text = |e: &dyn std::fmt::Display| format!("{}: {e}", exercise.script);
        let began = Instant::now();
        let before = resident()?;
        reset_peak()?;
        let session = self.folder.path().join("run.session");
        let plan = self.plan(&exercise, &session)?;
        let stop = AtomicBool::new(false);
        let options = RunOptions {
            threads: 1,
            realtime: None,
            pictures: None,
            resume: None,
            stop_at: None,
            stop: &stop,
            operator: None,
            trainee: None,
            session_id: None,
            unlisted: true,
            key: None,
            progress: &mut |_, _| {},
        };
        let outcome = run(&plan, options).map_err(|e| text(&e))?;
        let mut faults: Vec<String> = outcome.complaints.clone();
        faults.extend(outcome.failure.as_ref().map(|failure| failure.to_string()));
        match &outcome.result {
            None => faults.push("no result".to_owned()),
            Some(result) => faults.extend(other_result(&exercise.script, result)),
        }
        let recorded = Recorded::read(&session).map_err(|e| text(&e))?;
        if recorded.not_finite > 0 {
            let ticks = recorded.not_finite;
            faults.push(format!("{ticks} ticks with forces that are not finite"));
        }
        let digest = outcome.physics_digest;
        let first = self.digests.entry(exercise.clone());
        let first = first.or_insert_with(|| digest.clone());
        if *first != digest {
            faults.push(format!("digest {digest}, of the first run {first}"));
        }
        let replayed = (self.played.len() + 1).is_multiple_of(REPLAYED);
        if replayed {
            faults.extend(self.replay(&session, &outcome.state_hash)?);
        }
        fs::remove_file(&session).map_err(|e| text(&e))?;
        let peak = peak()?;
        self.played.push(Played {
            exercise,
            simulated: outcome.ticks as f64 * plan.tick_ns as f64 * 1e-9,
            wall: began.elapsed().as_secs_f64(),
            digest,
            tissue: recorded.tissue,
            held: recorded.held,
            invalid: recorded.invalid,
            replayed,
            memory: [before, peak, resident()?],
            faults,
        });
        Ok(self.played.last().expect("it was added"))
    }

    fn plan(&self, exercise: &Exercise, session: &Path) -> Result<RunPlan, String> {
        let Exercise {
            module,
            level,
            script,
        } = exercise;
        let path = repository().join(format!("modules/{module}/scripts/{script}.toml"));
        let input = Input::Script(path);
        let request = Request {
            module: module.clone(),
            level: *level,
            variant: None,
            input,
            hand: None,
            seed: 1,
            without: Vec::new(),
            pictures: false,
            session: session.to_path_buf(),
        };
        assemble(&self.installation, &request).map_err(|e| e.to_string())
    }

    /// What of a session is not computed again to the bit.
    fn replay(&self, session: &Path, hash: &str) -> Result<Vec<String>, String> {
        let file = File::open(session).map_err(|e| e.to_string())?;
        let mut reader = SessionReader::open(BufReader::new(file)).map_err(|e| e.to_string())?;
        let options = ReplayOptions {
            threads: 1,
            pictures: None,
            renderer: None,
        };
        let outcome = replay(&mut reader, options, |planned| {
            locate(&self.installation, planned).map_err(|e| RunError::Host(e.to_string()))
        });
        let outcome = outcome.map_err(|e| e.to_string())?;
        let mut faults = Vec::new();
        if let Some(difference) = outcome.difference {
            let (tick, what) = (difference.tick, difference.what);
            faults.push(format!("computed again: tick {tick}: {what}"));
        }
        for (what, other) in [
            ("computed again", Some(&outcome.state_hash)),
            ("recorded", outcome.recorded_hash.as_ref()),
        ] {
            if other.map(String::as_str) != Some(hash) {
                faults.push(format!("state hash {hash}, {what}: {other:?}"));
            }
        }
        Ok(faults)
    }

    /// Simulated time so far \[s\].
    pub fn simulated(&self) -> f64 {
        self.played.iter().map(|played| played.simulated).sum()
    }

    /// What is wrong with any run.
    pub fn faults(&self) -> Vec<String> {
        let of_run = |played: &Played| {
            let Exercise { module, script, .. } = &played.exercise;
            let name = format!("{module}/{script}");
            let faults = played.faults.iter();
            faults
                .map(|fault| format!("{name}: {fault}"))
                .collect::<Vec<_>>()
        };
        self.played.iter().flat_map(of_run).collect()
    }

    /// Resident memory before the first run, and after a quarter of the simulated time, half of it, and all of it.
    pub fn memory(&self) -> Memory {
        let all = self.simulated();
        let reached = |part: f64| {
            let mut simulated = 0.0;
            let found = self.played.iter().position(|played| {
                simulated += played.simulated;
                simulated >= part * all
            });
            found.unwrap_or(self.played.len().saturating_sub(1))
        };
        let after = |at: usize| self.played.get(at).map_or(0, |of| of.memory[2]);
        let mut modules = BTreeMap::new();
        for (at, played) in self.played.iter().enumerate() {
            modules.entry(&played.exercise.module).or_insert(at);
        }
        let loaded = modules.into_values().max().unwrap_or(0);
        let own = self
            .played
            .iter()
            .map(|of| of.memory[1].saturating_sub(of.memory[0]));
        Memory {
            start: self.played.first().map_or(0, |of| of.memory[0]),
            quarter: after(reached(0.25)),
            half: after(reached(0.5)),
            end: after(self.played.len().saturating_sub(1)),
            base: after(reached(0.25).max(loaded)),
            largest_run: own.max().unwrap_or(0),
        }
    }
}

/// Resident memory of a training \[bytes\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Before the first run.
    pub start: u64,
    /// After a quarter of the time.
    pub quarter: u64,
    /// After half of it.
    pub half: u64,
    /// After the last run.
    pub end: u64,
    /// After a quarter of the time, or later when the last of the modules has been played once: their libraries stay loaded.
    pub base: u64,
    /// What a run took at most, beyond what there was before it.
    pub largest_run: u64,
}

impl Memory {
    /// Whether nothing adds up. What a run has freed the allocator may hold back, so that between two runs there may be as much as one run takes and no more; what each of many
    /// runs left would exceed that.
    pub fn is_flat(&self) -> bool {
        let later = self.half.max(self.end);
        later <= self.base + self.largest_run
    }
}

/// What is wrong with a result: it is not that of the script's name.
fn other_result(script: &str, result: &TrainingResult) -> Option<String> {
    let kind = script.split_once('-').map_or("", |(_, kind)| kind);
    let expected: &[&str] = match kind.split_once('-') {
        Some(("fail", reason)) => &[reason],
        _ => &[],
    };
    let is_expected = result.not_judged.is_empty()
        && result.passed == expected.is_empty()
        && result.failed == expected;
    let verdict = match (result.not_judged.is_empty(), result.passed) {
        (false, _) => "not judged",
        (_, true) => "passed",
        (_, false) => "failed",
    };
    (!is_expected).then(|| format!("{verdict} {:?}", result.failed))
}

/// What a session shows of the solver.
#[derive(Default)]
struct Recorded {
    tissue: u64,
    held: u64,
    invalid: u64,
    not_finite: u64,
}

impl Recorded {
    fn read(session: &Path) -> Result<Self, String> {
        let file = File::open(session).map_err(|e| e.to_string())?;
        let mut reader = SessionReader::open(BufReader::new(file)).map_err(|e| e.to_string())?;
        let mut found = Self::default();
        while let Some((_, tick)) = reader.next_tick().map_err(|e| e.to_string())? {
            let mut finite = true;
            for frame in Frames::new(&tick.log) {
                let frame = frame.map_err(|e| e.to_string())?;
                if let Some(solver) = decode::<SolverTick>(&frame) {
                    let solver = solver.map_err(|e| e.to_string())?;
                    found.tissue += 1;
                    found.held += u64::from(solver.steps == 0);
                    found.invalid += u64::from(!solver.valid);
                    finite &= solver.residual.is_finite() && solver.force_residual.is_finite();
                }
                if let Some(forces) = decode::<ContactForces>(&frame) {
                    let forces = forces.map_err(|e| e.to_string())?;
                    let contacts = forces.contacts.iter().chain(&forces.between);
                    let numbers = contacts.flat_map(|of| {
                        let own = [of.peak_force, of.sustained_force, of.grip_force, of.depth];
                        of.force.into_iter().chain(of.point).chain(own)
                    });
                    finite &= numbers.into_iter().all(f64::is_finite);
                }
            }
            found.not_finite += u64::from(!finite);
        }
        Ok(found)
    }
}

/// A line of what the kernel reports of this process \[bytes\].
fn of_status(key: &str) -> Result<u64, String> {
    let status = fs::read_to_string("/proc/self/status").map_err(|e| e.to_string())?;
    let line = status.lines().find_map(|line| line.strip_prefix(key));
    let number = line.and_then(|rest| rest.trim().strip_suffix(" kB")?.parse::<u64>().ok());
    let number = number.ok_or_else(|| format!("/proc/self/status has no {key}"))?;
    Ok(1024 * number)
}

fn resident() -> Result<u64, String> {
    of_status("VmRSS:")
}

/// The largest since [`reset_peak`].
fn peak() -> Result<u64, String> {
    of_status("VmHWM:")
}

fn reset_peak() -> Result<(), String> {
    fs::write("/proc/self/clear_refs", "5").map_err(|e| format!("/proc/self/clear_refs: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::LocalText;

    fn exercise(module: &str, script: &str) -> Exercise {
        Exercise {
            module: module.to_owned(),
            level: 1,
            script: script.to_owned(),
        }
    }

    /// Three modules: every three runs all of them once; the same seed gives the same order, another one another.
    #[test]
    fn every_round_has_every_module_once() {
        let modules = || {
            let module = |name: &str| {
                ["level1-pass", "level1-fail-x"]
                    .map(|s| exercise(name, s))
                    .to_vec()
            };
            ["a", "b", "c"].map(module).to_vec()
        };
        let order = |seed| Order::of(modules(), seed).take(30).collect::<Vec<_>>();
        for round in order(1).chunks(3) {
            let mut names: Vec<&str> = round.iter().map(|of| of.module.as_str()).collect();
            names.sort_unstable();
            assert_eq!(names, ["a", "b", "c"]);
        }
        assert_eq!(order(1), order(1));
        assert_ne!(order(1), order(2));
    }

    #[test]
    fn results_are_those_of_the_names_of_scripts() {
        let result = |passed: bool, failed: &[&str], not_judged: usize| TrainingResult {
            passed,
            aborted: false,
            not_judged: vec![LocalText::new("-", "-"); not_judged],
            failed: failed.iter().map(|of| (*of).to_owned()).collect(),
            reasons: Vec::new(),
            duration: 1.0,
            targets_done: 1,
            targets: 1,
            metrics: Vec::new(),
            categories: Vec::new(),
            score: 1.0,
        };
        let passed = result(true, &[], 0);
        assert_eq!(other_result("level1-pass", &passed), None);
        assert_eq!(other_result("level1-miss-torn", &passed), None);
        assert!(other_result("level1-fail-torn", &passed).is_some());
        let failed = result(false, &["not-held"], 0);
        assert_eq!(other_result("level2-fail-not-held", &failed), None);
        assert!(other_result("level2-pass", &failed).is_some());
        let both = result(false, &["not-held", "torn"], 0);
        assert!(other_result("level2-fail-not-held", &both).is_some());
        assert!(other_result("level1-pass", &result(false, &[], 1)).is_some());
    }

    /// Runs that take 30 leave 2 each: after a quarter of ten 24 of what was 20 at the start; 60 at the end of 20 are more than one run can hold back.
    #[test]
    fn memory_that_adds_up_is_not_flat() {
        let memory = |quarter, half, end| Memory {
            start: 20,
            quarter,
            half,
            end,
            base: quarter,
            largest_run: 30,
        };
        assert!(memory(24, 30, 54).is_flat());
        assert!(!memory(24, 30, 60).is_flat());
        assert!(!memory(24, 55, 30).is_flat());
    }
}
