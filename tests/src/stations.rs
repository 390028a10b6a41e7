//! Folders of users, with trainees and a store of their own, and runs of which some are killed.

use crate::{Finished, command, finish};
use microsim_host::record::{Session, kind};
use microsim_random::SplitMix64;
use microsim_session::Reader;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A station with a data folder of its own, gone after the test.
#[derive(Debug)]
pub struct Station {
    folder: tempfile::TempDir,
}

impl Default for Station {
    fn default() -> Self {
        Self::new()
    }
}

impl Station {
    /// Without anything.
    pub fn new() -> Self {
        let folder = crate::scratch();
        fs::create_dir_all(folder.path().join("data/sessions")).expect("folders");
        Self { folder }
    }

    /// The folder in which `data` lies, for other files.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The data folder.
    pub fn data(&self) -> PathBuf {
        self.folder.path().join("data")
    }

    /// The store.
    pub fn store(&self) -> PathBuf {
        self.data().join("store.sqlite")
    }

    /// A session of this station.
    pub fn session(&self, name: &str) -> PathBuf {
        let sessions = self.data().join("sessions");
        sessions.join(format!("{name}.session"))
    }

    /// The program at this station.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = command(args);
        command.env("MICROSIM_DATA", self.data());
        command
    }

    /// Runs the program at this station.
    pub fn microsim(&self, args: &[&str]) -> Finished {
        finish(&mut self.command(args))
    }

    /// Adds a trainee; the id.
    ///
    /// # Panics
    /// If the program does not.
    pub fn add(&self, name: &str) -> String {
        let added = self
            .microsim(&["trainees", "add", name, "--json"])
            .expect(0)
            .json();
        added["id"].as_str().expect("an id").to_owned()
    }

    /// A run of level 1 of touch-spheres by a script, `pass` or one that fails, recorded as `name`.
    pub fn run(&self, name: &str, script: &str, more: &[&str]) -> Command {
        let input = format!("script:level1-{script}.toml");
        let mut run = self.command(&["run", "touch-spheres", "--json", "--input", &input]);
        run.arg("--session").arg(self.session(name)).args(more);
        run
    }

    /// All results, by time, without names: those do not stand in sessions.
    ///
    /// # Panics
    /// If the program does not give them.
    pub fn results(&self) -> Vec<Value> {
        let printed = self.microsim(&["results", "--json"]).expect(0).json();
        let results = printed["results"].as_array().expect("a list").clone();
        let without_name = results.into_iter().map(|mut result| {
            result["name"] = Value::Null;
            result
        });
        without_name.collect()
    }
}

/// What came of runs of which some were killed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KilledRuns {
    /// Runs.
    pub runs: usize,
    /// Of them, those that were killed while their process was there.
    pub killed: usize,
    /// Sessions that can be read.
    pub readable: usize,
    /// Of them, those with an end.
    pub finished: usize,
    /// Sessions with an end that were not in the store when their process was killed: a later command has entered them.
    pub caught_up: usize,
    /// Sessions that can be read and are not in the store.
    pub missing: Vec<String>,
    /// Whether the store has the same sessions and results after `store rebuild`.
    pub same_after_rebuild: bool,
    /// Whether a store that is made from the sessions alone has the same sessions and results.
    pub same_as_rebuilt: bool,
    /// Whether `store check` finds nothing.
    pub intact: bool,
}

impl KilledRuns {
    /// Nothing is lost, and all is as the sessions show it.
    pub fn is_good(&self) -> bool {
        self.missing.is_empty() && self.same_after_rebuild && self.same_as_rebuilt && self.intact
    }
}

/// When a run is killed.
#[derive(Clone, Copy, Debug)]
enum Kill {
    Never,
    /// So long after its start.
    Started(Duration),
    /// So long after its session was seen with an end: while the report is made, or the result entered.
    Ended(Duration),
}

/// Longest time after the end of a session at which a run is killed: in it reports are written and the result is entered.
const AFTER_END: Duration = Duration::from_millis(60);

/// Runs `runs` sessions of `trainees` trainees, two at a time on one store, and kills one of each two: of these in turn one at a moment that is
/// random over a little more than the length of a run, and one up to 60 ms after its session has an end.
///
/// # Panics
/// If the program cannot be run.
pub fn killed_runs(runs: usize, trainees: usize, seed: u64) -> KilledRuns {
    let station = Station::new();
    let names: Vec<String> = (0..trainees).map(|n| format!("Trainee {n}")).collect();
    names.iter().for_each(|name| {
        station.add(name);
    });
    // Every third fails, and takes longer.
    let fails = |n: usize| n.is_multiple_of(3);
    let start_run = |n: usize| -> Child {
        let script = if fails(n) { "fail-too-slow" } else { "pass" };
        let trainee = &names[n % trainees];
        let mut run = station.run(&n.to_string(), script, &["--trainee", trainee]);
        run.stdout(Stdio::null()).stderr(Stdio::null());
        run.spawn().expect("the built program starts")
    };
    // Lengths of one that fails and one that passes.
    let lengths = [0, 1].map(|n| {
        let start = Instant::now();
        assert!(start_run(n).wait().expect("a run").success());
        start.elapsed()
    });
    let mut random = SplitMix64(seed);
    let (mut killed, mut caught_up) = (0, 0);
    let mut open: Vec<(usize, Child, Kill, Instant)> = Vec::new();
    let mut next = 2;
    while next < runs || !open.is_empty() {
        while next < runs && open.len() < 2 {
            let mut part = || 1e-6 * random.below(1_000_000) as f64;
            let kill = match next % 4 {
                // Up to a fifth after the time that it takes alone; beside another it takes longer.
                1 => Kill::Started(lengths[usize::from(!fails(next))].mul_f64(1.2 * part())),
                3 => Kill::Ended(AFTER_END.mul_f64(part())),
                _ => Kill::Never,
            };
            open.push((next, start_run(next), kill, Instant::now()));
            next += 1;
        }
        open.retain_mut(|(n, child, kill, since)| {
            if child.try_wait().expect("a process").is_some() {
                return false;
            }
            match *kill {
                Kill::Started(after) if since.elapsed() >= after => {}
                // From here on the time counts from the end.
                Kill::Ended(after) if has_end(&station.session(&n.to_string())) => {
                    (*kill, *since) = (Kill::Started(after), Instant::now());
                    return true;
                }
                _ => return true,
            }
            child.kill().expect("SIGKILL is sent");
            child.wait().expect("the process ends");
            killed += 1;
            let path = station.session(&n.to_string());
            if has_end(&path) && !is_entered(&station.store(), &path) {
                caught_up += 1;
            }
            false
        });
        std::thread::sleep(Duration::from_millis(1));
    }
    examine(&station, runs, [killed, caught_up])
}

/// Whether a session has its end. Only its frames are read, not what is in them: that takes as long as what is to be met.
fn has_end(path: &Path) -> bool {
    let Ok(file) = fs::File::open(path) else {
        return false;
    };
    let Ok(mut frames) = Reader::open(BufReader::new(file)) else {
        return false;
    };
    while let Ok(Some(frame)) = frames.next_frame() {
        if frame.kind == kind::CLOSE {
            return true;
        }
    }
    false
}

fn examine(station: &Station, runs: usize, [killed, caught_up]: [usize; 2]) -> KilledRuns {
    let mut read = Vec::new();
    for n in 0..runs {
        let path = station.session(&n.to_string());
        let session = fs::read(&path).ok();
        let session = session.and_then(|bytes| Session::read(&bytes).ok());
        if let Some(session) = session {
            let path = path.canonicalize().expect("a file");
            read.push((path.display().to_string(), session.end.is_some()));
        }
    }
    let results = station.results();
    let paths: BTreeSet<&str> = results.iter().filter_map(|r| r["file"].as_str()).collect();
    let missing = read.iter().filter(|(path, _)| !paths.contains(&path[..]));
    let missing = missing.map(|(path, _)| path.clone()).collect();
    station.microsim(&["store", "rebuild"]).expect(0);
    let same_after_rebuild = station.results() == results;
    let intact = station.microsim(&["store", "check"]).code == Some(0);
    for end in ["", "-wal", "-shm"] {
        let mut name = station.store().into_os_string();
        name.push(end);
        let _ = fs::remove_file(name);
    }
    station.microsim(&["store", "rebuild"]).expect(0);
    KilledRuns {
        runs,
        killed,
        readable: read.len(),
        finished: read.iter().filter(|(_, ended)| *ended).count(),
        caught_up,
        missing,
        same_after_rebuild,
        same_as_rebuilt: station.results() == results,
        intact,
    }
}

/// Whether a session is in a store now, without anything being entered.
fn is_entered(store: &Path, session: &Path) -> bool {
    let store = microsim_store::Store::open_to_read(store).expect("a store");
    let paths = store.expect("it is there").session_paths().expect("paths");
    let session = session.canonicalize().expect("a file");
    paths.iter().any(|(path, _)| Path::new(path) == session)
}

/// Of a result: what an outcome of `run --json` has as well.
pub fn of_run(printed: &Value) -> Value {
    json!({
        "session": printed["session_id"],
        "verdict": printed["verdict"],
        "score": printed["score"],
        "trainee": printed["trainee"],
        "state_hash": printed["state_hash"],
    })
}
