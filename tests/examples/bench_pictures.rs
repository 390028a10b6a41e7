//! `cargo xtask bench pictures`: level 4 of coordination in the window at a display without a screen, moved by the mouse: pictures in a second, the time of a picture, and how
//! long a motion of the hand takes to the picture, by stage; in each quality. Writes `tests/results/pictures.md`.
//!
//! All numbers are those of the log of the window: what it computes and draws in one process, with nothing in it for this measurement.

use microsim_tests::desktop::Display;
use microsim_tests::peers::Peer;
use microsim_tests::{repository, scratch};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

const QUALITIES: [&str; 3] = ["low", "medium", "high"];

/// How long the hand moves.
const MOVES: Duration = Duration::from_secs(30);
/// Where the picture of the whole window is looked at.
const WINDOW: [[usize; 2]; 2] = [[0, 0], [1280, 720]];

/// The orange of a mark, as the introduction shows it.
fn is_mark([r, g, b]: [u8; 3]) -> bool {
    r > 150 && (60..190).contains(&g) && b < 70 && i16::from(r) - i16::from(g) > 60
}

/// Moves the hand through the field for a while and ends the run; what the log states of it, by name.
fn measure(quality: &str) -> Result<BTreeMap<String, String>, String> {
    let display = Display::open()?;
    let folder = scratch();
    let data = folder.path().join("data");
    let failed = |error: std::io::Error| format!("{}: {error}", data.display());
    fs::create_dir_all(data.join("config")).map_err(failed)?;
    let settings = format!("quality = \"{quality}\"\npanels = false\n");
    fs::write(data.join("config/window.toml"), settings).map_err(failed)?;
    let level = ["window", "coordination", "--level", "4"];
    let shown = ["--lang", "en", "--size", "1280x720"];
    let mut window = display.program(&data, level.into_iter().chain(shown));
    let _window = Peer(
        window
            .spawn()
            .map_err(|error| format!("the program: {error}"))?,
    );
    let mark = |shot: &microsim_tests::desktop::Shot| {
        shot.find(WINDOW, is_mark).filter(|blob| blob.count >= 60)
    };
    display.wait_for("the mark", Duration::from_secs(120), mark);
    display.focus("MicroSim");
    display.point([640, 450]);
    display.key("Return");
    std::thread::sleep(Duration::from_secs(1));
    let start = Instant::now();
    // Rectangles through the field, at 10 pixels in 30 ms.
    while start.elapsed() < MOVES {
        for by in [[200.0, 0.0], [0.0, 100.0], [-200.0, 0.0], [0.0, -100.0]] {
            display.drag(by, 20);
        }
    }
    display.key("Escape");
    std::thread::sleep(Duration::from_secs(2));
    display.key("F10");
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(60) {
        if let Some(line) = logged(&data.join("logs")) {
            let pairs = line
                .split_whitespace()
                .filter_map(|word| word.split_once('='));
            return Ok(pairs
                .map(|(name, value)| (name.to_owned(), value.trim_matches('"').to_owned()))
                .collect());
        }
        std::thread::sleep(Duration::from_millis(200));
    }
    display.keep(Path::new("bench-pictures.png"));
    Err(format!(
        "quality {quality}: the log states no run within a minute; what was seen then: bench-pictures.png"
    ))
}

/// The line about a run in the newest log.
fn logged(logs: &Path) -> Option<String> {
    let files = fs::read_dir(logs).ok()?.flatten().map(|entry| entry.path());
    let text = fs::read_to_string(files.max()?).ok()?;
    let line = text.lines().find(|line| line.contains("a run was shown"));
    line.map(str::to_owned)
}

/// A number of the log.
fn number(run: &BTreeMap<String, String>, name: &str) -> Result<f64, String> {
    let value = run
        .get(name)
        .ok_or_else(|| format!("the log has no {name}"))?;
    value
        .parse()
        .map_err(|error| format!("{name} = {value} in the log: {error}"))
}

/// Measures all qualities and describes them.
fn page() -> Result<String, String> {
    let mut text = format!(
        "# Pictures in the window\n\nCommand: `cargo xtask bench pictures`. Level 4 of coordination in the window, 1280 × 720 pixels, mono, without panels; the mouse moves the instrument in rectangles for {} s, by a program \
         beside that knows only the display. The level is computed in the same process. Single runs; p50 and p99 of the last thousand of each, in ms. Time of a picture: from the begin of its drawing to the driver's word that it is done.\n\n\
         | quality | pictures in a second | time of a picture, p50 | p99 | ticks | late | unconverged | without meaning |\n|---|---|---|---|---|---|---|---|\n",
        MOVES.as_secs()
    );
    let mut stages = String::from(
        "\nFrom a motion of the hand to the picture, by stage; the display's own time comes to that:\n\n\
         | quality | motion to its tick, p50 | p99 | tick, p50 | p99 | end of the tick to the picture, p50 | p99 | sum of p50 | sum of p99 |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for quality in QUALITIES {
        let run = measure(quality)?;
        let of = |name: &str| number(&run, name);
        if run["quality"] != quality {
            return Err(format!(
                "quality {quality} was asked for, {} was shown",
                run["quality"]
            ));
        }
        let _ = writeln!(
            text,
            "| {quality} | {:.1} | {:.1} | {:.1} | {} | {} | {} | {} |",
            of("rate")?,
            of("picture_p50")?,
            of("picture_p99")?,
            of("ticks")?,
            of("late")?,
            of("unconverged")?,
            of("held")?,
        );
        let mut row = format!("| {quality} |");
        let mut sums = [0.0; 2];
        for stage in ["to_tick", "tick", "to_picture"] {
            for (sum, part) in sums.iter_mut().zip(["p50", "p99"]) {
                let time = of(&format!("{stage}_{part}"))?;
                *sum += time;
                let _ = write!(row, " {time:.1} |");
            }
        }
        let _ = writeln!(stages, "{row} {:.1} | {:.1} |", sums[0], sums[1]);
    }
    Ok(text + &stages)
}

fn main() -> ExitCode {
    let written = page().and_then(|text| {
        print!("{text}");
        let file = repository().join("tests/results/pictures.md");
        fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("bench pictures: {why}");
            ExitCode::FAILURE
        }
    }
}
