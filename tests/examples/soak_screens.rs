//! `cargo xtask soak screens`: every screen of the window in both languages and two sizes, and introduction and training of every module, at a display without a screen, reached by keys alone. Writes `tests/results/screens/` and
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

/// A window at a display, and where it records.
struct Visit {
    display: Display,
    window: Peer,
    sessions: PathBuf,
    language: &'static str,
    size: [u32; 2],
    /// What was stored last.
    last: Vec<[u8; 3]>,
}

impl Visit {
    fn begin(station: &Station, language: &'static str, size: [u32; 2]) -> Result<Self, String> {
        let display = Display::open_of(size)?;
        let of = format!("{}x{}", size[0], size[1]);
        let arguments = ["window", "--lang", language, "--size", &of];
        let window = display.program(&station.data(), arguments).spawn();
        let window = Peer(window.map_err(|error| format!("the program: {error}"))?);
        display.focus("MicroSim");
        let black = vec![[0; 3]; (size[0] * size[1]) as usize];
        Ok(Self {
            last: black,
            display,
            window,
            sessions: station.data().join("sessions"),
            language,
            size,
        })
    }

    /// Sessions that were begun, and reports of those that ended.
    fn recorded(&self) -> BTreeMap<&'static str, usize> {
        let of = |extension| (extension, count(&self.sessions, extension));
        ["session", "html"].map(of).into()
    }

    /// Presses keys, each once the one before has changed what is seen; some change little or nothing.
    fn press(&self, keys: &[&str]) {
        for key in keys {
            let before = self.display.shot().pixels;
            self.display.key(key);
            self.changed(&before, DRAWN);
            std::thread::sleep(Duration::from_millis(700));
        }
    }

    /// Waits until another screen is seen, for at most so long; whether it is.
    fn changed(&self, before: &[[u8; 3]], most: Duration) -> bool {
        let start = Instant::now();
        loop {
            let now = self.display.shot().pixels;
            let changed = before.iter().zip(&now).filter(|(a, b)| a != b).count();
            if 300 * changed > now.len() {
                return true;
            }
            if start.elapsed() > most {
                return false;
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    /// Waits for one more file than `before` had; a key that was lost on a busy machine is pressed again.
    fn until(
        &self,
        before: &BTreeMap<&str, usize>,
        (extension, key): (&str, &str),
    ) -> Result<(), String> {
        let start = Instant::now();
        while count(&self.sessions, extension) == before[extension] {
            if start.elapsed() > PATIENCE {
                return Err(format!(
                    "{}, {:?}: nothing begins or ends",
                    self.language, self.size
                ));
            }
            std::thread::sleep(DRAWN);
            if count(&self.sessions, extension) == before[extension] {
                self.display.key(key);
            }
        }
        std::thread::sleep(DRAWN);
        Ok(())
    }

    /// Stores what is seen now.
    fn keep(&mut self, screen: &str) -> Result<(), String> {
        if !self.changed(&self.last, PATIENCE) {
            return Err(format!("{screen}: nothing changes"));
        }
        std::thread::sleep(DRAWN);
        self.last = self.display.shot().pixels;
        let [width, height] = self.size;
        let name = format!("{}-{width}x{height}-{screen}.png", self.language);
        keep(&self.display, &folder().join(name))?;
        let state = self
            .window
            .0
            .try_wait()
            .map_err(|error| error.to_string())?;
        match state {
            None => Ok(()),
            Some(status) => Err(format!("{screen}: the window has ended: {status}")),
        }
    }
}

/// All screens of a language and size.
fn show(station: &Station, language: &'static str, size: [u32; 2]) -> Result<(), String> {
    let mut visit = Visit::begin(station, language, size)?;
    let before = visit.recorded();
    for (screen, keys) in SCREENS {
        visit.press(keys);
        let awaited = match screen {
            "introduction" => Some(("session", "Return")),
            "debrief" => Some(("html", "F10")),
            _ => None,
        };
        if let Some(awaited) = awaited {
            visit.until(&before, awaited)?;
        }
        visit.keep(screen)?;
    }
    Ok(())
}

/// Introduction and training of level 1 of each module, for the READMEs of the modules.
fn show_modules(language: &'static str) -> Result<(), String> {
    let station = station();
    let mut visit = Visit::begin(&station, language, SIZES[0])?;
    for (place, module) in modules().iter().enumerate() {
        let before = visit.recorded();
        if place > 0 {
            visit.press(&["Down"]);
        }
        visit.press(&["Return"]);
        visit.until(&before, ("session", "Return"))?;
        visit.keep(&format!("{module}-introduction"))?;
        visit.press(&["Return"]);
        // The instrument in hand goes some steps towards the middle.
        for _ in 0..10 {
            visit.display.key("Up");
        }
        visit.keep(&format!("{module}-training"))?;
        visit.press(&["Escape", "F10"]);
        visit.until(&before, ("html", "F10"))?;
        visit.press(&["Escape"]);
    }
    Ok(())
}

/// Names of the modules, in the order of the launcher.
fn modules() -> Vec<String> {
    let listed = microsim_tests::microsim(["list", "--json"])
        .expect(0)
        .json();
    let modules = listed["modules"].as_array().expect("modules").iter();
    let names = modules.map(|module| module["name"].as_str().expect("a name").to_owned());
    names.collect()
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
        texts and overlap are computed by the tests of the window (`crates/window/src/tests`). Pictures per second and late ticks in the panels are those of a machine that may have other work.\n"
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
    text.push_str(
        "\n## Modules\n\nKeys in the list of modules: Return, Return, Up ten times. Their READMEs show them.\n\n\
        | level 1 of | English | Deutsch |\n|---|---|---|\n",
    );
    let [width, height] = SIZES[0];
    for module in modules() {
        for screen in ["introduction", "training"] {
            let _ = write!(text, "| `{module}`, {screen} |");
            for language in LANGUAGES {
                let file = format!("screens/{language}-{width}x{height}-{module}-{screen}.png");
                let _ = write!(text, " ![{screen}]({file}) |");
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
        show_modules(language)?;
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
