//! Somebody at the display who goes through all screens and handles instruments clumsily: keys, mouse and the files that the program writes are all that there is.

use microsim_random::SplitMix64;
use microsim_tests::desktop::Display;
use std::cell::Cell;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long a person waits before a window counts as frozen.
const PATIENCE: Duration = Duration::from_secs(45);
/// Between two keys: a slow picture comes in that time.
const KEY: &str = "350";
/// What xdotool is asked for at once: seconds and words.
const PART: f64 = 4.0;
const WORDS: usize = 4000;

/// A new folder of data within another, in which the window draws in low quality.
pub fn data_folder(folder: &Path) -> Result<PathBuf, String> {
    let data = folder.join("data");
    let failed = |error: std::io::Error| format!("{}: {error}", data.display());
    fs::create_dir_all(data.join("config")).map_err(failed)?;
    fs::write(data.join("config/window.toml"), "quality = \"low\"\n").map_err(failed)?;
    Ok(data)
}

/// The player.
pub struct Player<'a> {
    pub display: &'a Display,
    pub random: SplitMix64,
    /// Where sessions are recorded.
    pub sessions: PathBuf,
    size: [f64; 2],
}

impl<'a> Player<'a> {
    pub fn new(display: &'a Display, seed: u64, data: &Path) -> Self {
        Self {
            display,
            random: SplitMix64(seed),
            sessions: data.join("sessions"),
            size: [1280.0, 720.0],
        }
    }

    /// Gives the window the keyboard, wherever it came back.
    pub fn focus(&mut self) -> Result<String, String> {
        let start = Instant::now();
        loop {
            let search = ["search", "--onlyvisible", "--name", "^MicroSim$"];
            let found = self.display.ask(&search).unwrap_or_default();
            if let Some(id) = found.lines().last() {
                let id = id.to_owned();
                if self.display.ask(&["windowfocus", "--sync", &id]).is_ok() {
                    self.measure(&id)?;
                    return Ok(id);
                }
            }
            if start.elapsed() > PATIENCE {
                return Err(format!("no window is seen for {PATIENCE:?}"));
            }
            std::thread::sleep(Duration::from_millis(300));
        }
    }

    fn measure(&mut self, id: &str) -> Result<(), String> {
        let text = self.display.ask(&["getwindowgeometry", "--shell", id])?;
        let value = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|value| value.trim_start_matches('=').parse::<f64>().ok())
        };
        let size = value("WIDTH").zip(value("HEIGHT"));
        let (width, height) = size.ok_or_else(|| format!("xdotool gives no size: {text}"))?;
        self.size = [width, height];
        Ok(())
    }

    pub fn wait(&self, seconds: f64) {
        std::thread::sleep(Duration::from_secs_f64(seconds));
    }

    pub fn keys(&self, keys: &[&str]) -> Result<(), String> {
        let words: Vec<&str> = ["key", "--delay", KEY]
            .iter()
            .chain(keys)
            .copied()
            .collect();
        self.display.ask(&words).map(drop)
    }

    /// Goes to the n-th button by keyboard and presses it.
    pub fn press(&self, n: usize) -> Result<(), String> {
        let mut keys = vec!["Tab"; n];
        keys.push("space");
        self.keys(&keys)?;
        self.wait(0.8);
        Ok(())
    }

    /// All sessions that were begun.
    pub fn begun(&self) -> BTreeSet<PathBuf> {
        files(&self.sessions, "session")
    }

    fn until<T>(&self, what: &str, seen: impl Fn() -> Option<T>) -> Result<T, String> {
        let start = Instant::now();
        loop {
            if let Some(found) = seen() {
                return Ok(found);
            }
            if start.elapsed() > PATIENCE {
                return Err(format!("{what} not within {PATIENCE:?}"));
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// From the launcher into a level, which begins; gives its session.
    pub fn begin(&self, module: usize, level: u32) -> Result<PathBuf, String> {
        let session = self.open(module, level)?;
        self.start()?;
        Ok(session)
    }

    /// From the launcher to the introduction of a level; gives its session.
    pub fn open(&self, module: usize, level: u32) -> Result<PathBuf, String> {
        let before = self.begun();
        // What has the keyboard gives it back; then to the first module and from there.
        self.keys(&["Escape"])?;
        let mut keys = vec!["Up"; 10];
        keys.extend(["Left"; 10]);
        keys.extend(vec!["Down"; module]);
        keys.extend(vec!["Right"; level as usize - 1]);
        keys.push("Return");
        self.display.ask(&["mousemove", "500", "5"])?;
        let mut words = vec!["key", "--delay", "60"];
        words.extend(keys);
        self.display.ask(&words)?;
        self.until("a level begins", || {
            self.begun().difference(&before).next().cloned()
        })
    }

    /// Begins a level, shows it for a second and ends it: what it loads and compiles once is there from then on.
    pub fn look_at(&mut self, module: usize, level: u32) -> Result<(), String> {
        let session = self.open(module, level)?;
        // The introduction comes with the first picture; later the key has no meaning.
        for _ in 0..2 {
            self.wait(1.5);
            self.keys(&["Return"])?;
        }
        self.wait(1.0);
        self.end(&session)?;
        self.to_modules()
    }

    /// Leaves the introduction as soon as it is there, which is seen from the recording that grows from then on; gives the session.
    pub fn begin_at_once(&self, module: usize, level: u32) -> Result<PathBuf, String> {
        let session = self.open(module, level)?;
        let size = || fs::metadata(&session).map_or(0, |metadata| metadata.len());
        let before = Cell::new(size());
        self.until("a level goes on", || {
            let pressed = self.display.ask(&["key", "Return"]);
            self.wait(0.5);
            let (before, now) = (before.replace(size()), size());
            (pressed.is_ok() && now > before).then_some(())
        })?;
        Ok(session)
    }

    /// Does what xdotool is to do, in parts of a few seconds, until the level has ended.
    pub fn perform(&self, session: &Path, commands: &[(Vec<String>, f64)]) -> Result<(), String> {
        let mut words: Vec<&str> = Vec::new();
        let mut seconds = 0.0;
        for (n, (command, takes)) in commands.iter().enumerate() {
            words.extend(command.iter().map(String::as_str));
            seconds += takes;
            if seconds > PART || words.len() > WORDS || n + 1 == commands.len() {
                self.display.ask(&words)?;
                words.clear();
                seconds = 0.0;
                if self.has_ended(session) {
                    break;
                }
            }
        }
        // A level may end while they are pressed, and with them keys mean something else.
        self.display
            .ask(&["keyup", "shift", "mouseup", "3"])
            .map(drop)
    }

    /// Leaves the introduction, which is there once the tissue is prepared; later the key has no meaning.
    fn start(&self) -> Result<(), String> {
        for _ in 0..4 {
            self.wait(1.5);
            self.keys(&["Return"])?;
        }
        Ok(())
    }

    /// Whether the report of a session is there.
    pub fn has_ended(&self, session: &Path) -> bool {
        session.with_extension("html").exists()
    }

    /// A gesture within the field: it moves, closes, turns, raises, takes the other hand, or does something to the microscope.
    pub fn gesture(&mut self) -> Result<(), String> {
        let mut random = |most: f64| most * self.random.number();
        let [x, y] = [0.5 + random(0.2), 0.5 + random(0.3)];
        let place = [x * self.size[0], y * self.size[1]].map(|v| v.round().to_string());
        let mut words: Vec<String> = vec!["mousemove".into(), place[0].clone(), place[1].clone()];
        let button = match self.random.below(4) {
            0 | 1 => None,
            2 => Some("1"),
            _ => Some("3"),
        };
        let mut add = |parts: &[&str]| words.extend(parts.iter().map(|part| (*part).to_owned()));
        if let Some(button) = button {
            add(&["mousedown", button]);
        }
        for _ in 0..12 {
            let step = [0; 2].map(|_: i32| (20.0 * self.random.number()).round().to_string());
            add(&[
                "mousemove_relative",
                "--",
                &step[0],
                &step[1],
                "sleep",
                "0.04",
            ]);
        }
        if let Some(button) = button {
            add(&["mouseup", button]);
        }
        let wheel = if self.random.below(2) == 0 { "4" } else { "5" };
        let keys = [
            "a", "d", "c", "q", "e", "w", "s", "plus", "minus", "i", "j", "k", "l", "u", "o", "0",
            "Tab", "Left", "Right",
        ];
        match self.random.below(3) {
            0 => add(&["click", "--repeat", "4", "--delay", "60", wheel]),
            1 => add(&["key", keys[self.random.below(keys.len() as u64) as usize]]),
            _ => {}
        }
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        self.display.ask(&words).map(drop)
    }

    /// Plays for a while, or until the level has ended by itself.
    pub fn play(&mut self, session: &Path, seconds: f64) -> Result<(), String> {
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < seconds && !self.has_ended(session) {
            self.gesture()?;
        }
        Ok(())
    }

    /// Presses a key in a pause.
    fn in_pause(&self, key: &str) -> Result<(), String> {
        self.keys(&["Escape"])?;
        self.wait(1.0);
        self.keys(&[key])
    }

    /// Begins the level again; gives the new session.
    pub fn restart(&self) -> Result<PathBuf, String> {
        let before = self.begun();
        self.in_pause("F9")?;
        let session = self.until("it restarts", || {
            self.begun().difference(&before).next().cloned()
        })?;
        self.start()?;
        Ok(session)
    }

    /// Ends a level that goes on; afterwards the debrief is shown.
    pub fn end(&mut self, session: &Path) -> Result<(), String> {
        self.focus()?;
        for _ in 0..3 {
            if self.has_ended(session) {
                break;
            }
            self.in_pause("F10")?;
            let start = Instant::now();
            while start.elapsed() < Duration::from_secs(10) && !self.has_ended(session) {
                std::thread::sleep(Duration::from_millis(200));
            }
        }
        self.until("the report of an aborted level", || {
            self.has_ended(session).then_some(())
        })?;
        self.wait(1.5);
        Ok(())
    }

    /// From the debrief to the replay and back: it plays, jumps, and goes back.
    pub fn replay(&self) -> Result<(), String> {
        self.changes("the replay", &["r"])?;
        self.wait(2.0);
        self.keys(&["space", "5"])?;
        self.wait(2.0);
        self.keys(&["space", "Left", "Left", "Up", "Down", "End"])?;
        self.wait(2.0);
        self.keys(&["Home"])?;
        self.changes("back from the replay", &["Escape"])
    }

    /// From the debrief to the modules, where the key has no meaning.
    pub fn to_modules(&self) -> Result<(), String> {
        for _ in 0..2 {
            self.keys(&["Escape"])?;
            self.wait(1.5);
        }
        Ok(())
    }

    /// Presses keys after which another screen is expected.
    fn changes(&self, what: &str, keys: &[&str]) -> Result<(), String> {
        let before = self.display.shot();
        self.keys(keys)?;
        self.until(what, || {
            differs(&before.pixels, &self.display.shot().pixels).then_some(())
        })
    }

    /// From the launcher to the results and the store, and back.
    pub fn records(&self) -> Result<(), String> {
        self.changes("the results", &["F4"])?;
        self.wait(1.0);
        self.changes("courses and data", &["F6"])?;
        self.wait(1.0);
        self.changes("back to the results", &["Escape"])?;
        self.wait(1.0);
        self.changes("back to the modules", &["Escape"])
    }

    /// From the launcher to the settings: a language, a quality, a stereo layout; and back.
    pub fn settings(&mut self) -> Result<(), String> {
        self.changes("the settings", &["F5"])?;
        self.wait(1.0);
        // Back, store, two languages, four qualities, depth of field, five stereo layouts: each from the one that was pressed before.
        let language = 3 + self.random.below(2) as usize;
        self.press(language)?;
        for _ in 0..3 {
            let further = 1 + self.random.below(3) as usize;
            self.press(further)?;
        }
        // A list that was opened last takes the first one.
        self.keys(&["Escape"])?;
        self.wait(1.0);
        self.keys(&["Escape"])?;
        self.wait(1.0);
        self.changes("the results", &["F4"])?;
        self.changes("back to the modules", &["Escape"])
    }
}

/// Whether two pictures of the display are of different screens: more than a fiftieth of their pixels changed.
fn differs(before: &[[u8; 3]], after: &[[u8; 3]]) -> bool {
    let changed = before.iter().zip(after).filter(|(a, b)| a != b).count();
    50 * changed > before.len()
}

fn files(folder: &Path, extension: &str) -> BTreeSet<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let of = |path: &PathBuf| path.extension().is_some_and(|e| e == extension);
    entries.map(|entry| entry.path()).filter(of).collect()
}
