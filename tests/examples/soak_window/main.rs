//! `cargo xtask soak window [-- MINUTES SEED | passes [MODULE [LEVEL]] | memory]`: half an hour of play in one window at a display without a screen, from outside: keys, mouse, files and the log are all that is known of it.
//!
//! First every level, until it is passed: somebody does what its script that passes does, one hand after the other; writes `tests/results/soak_window_passes.md`. Then, in another window, every level that is played later is shown once, and level after level is played by a clumsy hand; paused, begun again, aborted; debrief, replay, results, settings; another size, minimised, another scale, the driver lost. Writes
//! `tests/results/soak_window.md`. Last, in a third window, one level of each module is begun and aborted ten times; writes `tests/results/soak_window_memory.md`.
//!
//! Ends with status 1 if a level is not passed, if the window panics, freezes, ends, loses a session or records one that does not replay, if memory grows, or if more ticks are late than may be.

mod account;
mod memory;
mod page;
mod passes;
mod player;
mod strokes;

use account::{Memory, Shown};
use microsim_random::SplitMix64;
use microsim_tests::desktop::Display;
use microsim_tests::driver::Driver;
use microsim_tests::peers::Peer;
use microsim_tests::{command, finish, microsim, repository, scratch};
use player::{Player, data_folder};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

const MINUTES: f64 = 30.0;
/// What a level takes with all around it \[s\], and for how long the hand moves.
const SLOT: f64 = 58.0;
const PLAYED: f64 = 22.0;
/// One in so many sessions is computed again.
const REPLAYED: u64 = 5;

/// What happens in the middle of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Event {
    Resized,
    Minimised,
    Unmapped,
    Scaled,
    DriverLost,
    FullScreen,
    BegunAnew,
    QualityAndPanels,
}

const EVENTS: [Event; 8] = [
    Event::DriverLost,
    Event::Resized,
    Event::Scaled,
    Event::Minimised,
    Event::BegunAnew,
    Event::FullScreen,
    Event::QualityAndPanels,
    Event::Unmapped,
];

/// What came of it.
#[derive(Debug)]
struct Soak {
    minutes: f64,
    seed: u64,
    /// Module and level of each slot, and what happened in its middle.
    slots: Vec<(String, u32, Event)>,
    shown: Vec<Shown>,
    memory: Memory,
    sessions: usize,
    replayed: usize,
    /// Size of all recordings \[bytes\].
    recorded: u64,
    faults: Vec<String>,
}

/// A level.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Level {
    /// Where its module stands in the launcher, from 0.
    place: usize,
    module: String,
    number: u32,
}

/// All levels.
fn levels() -> Vec<Level> {
    let listed = microsim(["list", "--json"]).json();
    let modules = listed["modules"].as_array().cloned().unwrap_or_default();
    let of = |(place, module): (usize, &serde_json::Value)| {
        let name = module["name"].as_str().unwrap_or_default().to_owned();
        let count = module["levels"].as_array().map_or(0, Vec::len) as u32;
        (1..=count)
            .map(move |number| Level {
                place,
                module: name.clone(),
                number,
            })
            .collect::<Vec<_>>()
    };
    modules.iter().enumerate().flat_map(of).collect()
}

fn happen(
    event: Event,
    player: &mut Player<'_>,
    driver: &Driver,
    session: &Path,
) -> Result<PathBuf, String> {
    let id = player.focus()?;
    let display = player.display;
    let mut session = session.to_owned();
    match event {
        Event::Resized => {
            let sizes = [["1000", "640"], ["1920", "1080"], ["1366", "768"]];
            for [width, height] in sizes {
                display.ask(&["windowsize", &id, width, height])?;
                player.wait(1.5);
                player.focus()?;
                player.gesture()?;
            }
            display.ask(&["windowsize", &id, "1280", "720"])?;
        }
        Event::Minimised => {
            display.ask(&["windowminimize", "--sync", &id])?;
            player.wait(3.0);
            display.ask(&["windowmap", "--sync", &id])?;
        }
        Event::Unmapped => {
            display.ask(&["windowunmap", "--sync", &id])?;
            player.wait(3.0);
            display.ask(&["windowmap", "--sync", &id])?;
        }
        Event::Scaled => {
            // Scales of 1.5 and 1.25.
            for per_inch in [144, 120] {
                display.set_resolution(per_inch)?;
                player.wait(1.5);
                player.focus()?;
                player.gesture()?;
            }
            display.set_resolution(96)?;
            player.wait(1.0);
            display.ask(&["windowsize", &id, "1280", "720"])?;
        }
        Event::DriverLost => {
            let order = driver.lose();
            let start = Instant::now();
            while order.exists() && start.elapsed() < Duration::from_secs(20) {
                player.gesture()?;
            }
            if order.exists() {
                return Err("the driver was not asked for anything for 20 s".into());
            }
            player.wait(2.0);
            player.focus()?;
            // It waits in a pause.
            player.keys(&["Escape"])?;
            draw_in_every_quality(player)?;
        }
        Event::FullScreen => {
            player.keys(&["F11"])?;
            player.wait(2.0);
            player.focus()?;
            player.gesture()?;
            player.keys(&["F11"])?;
        }
        Event::BegunAnew => session = player.restart()?,
        Event::QualityAndPanels => {
            player.keys(&["F2", "F3"])?;
            player.wait(1.0);
            player.keys(&["F3"])?;
        }
    }
    player.wait(1.0);
    player.focus()?;
    Ok(session)
}

/// A level from the launcher to the launcher.
fn slot(player: &mut Player<'_>, driver: &Driver, n: usize, level: &Level) -> Result<(), String> {
    player.focus()?;
    let mut session = player.begin(level.place, level.number)?;
    player.play(&session, PLAYED / 2.0)?;
    if !player.has_ended(&session) {
        session = happen(EVENTS[n % EVENTS.len()], player, driver, &session)?;
        player.play(&session, PLAYED / 2.0)?;
    }
    player.end(&session)?;
    if n.is_multiple_of(3) {
        player.replay()?;
    }
    player.to_modules()?;
    match n % 3 {
        1 => player.records(),
        2 => player.settings(),
        _ => Ok(()),
    }
}

/// A level in which nothing is measured.
fn warm_up(player: &mut Player<'_>) -> Result<(), String> {
    let session = player.begin(0, 1)?;
    draw_in_every_quality(player)?;
    player.end(&session)?;
    player.to_modules()
}

/// Draws in every quality once, and comes back to the first: what each needs is compiled with its first picture on a device and stays, which is no growth.
fn draw_in_every_quality(player: &mut Player<'_>) -> Result<(), String> {
    for _ in 0..3 {
        player.keys(&["F2"])?;
        player.wait(4.0);
    }
    Ok(())
}

fn soak(minutes: f64, seed: u64) -> Result<Soak, String> {
    let folder = scratch();
    let data = data_folder(folder.path())?;
    let failed = |error: std::io::Error| format!("{}: {error}", data.display());
    let driver = Driver::build(&folder.path().join("driver"))?;
    let mut display = Display::open_of([1920, 1080])?;
    display.manage(folder.path())?;
    display.set_resolution(96)?;
    let mut window = display.program(&data, ["window", "--lang", "en", "--size", "1280x720"]);
    driver.put_below(&mut window);
    let errors = folder.path().join("errors");
    let file = File::create(&errors).map_err(failed)?;
    window.stderr(file);
    let mut window = Peer(
        window
            .spawn()
            .map_err(|error| format!("the program: {error}"))?,
    );
    let memory = account::watch(window.0.id());
    let mut player = Player::new(&display, seed, &data);
    player.focus()?;
    player.wait(3.0);
    warm_up(&mut player)?;

    let levels = levels();
    let count = ((60.0 * minutes / SLOT).round() as usize).max(1);
    // All of them, or as many as there is time for, evenly.
    let levels: Vec<_> = (0..count)
        .map(|n| match count < levels.len() {
            true => &levels[(2 * n + 1) * levels.len() / (2 * count)],
            false => &levels[n % levels.len()],
        })
        .collect();
    let looked_at: BTreeSet<_> = levels.iter().collect();
    for level in looked_at {
        player.focus()?;
        let seen = player.look_at(level.place, level.number);
        let Level { module, number, .. } = level;
        seen.map_err(|why| format!("{module} level {number}, before anything is measured: {why}"))?;
    }
    let mut soak = Soak {
        minutes,
        seed,
        slots: Vec::new(),
        shown: Vec::new(),
        memory: Memory::default(),
        sessions: 0,
        replayed: 0,
        recorded: 0,
        faults: Vec::new(),
    };
    let before = player.begun();
    for (n, level) in levels.into_iter().enumerate() {
        let event = EVENTS[n % EVENTS.len()];
        eprintln!("{} level {}: {event:?}", level.module, level.number);
        soak.slots.push((level.module.clone(), level.number, event));
        if let Err(why) = slot(&mut player, &driver, n, level) {
            let picture = std::env::temp_dir().join("soak-window.png");
            display.keep(&picture);
            let state = window.0.try_wait().map_err(failed)?;
            let state = state.map_or("it runs still".into(), |status| {
                format!("it has ended: {status}")
            });
            soak.faults.push(format!(
                "{} level {}, {event:?}: {why}; {state}; what was seen: {}",
                level.module,
                level.number,
                picture.display()
            ));
            break;
        }
        memory.rest();
    }
    soak.memory = memory.stop();
    let sessions = player.begun();
    // As a desktop closes a window: the last session ends with it.
    if let Ok(id) = player.focus() {
        let _ = display.ask(&["windowquit", &id]);
    }
    let start = Instant::now();
    while window.0.try_wait().map_err(failed)?.is_none()
        && start.elapsed() < Duration::from_secs(30)
    {
        std::thread::sleep(Duration::from_millis(200));
    }
    drop(window);
    let text = fs::read_to_string(&errors).unwrap_or_default();
    soak.faults.extend(account::panics(&text));
    let log = account::log(&data.join("logs"))?;
    soak.faults.extend(account::panics(&log));
    let played: BTreeSet<PathBuf> = sessions.difference(&before).cloned().collect();
    soak.shown = account::shown(&log, &played);
    // For whoever asks why ticks were late.
    for run in soak.shown.iter().filter(|run| page::is_late(run)) {
        let copy = std::env::temp_dir().join(run.session.file_name().unwrap_or_default());
        match fs::copy(&run.session, &copy) {
            Ok(_) => eprintln!("late ticks: {}", copy.display()),
            Err(why) => eprintln!("late ticks: {}: {why}", copy.display()),
        }
    }
    soak.sessions = sessions.len();
    let mut random = SplitMix64(seed);
    for session in &sessions {
        soak.recorded += fs::metadata(session).map_err(failed)?.len();
        let name = session.file_name().unwrap_or_default().to_string_lossy();
        let mut read = command(["report", "--json"]);
        if finish(read.arg(session)).code != Some(0) {
            soak.faults.push(format!("{name} cannot be read"));
        }
        if random.below(REPLAYED) == 0 {
            soak.replayed += 1;
            let mut replay = command(["replay", "--verify"]);
            let replayed = finish(replay.arg(session));
            if replayed.code != Some(0) {
                soak.faults
                    .push(format!("{name} does not replay: {}", replayed.err.trim()));
            }
        }
    }
    Ok(soak)
}

/// What is asked for.
enum Order {
    /// All of it.
    All,
    /// Somebody plays for so many minutes, with a seed.
    Minutes(f64, u64),
    /// Levels of modules whose names begin so, or one of them, are passed: a page is written of all of them alone.
    Passes(String, Option<u32>),
    /// What levels leave behind.
    Memory,
}

fn order(words: &[String]) -> Option<Order> {
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        [] => Some(Order::All),
        ["memory"] => Some(Order::Memory),
        ["passes"] => Some(Order::Passes(String::new(), None)),
        ["passes", module] => Some(Order::Passes(module.into(), None)),
        ["passes", module, level] => Some(Order::Passes(module.into(), Some(level.parse().ok()?))),
        [minutes, ref seed @ ..] => {
            let minutes = minutes.parse().ok().filter(|minutes| *minutes > 0.0)?;
            match seed {
                [] => Some(Order::Minutes(minutes, 1)),
                [seed] => Some(Order::Minutes(minutes, seed.parse().ok()?)),
                _ => None,
            }
        }
    }
}

fn write(name: &str, text: &str) -> Result<(), String> {
    print!("{text}");
    let file = repository().join("tests/results").join(name);
    fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))
}

/// Whether all is as it should be.
fn run(order: &Order) -> Result<bool, String> {
    match order {
        Order::All => {
            let passes = run(&Order::Passes(String::new(), None))?;
            let minutes = run(&Order::Minutes(MINUTES, 1))?;
            Ok(run(&Order::Memory)? && minutes && passes)
        }
        Order::Minutes(minutes, seed) => {
            let soak = soak(*minutes, *seed)?;
            let (text, is_good) = page::of(&soak);
            write("soak_window.md", &text)?;
            Ok(is_good)
        }
        Order::Memory => {
            let (text, is_good) = memory::page(&memory::rests()?);
            write("soak_window_memory.md", &text)?;
            Ok(is_good)
        }
        Order::Passes(module, number) => {
            let attempts = passes::play(module, *number)?;
            let (text, is_good) = passes::page(&attempts);
            match module.is_empty() {
                true => write("soak_window_passes.md", &text)?,
                false => print!("{text}"),
            }
            Ok(is_good)
        }
    }
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let Some(order) = order(&words) else {
        eprintln!(
            "expected MINUTES, above 0, and SEED, or passes and the begin of a module's name with or without a level's number, or memory, or nothing"
        );
        return ExitCode::from(2);
    };
    match run(&order) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("soak window: {why}");
            ExitCode::FAILURE
        }
    }
}
