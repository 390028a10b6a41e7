//! `cargo xtask soak screens`: every screen of the window in both languages and two sizes, at a display without a screen, reached by keys alone. Writes `tests/results/screens/` and
//! `tests/results/screens.md`.
//!
//! The program is the shipped one; a trainee with two results is put into a store of its own before. What is checked of the screens, contrast and overlap, is checked by the tests
//! of the window on the same sizes, not here.

use microsim_tests::desktop::Display;
use microsim_tests::peers::{Peer, done};
use microsim_tests::stations::Station;
use microsim_tests::{repository, tree};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

const SIZES: [[u32; 2]; 2] = [[1280, 720], [1920, 1080]];
const LANGUAGES: [&str; 2] = ["en", "de"];
/// For what a machine without a graphics card draws, and then some.
const DRAWN: Duration = Duration::from_secs(3);
/// For tissue to be prepared, and a level to end.
const PATIENCE: Duration = Duration::from_secs(60);

/// A screen, and the keys that lead to it from the one before.
const SCREENS: [(&str, &[&str]); 11] = [
    ("launcher", &[]),
    ("settings", &["F5"]),
    ("results", &["Escape", "F4"]),
    ("data", &["F6"]),
    ("editor", &["Escape", "Escape", "e"]),
    ("introduction", &["Escape", "Right", "Return"]),
    ("training", &["Return"]),
    ("pause", &["Escape"]),
    ("debrief", &["F10"]),
    ("replay", &["r"]),
    ("replay-reference", &["Home", "g"]),
];

fn folder() -> PathBuf {
    repository().join("tests/results/screens")
}

/// A station with somebody who has tried a level twice.
fn station() -> Station {
    let station = Station::new();
    station.add("A. Muster");
    for (name, script) in [("1", "fail-too-slow"), ("2", "pass")] {
        let mut run = station.run(name, script, &["--trainee", "A. Muster", "--no-pictures"]);
        microsim_tests::finish(&mut run).expect(0);
    }
    station
}

/// A picture of all of the display, small enough to be stored.
fn keep(display: &Display, file: &Path) -> Result<(), String> {
    display.keep(file);
    let mut smaller = Command::new("convert");
    smaller
        .arg(file)
        .args(["-dither", "None", "-colors", "200"]);
    done(smaller.arg(format!("PNG8:{}", file.display())))
}

/// All screens of a language and size.
fn show(station: &Station, language: &str, [width, height]: [u32; 2]) -> Result<(), String> {
    let display = Display::open_of([width, height])?;
    let size = format!("{width}x{height}");
    let arguments = ["window", "--lang", language, "--size", &size];
    let window = display.program(&station.data(), arguments).spawn();
    let mut window = Peer(window.map_err(|error| format!("the program: {error}"))?);
    std::thread::sleep(2 * DRAWN);
    display.focus("MicroSim");
    let sessions = station.data().join("sessions");
    let before = ["session", "html"].map(|extension| (extension, count(&sessions, extension)));
    let before = BTreeMap::from(before);
    for (screen, keys) in SCREENS {
        for key in keys {
            display.key(key);
            std::thread::sleep(Duration::from_millis(700));
        }
        // What a level needs is waited for, and a key that was lost on a busy machine is pressed again.
        let awaited = match screen {
            "introduction" => Some(("session", "Return")),
            "debrief" => Some(("html", "F10")),
            _ => None,
        };
        if let Some((extension, key)) = awaited {
            let start = Instant::now();
            while count(&sessions, extension) == before[extension] {
                if start.elapsed() > PATIENCE {
                    return Err(format!(
                        "{screen}, {language}, {size}: nothing begins or ends"
                    ));
                }
                std::thread::sleep(DRAWN);
                if count(&sessions, extension) == before[extension] {
                    display.key(key);
                }
            }
            std::thread::sleep(DRAWN);
        }
        std::thread::sleep(DRAWN);
        let file = folder().join(format!("{language}-{size}-{screen}.png"));
        keep(&display, &file)?;
        let state = window.0.try_wait().map_err(|error| error.to_string())?;
        if let Some(status) = state {
            return Err(format!(
                "{screen}, {language}, {size}: the window has ended: {status}"
            ));
        }
    }
    Ok(())
}

fn count(folder: &Path, extension: &str) -> usize {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    paths
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .count()
}

fn page() -> String {
    let mut text = "# Screens of the window\n\nCommand: `cargo xtask soak screens`. The shipped program at a display without a screen, with a software driver; each screen is reached by keys. Smallest contrast of \
        texts and overlap are computed by the tests of the window (`crates/window/src/tests`).\n"
        .to_owned();
    for (screen, keys) in SCREENS {
        let keys = keys.join(", ");
        let _ = write!(
            text,
            "\n## {screen}\n\n{}| | ",
            match keys.is_empty() {
                true => String::new(),
                false => format!("Keys: {keys}.\n\n"),
            }
        );
        let _ = writeln!(text, "English | Deutsch |\n|---|---|---|");
        for [width, height] in SIZES {
            let _ = write!(text, "| {width} × {height} |");
            for language in LANGUAGES {
                let _ = write!(
                    text,
                    " ![{screen}](screens/{language}-{width}x{height}-{screen}.png) |"
                );
            }
            text.push('\n');
        }
    }
    text
}

fn all() -> Result<(), String> {
    let failed = |error: std::io::Error| error.to_string();
    assert!(tree().exists(), "the assembled tree");
    fs::create_dir_all(folder()).map_err(failed)?;
    for language in LANGUAGES {
        for size in SIZES {
            // Each finds the store as it was.
            show(&station(), language, size)?;
        }
    }
    fs::write(repository().join("tests/results/screens.md"), page()).map_err(failed)
}

fn main() -> ExitCode {
    match all() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("soak screens: {why}");
            ExitCode::FAILURE
        }
    }
}
