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

/// Two tools that go to and fro above the spheres for so many seconds.
fn script(seconds: u32) -> String {
    let mut text = String::from("rate = \"62.5 Hz\"\ninterpolation = \"minimum-jerk\"\n");
    for (tool, side) in [("right", 1), ("left", -1)] {
        let _ = write!(text, "\n[[tool]]\nname = \"{tool}\"\n");
        for leg in 0..=seconds / LEG {
            let (x, z) = (side * (4 + (leg % 3) as i32), 12 + leg % 2);
            let _ = write!(
                text,
                "\n[[tool.key]]\nt = {}\nposition = [\"{x} mm\", \"0 mm\", \"{z} mm\"]\ndirection = [0, 0, 1]\n",
                leg * LEG
            );
        }
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
    /// `replay --verify`.
    pub replay: Cost,
}

/// Measures a run of so many simulated seconds.
///
/// # Panics
/// If one of the commands fails.
pub fn length(seconds: u32) -> Length {
    let (folder, level) = (scratch(), level());
    let input = folder.path().join("long.toml");
    fs::write(&input, script(seconds)).expect("a script");
    let session = folder.path().join("long.session");
    let input = format!("script:{}", input.display());
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
        replay: command(&["replay", "--verify"], &session),
    }
}
