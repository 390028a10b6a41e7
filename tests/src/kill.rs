//! Runs killed by SIGKILL, and what is left of them.
//!
//! How the lost simulated time is measured: the source of the run, which is called first in every tick, writes the
//! index of each tick that begins into a file of its own (the witness), before anything else of the tick is done. What
//! the witness has and the session has not is lost, the tick in the making counted as a whole. No clock is involved.

use crate::comb;
use crate::live::LiveTree;
use crate::statistics::percentile;
use microsim_host::record::Session;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// How far a run had come when it was killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// No tick had begun.
    Starting,
    /// Between the first tick and the end of the session.
    Running,
    /// The session was complete: the process was writing reports, or had ended.
    Ended,
}

/// What is left of a killed run.
#[derive(Clone, Debug)]
pub struct Remains {
    /// How far it had come.
    pub moment: Moment,
    /// Whether the session can be read; one that was killed while starting has nothing to read.
    pub readable: bool,
    /// Ticks that had begun, by the witness.
    pub begun: u64,
    /// Ticks in the session.
    pub on_file: u64,
    /// Between the last write to the session and the kill, by the file's modification time \[s\].
    pub silence: f64,
    /// What the reader reports of the end of the file.
    pub complaint: String,
    /// Whether a fresh process recomputes what is left to the bit.
    pub verified: bool,
}

impl Remains {
    /// The tick that had begun and is not in the session: the one in which the kill fell.
    pub fn unfinished(&self) -> Option<u64> {
        (self.begun > self.on_file).then(|| self.begun - 1)
    }

    /// Ticks that had begun and are not in the session.
    pub fn lost(&self) -> u64 {
        self.begun.saturating_sub(self.on_file)
    }
}

/// A level that is run again and again, and killed.
#[derive(Debug)]
pub struct Target {
    tree: LiveTree,
    module: &'static str,
    args: Vec<String>,
    /// Length of its tick \[s\].
    pub tick: f64,
}

impl Target {
    /// Level 1 of touch-spheres with samples for `duration` seconds of wall-clock time. Paced, it ends with them;
    /// otherwise it goes on as fast as it can until the level's time is over.
    pub fn new(duration: f64, paced: bool) -> Self {
        let behaviour = json!({ "duration": duration, "delay": 8 });
        let mut target = Self {
            tree: LiveTree::new(&behaviour),
            module: "touch-spheres",
            args: Vec::new(),
            // `clock.tick` of the level.
            tick: 0.008,
        };
        if paced {
            target.args.push("--realtime".into());
        }
        target.witness(behaviour);
        target
    }

    /// The comb, cut by this number of snips, as fast as it can go: every run is the same.
    pub fn comb(snips: u32) -> Self {
        let behaviour = comb::behaviour(snips);
        let tree = comb::tree(&behaviour);
        let level = tree.last_level(comb::MODULE).to_string();
        let target = Self {
            tree,
            module: comb::MODULE,
            args: vec!["--level".into(), level],
            tick: comb::TICK,
        };
        target.witness(behaviour);
        target
    }

    /// Lets the source leave a witness.
    fn witness(&self, mut behaviour: Value) {
        behaviour["witness"] = json!(self.tree.root().join("witness"));
        self.tree.behave(&behaviour);
    }

    /// Runs to the end; the session.
    ///
    /// # Panics
    /// If the run fails.
    pub fn whole(&self, name: &str) -> PathBuf {
        let session = self.tree.root().join(format!("{name}.session"));
        let status = self.start(&session).wait().expect("the run ends");
        assert!(status.success(), "{status}");
        session
    }

    /// Whether a fresh process recomputes a session to the bit.
    pub fn verifies(&self, session: &Path) -> bool {
        self.tree.verify(session).code == Some(0)
    }

    fn start(&self, session: &Path) -> Child {
        let _ = fs::remove_file(self.tree.root().join("witness"));
        let mut run = self.tree.run(self.module, session, &self.args);
        run.stdout(Stdio::null()).stderr(Stdio::null());
        run.spawn().expect("the built program starts")
    }

    /// Length of the whole run, from start to exit: the median of five.
    ///
    /// # Panics
    /// If the run fails.
    pub fn length(&self) -> Duration {
        let lengths = (0..5).map(|n| {
            let start = Instant::now();
            self.whole(&format!("whole-{n}"));
            start.elapsed().as_secs_f64()
        });
        Duration::from_secs_f64(percentile(&lengths.collect::<Vec<_>>(), 0.5))
    }

    /// Starts the run, kills it after `delay` and looks at what is left.
    ///
    /// # Panics
    /// If the process cannot be killed.
    pub fn kill(&self, number: usize, delay: Duration) -> Remains {
        let session = self.tree.root().join(format!("killed-{number}.session"));
        let start = Instant::now();
        let mut child = self.start(&session);
        std::thread::sleep(delay.saturating_sub(start.elapsed()));
        child.kill().expect("SIGKILL is sent");
        let killed = SystemTime::now();
        child.wait().expect("the process ends");
        self.look(&session, killed)
    }

    /// Starts the run, kills it `delay` after a tick has begun and looks at what is left.
    ///
    /// # Panics
    /// If the run ends before the tick, or cannot be killed.
    pub fn kill_in(&self, number: usize, tick: u64, delay: Duration) -> Remains {
        let session = self.tree.root().join(format!("killed-{number}.session"));
        let mut child = self.start(&session);
        while self.begun() <= tick {
            let ended = child.try_wait().expect("the process can be asked");
            assert!(ended.is_none(), "{ended:?} before tick {tick}");
            std::thread::sleep(Duration::from_micros(100));
        }
        std::thread::sleep(delay);
        child.kill().expect("SIGKILL is sent");
        let killed = SystemTime::now();
        child.wait().expect("the process ends");
        self.look(&session, killed)
    }

    /// Ticks that have begun, by the witness.
    fn begun(&self) -> u64 {
        let witness = fs::metadata(self.tree.root().join("witness"));
        witness.map_or(0, |file| file.len() / 8)
    }

    fn look(&self, session: &Path, killed: SystemTime) -> Remains {
        let begun = self.begun();
        let written = fs::metadata(session).and_then(|file| file.modified()).ok();
        let silence = written.and_then(|written| killed.duration_since(written).ok());
        let read = fs::read(session).map_err(|e| e.to_string());
        let read = read.and_then(|bytes| Session::read(&bytes).map_err(|e| e.to_string()));
        let mut remains = Remains {
            moment: if begun == 0 {
                Moment::Starting
            } else {
                Moment::Running
            },
            readable: read.is_ok(),
            begun,
            on_file: 0,
            silence: silence.unwrap_or_default().as_secs_f64(),
            complaint: String::new(),
            verified: false,
        };
        match read {
            Ok(read) => {
                if read.end.is_some() {
                    remains.moment = Moment::Ended;
                }
                remains.on_file = read.ticks.last().map_or(0, |(tick, _)| tick + 1);
                remains.complaint = read.complaint.unwrap_or_default();
                remains.verified = self.verifies(session);
            }
            Err(error) => remains.complaint = error,
        }
        remains
    }
}

/// Moments spread evenly over a length: the middles of `count` equal parts.
pub fn moments(length: Duration, count: usize) -> Vec<Duration> {
    (0..count)
        .map(|n| length.mul_f64((n as f64 + 0.5) / count as f64))
        .collect()
}
