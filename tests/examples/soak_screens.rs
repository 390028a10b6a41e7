//! `cargo xtask soak screens`: a picture of every screen of the window, in both languages and two sizes, as people come to it by keys and mouse. Writes `tests/results/screens/`; the
//! first level of each module is there as well, for the module's page.
//!
//! A screen is a row of [`SCREENS`], and a function that leads to it from the screen before.

use microsim_tests::desktop::Display;
use microsim_tests::peers::Peer;
use microsim_tests::stations::Station;
use microsim_tests::{command, finish, repository};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

const SIZES: [[u32; 2]; 2] = [[1280, 720], [1920, 1080]];
const LANGUAGES: [(&str, &str); 2] = [("en", "English"), ("de", "German")];
/// Colours of a picture that is stored: shades of the field are few.
const COLOURS: &str = "64";
/// What all pictures may take \[bytes\].
const MOST: u64 = 4_000_000;

/// A name, what it is in the table, and how one comes there.
type Screen = (
    &'static str,
    &'static str,
    fn(&Hand<'_>) -> Result<(), String>,
);

/// In the order in which they are visited.
const SCREENS: [Screen; 11] = [
    ("launcher", "modules and levels", |_| Ok(())),
    ("settings", "settings", |hand| hand.button(3)),
    ("results", "trainees and results", |hand| {
        hand.button(1)?;
        hand.wait(1.0);
        hand.button(4)
    }),
    ("results-of-one", "results of a trainee", |hand| {
        hand.click([150, 145])
    }),
    ("comparison", "two attempts compared", |hand| {
        hand.click(hand.compare())
    }),
    ("upkeep", "courses and data", |hand| hand.button(3)),
    ("introduction", "introduction", |hand| {
        // To the results, to the modules; there the fifth level of the first module.
        hand.button(1)?;
        hand.button(1)?;
        hand.keys(&["Escape", "Right", "Right", "Right", "Return"])?;
        hand.wait(5.0);
        Ok(())
    }),
    ("training", "training, with help", |hand| {
        hand.keys(&["Return"])?;
        hand.wait(1.0);
        hand.drag()
    }),
    ("pause", "pause", |hand| hand.keys(&["Escape"])),
    ("debrief", "debrief", |hand| {
        hand.click([hand.size[0] as i32 / 2, 121])?;
        hand.until_reported()
    }),
    ("replay", "replay", |hand| {
        hand.keys(&["r"])?;
        hand.wait(4.0);
        hand.keys(&["5", "space"])?;
        hand.wait(2.5);
        hand.keys(&["space"])
    }),
];

/// Keys and mouse.
struct Hand<'a> {
    display: &'a Display,
    station: &'a Station,
    size: [u32; 2],
    language: &'static str,
}

impl Hand<'_> {
    fn wait(&self, seconds: f64) {
        std::thread::sleep(Duration::from_secs_f64(seconds));
    }

    fn keys(&self, keys: &[&str]) -> Result<(), String> {
        let words: Vec<&str> = ["key", "--delay", "350"]
            .iter()
            .chain(keys)
            .copied()
            .collect();
        self.display.ask(&words).map(drop)
    }

    /// Presses the n-th button of a screen, by the tabulator.
    fn button(&self, n: usize) -> Result<(), String> {
        let mut keys = vec!["Tab"; n];
        keys.push("space");
        self.keys(&keys)?;
        self.wait(1.0);
        Ok(())
    }

    fn click(&self, place: [i32; 2]) -> Result<(), String> {
        let [x, y] = place.map(|v| v.to_string());
        let words = [
            "mousemove",
            &x,
            &y,
            "sleep",
            "0.7",
            "mousedown",
            "1",
            "sleep",
            "0.2",
            "mouseup",
            "1",
            "sleep",
            "0.5",
        ];
        self.display.ask(&words)?;
        // No button is shown as under the pointer.
        let corner = [self.size[0] - 3, self.size[1] - 3].map(|v| v.to_string());
        self.display
            .ask(&["mousemove", &corner[0], &corner[1]])
            .map(drop)
    }

    /// The button that compares two attempts.
    fn compare(&self) -> [i32; 2] {
        [380, 120]
    }

    /// Moves the instrument in hand into the field.
    fn drag(&self) -> Result<(), String> {
        let [x, y] = [self.size[0] as i32 / 2, self.size[1] as i32 * 2 / 3];
        self.display.point([x, y]);
        self.wait(0.5);
        self.display.drag(
            [
                f64::from(self.size[0]) / 20.0,
                -f64::from(self.size[1]) / 12.0,
            ],
            20,
        );
        self.wait(1.0);
        Ok(())
    }

    fn until_reported(&self) -> Result<(), String> {
        let sessions = self.station.data().join("sessions");
        let start = Instant::now();
        loop {
            let files = fs::read_dir(&sessions).into_iter().flatten().flatten();
            let is_report =
                |name: &str| name.starts_with("coordination-level4-") && name.ends_with(".html");
            if files
                .map(|file| file.file_name())
                .any(|name| is_report(&name.to_string_lossy()))
            {
                self.wait(2.0);
                return Ok(());
            }
            if start.elapsed() > Duration::from_secs(30) {
                return Err("no report within 30 s".into());
            }
            self.wait(0.2);
        }
    }
}

/// Three trainees, one with two attempts.
fn station() -> Station {
    let station = Station::new();
    for name in ["A. Muster", "B. Beispiel", "C. Exempel"] {
        station.add(name);
        station
            .microsim(&["trainees", "group", "2026", "--add", name])
            .expect(0);
    }
    let runs = [
        ("1", "fail-too-slow", "A. Muster"),
        ("2", "pass", "A. Muster"),
        ("3", "pass", "B. Beispiel"),
    ];
    for (name, script, who) in runs {
        finish(&mut station.run(name, script, &["--trainee", who, "--no-pictures"])).expect(0);
    }
    let course = microsim_tests::tree().join("config/courses/first-steps.toml");
    station
        .microsim(&["courses", "add", &course.display().to_string()])
        .expect(0);
    station
}

/// A window that is seen.
fn open(
    display: &Display,
    station: &Station,
    size: [u32; 2],
    arguments: &[&str],
) -> Result<Peer, String> {
    let mut window = command(["window", "--size", &format!("{}x{}", size[0], size[1])]);
    window.args(arguments);
    window
        .env("DISPLAY", display.name())
        .env("MICROSIM_DATA", station.data())
        .env("XDG_RUNTIME_DIR", station.data());
    window.stdout(Stdio::null()).stderr(Stdio::null());
    let window = Peer(
        window
            .spawn()
            .map_err(|error| format!("the program: {error}"))?,
    );
    display.ask(&[
        "search",
        "--sync",
        "--onlyvisible",
        "--name",
        "^MicroSim$",
        "windowfocus",
        "--sync",
    ])?;
    std::thread::sleep(Duration::from_secs(4));
    Ok(window)
}

/// Stores what is seen with few colours.
fn store(display: &Display, file: &Path) -> Result<(), String> {
    let mut import = Command::new("import");
    import.args([
        "-window",
        "root",
        "-dither",
        "None",
        "-colors",
        COLOURS,
        "-define",
        "png:compression-level=9",
    ]);
    import
        .arg(format!("png8:{}", file.display()))
        .env("DISPLAY", display.name());
    let status = import
        .status()
        .map_err(|error| format!("import: {error}"))?;
    status
        .success()
        .then_some(())
        .ok_or(format!("import: {status}"))
}

fn visit(folder: &Path, size: [u32; 2], language: &'static str) -> Result<(), String> {
    let display = Display::open_of(size)?;
    let station = station();
    let settings = "quality = \"high\"\n";
    let failed = |error: std::io::Error| error.to_string();
    fs::create_dir_all(station.data().join("config")).map_err(failed)?;
    fs::write(station.data().join("config/window.toml"), settings).map_err(failed)?;
    let _window = open(&display, &station, size, &["--lang", language])?;
    let hand = Hand {
        display: &display,
        station: &station,
        size,
        language,
    };
    for (name, _, lead) in SCREENS {
        lead(&hand).map_err(|why| format!("{name}: {why}"))?;
        hand.wait(1.0);
        store(&display, &folder.join(file_name(name, size, hand.language)))?;
    }
    Ok(())
}

fn file_name(screen: &str, size: [u32; 2], language: &str) -> String {
    format!("{screen}-{language}-{}.png", size[1])
}

/// The first level of each module, for its page.
fn modules(to: &Path) -> Result<(), String> {
    let size = [1280, 720];
    let entries = fs::read_dir(repository().join("modules")).map_err(|error| error.to_string())?;
    let mut folders: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.join("module.toml").exists())
        .collect();
    folders.sort();
    for folder in folders {
        let display = Display::open_of(size)?;
        let station = Station::new();
        let name = folder
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let _window = open(&display, &station, size, &[&name, "--lang", "en"])?;
        let hand = Hand {
            display: &display,
            station: &station,
            size,
            language: "en",
        };
        hand.wait(4.0);
        hand.keys(&["Return"])?;
        hand.wait(1.0);
        hand.drag()?;
        store(&display, &to.join(format!("module-{name}.png")))?;
    }
    Ok(())
}

/// The page, with the sizes of the files.
fn page(folder: &Path) -> Result<String, String> {
    let mut text = String::from(
        "# Screens of the window\n\nCommand: `cargo xtask soak screens`. Pictures with 64 colours, of the display itself; on a software driver, in the highest quality.\n",
    );
    let mut sum = 0;
    for size in SIZES {
        let _ = writeln!(
            text,
            "\n## {} × {} pixels\n\n| screen | {} | {} |\n|---|---|---|",
            size[0], size[1], LANGUAGES[0].1, LANGUAGES[1].1
        );
        for (name, title, _) in SCREENS {
            let _ = write!(text, "| {title} |");
            for (language, of) in LANGUAGES {
                let file = file_name(name, size, language);
                let path = folder.join(&file);
                sum += fs::metadata(&path)
                    .map_err(|error| format!("{}: {error}", path.display()))?
                    .len();
                let _ = write!(text, " ![{title}, {of}]({file}) |");
            }
            text.push('\n');
        }
    }
    match sum <= MOST {
        true => Ok(text),
        false => Err(format!(
            "the pictures take {sum} bytes, and {MOST} are the most"
        )),
    }
}

fn main() -> ExitCode {
    let folder = repository().join("tests/results/screens");
    let made = fs::create_dir_all(&folder).map_err(|error| error.to_string());
    let made = made.and_then(|()| {
        for size in SIZES {
            for (language, _) in LANGUAGES {
                visit(&folder, size, language)?;
            }
        }
        modules(&folder)?;
        fs::write(folder.join("README.md"), page(&folder)?).map_err(|error| error.to_string())
    });
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("soak screens: {why}");
            ExitCode::FAILURE
        }
    }
}
