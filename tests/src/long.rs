//! Runs of any length with two tools, and what they, their report and their replay cost.

use crate::changed_levels::ChangedLevels;
use crate::measured::{Cost, cost};
use crate::scratch;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Time from one place of a tool to the next \[s\].
const LEG: u32 = 5;

/// A level of touch-spheres with two tools and a day for it: no tissue, so that what is measured is what grows with the length.
fn level() -> ChangedLevels {
    ChangedLevels::new("touch-spheres", |level| {
        let long = level
            .replace("max = \"120 s\"", "max = \"86000 s\"")
            .replace("zero = \"150 s\"", "zero = \"86400 s\"");
        format!("{long}\n[[tool]]\nname = \"left\"\nmodel = \"forceps\"\n")
    })
}

/// Interval of the samples \[ms\].
const INTERVAL: u32 = 16;

/// What the columns of [`recording`] mean.
const MAP: &str = r#"
licence = "Apache-2.0"
source = "made by the tests"
[time]
column = "t"
unit = "s"
[[device]]
name = "right"
position = ["rx", "ry", "rz"]
position_unit = "mm"
quaternion = ["rqx", "rqy", "rqz", "rqw"]
[[device]]
name = "left"
position = ["lx", "ly", "lz"]
position_unit = "mm"
quaternion = ["lqx", "lqy", "lqz", "lqw"]
"#;

/// Two tools that go to and fro above the spheres for so many seconds, each leg of minimum jerk. A recording, as scripts end after an hour.
fn recording(seconds: u32) -> String {
    let mut text = String::from("t,rx,ry,rz,rqx,rqy,rqz,rqw,lx,ly,lz,lqx,lqy,lqz,lqw\n");
    for sample in 0..=seconds * 1000 / INTERVAL {
        let t = f64::from(sample * INTERVAL) / 1e3;
        let leg = (t / f64::from(LEG)).floor();
        let tau = t / f64::from(LEG) - leg;
        let part = tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau);
        let between = |from: f64, to: f64| from + part * (to - from);
        let x = between(4.0 + leg % 3.0, 4.0 + (leg + 1.0) % 3.0);
        let z = between(12.0 + leg % 2.0, 12.0 + (leg + 1.0) % 2.0);
        let _ = writeln!(
            text,
            "{t:.3},{x:.6},0,{z:.6},0,0,0,1,-{x:.6},0,{z:.6},0,0,0,1"
        );
    }
    text
}

/// What a run of some length costs, and what its session does.
#[derive(Clone, Copy, Debug)]
pub struct Length {
    /// Simulated time \[s\].
    pub seconds: u32,
    /// Length of the session \[MB\].
    pub file: f64,
    /// `run`, with the report that it writes.
    pub run: Cost,
    /// `report`.
    pub report: Cost,
    /// `replay`.
    pub replay: Cost,
    /// `replay --verify`.
    pub verify: Cost,
}

/// Measures a run of so many simulated seconds.
///
/// # Panics
/// If one of the commands fails.
pub fn length(seconds: u32) -> Length {
    let (folder, level) = (scratch(), level());
    let input = folder.path().join("long.csv");
    fs::write(&input, recording(seconds)).expect("a recording");
    fs::write(folder.path().join("long.toml"), MAP).expect("its columns");
    let session = folder.path().join("long.session");
    let input = format!("recording:{}", input.display());
    let run = [
        "run",
        "touch-spheres",
        "--input",
        &input,
        "--no-pictures",
        "--session",
    ];
    let command = |args: &[&str], path: &Path| {
        let mut command = level.command(args);
        command.arg(path);
        cost(&mut command)
    };
    let run = command(&run, &session);
    let bytes = fs::metadata(&session).expect("a session").len();
    Length {
        seconds,
        file: bytes as f64 / 1e6,
        run,
        report: command(&["report"], &session),
        replay: command(&["replay"], &session),
        verify: command(&["replay", "--verify"], &session),
    }
}
