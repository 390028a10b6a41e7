//! A driver that loses its device while somebody trains in the window: the window comes back, or the program states in one sentence why not; the recording is whole in both cases.

use microsim_tests::desktop::{Display, Shot};
use microsim_tests::driver::Driver;
use microsim_tests::peers::{Peer, or_skipped};
use microsim_tests::{finish, microsim, report_beside};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const WINDOW: [[usize; 2]; 2] = [[0, 0], [1280, 720]];
const MOST: Duration = Duration::from_secs(60);

/// The orange of a mark (0.85, 0.4, 0.05 and lit from above).
fn is_mark([r, g, b]: [u8; 3]) -> bool {
    r > 150 && (60..190).contains(&g) && b < 70 && i16::from(r) - i16::from(g) > 60
}

/// The orange of a sentence about what is wrong (240, 150, 60).
fn is_complaint([r, g, b]: [u8; 3]) -> bool {
    r > 200 && (120..165).contains(&g) && (40..80).contains(&b)
}

fn until(what: &str, seen: impl Fn() -> bool) {
    let start = Instant::now();
    while !seen() {
        assert!(start.elapsed() < MOST, "not within {MOST:?}: {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn the_session(data: &Path) -> PathBuf {
    let files = fs::read_dir(data.join("sessions"))
        .expect("sessions")
        .flatten();
    let mut sessions = files
        .map(|file| file.path())
        .filter(|path| path.extension().is_some_and(|e| e == "session"));
    let session = sessions.next().expect("a session");
    assert_eq!(sessions.next(), None, "one session");
    session
}

/// Level 2 of coordination goes on in a window; what is done with its driver, and with the program.
fn train(name: &str, act: impl FnOnce(&Display, &Driver, &mut Peer, &Path)) {
    let Some(display) = or_skipped("a display without a screen", Display::open()) else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let built = Driver::build(&folder.path().join("driver"));
    let Some(driver) = or_skipped("a driver that loses its device", built) else {
        return;
    };
    let pictures = &microsim(["doctor", "--json"]).json()["pictures"];
    if pictures["on"] != true {
        eprintln!("SKIPPED: {}", pictures["why"]);
        return;
    }
    let data = folder.path().join("data");
    fs::create_dir_all(data.join("config")).expect("a folder");
    fs::write(data.join("config/window.toml"), "quality = \"low\"\n").expect("a file");
    let arguments = [
        "window",
        "coordination",
        "--level",
        "2",
        "--size",
        "1280x720",
    ];
    let mut window = display.program(&data, arguments);
    driver.put_below(&mut window);
    let errors = File::create(data.join("errors")).expect("a file");
    window.stderr(errors);
    let mut window = Peer(window.spawn().expect("the program starts"));
    display.wait_for(&format!("the mark {name}"), MOST, |shot: &Shot| {
        shot.find(WINDOW, is_mark).filter(|blob| blob.count >= 60)
    });
    display.focus("MicroSim");
    display.point([640, 450]);
    display.key("Return");
    std::thread::sleep(Duration::from_secs(1));
    act(&display, &driver, &mut window, &data);
    let text = fs::read_to_string(data.join("errors")).expect("standard error");
    assert!(!text.contains("panicked"), "{text}");
}

/// Twice: the window comes back with the same level, paused, and states what happened; the run goes on and replays to the bit.
#[test]
fn the_window_comes_back_and_the_run_goes_on() {
    train("that comes back", |display, driver, window, data| {
        for _ in 0..2 {
            let order = driver.lose();
            until("the device is lost", || {
                display.drag([20.0, 0.0], 4);
                display.drag([-20.0, 0.0], 4);
                !order.exists()
            });
            // The card of a pause, at the upper edge.
            let card = [[470, 0], [810, 160]];
            display.wait_for("what happened", MOST, |shot| {
                shot.find(card, is_complaint)
                    .filter(|blob| blob.count >= 100)
            });
            display.focus("MicroSim");
            display.key("Escape");
            // It goes on: no card.
            display.wait_for("the field", MOST, |shot| {
                shot.find(card, is_complaint).is_none().then_some(())
            });
            std::thread::sleep(Duration::from_secs(1));
        }
        assert_eq!(window.0.try_wait().expect("a process"), None, "it runs");
        let session = the_session(data);
        display.key("Escape");
        std::thread::sleep(Duration::from_secs(1));
        display.key("F10");
        until("the report", || session.with_extension("html").exists());
        let report = report_beside(&session);
        // A second before the first loss, one after each: less would mean that it stood still.
        assert!(
            report["simulated"].as_f64() > Some(3.0),
            "{}",
            report["simulated"]
        );
        finish(microsim_tests::command(["replay", "--verify"]).arg(&session)).expect(0);
    });
}

/// Where no device opens any more: exit status 2, one sentence, and a session that ends as one of a window that was closed.
#[test]
fn without_another_device_one_sentence_states_what_happened() {
    train(
        "that does not come back",
        |display, driver, window, data| {
            driver.refuse();
            let order = driver.lose();
            let mut status = None;
            let start = Instant::now();
            while status.is_none() {
                assert!(start.elapsed() < MOST, "it goes on without a picture");
                if order.exists() {
                    display.drag([20.0, 0.0], 4);
                }
                std::thread::sleep(Duration::from_millis(100));
                status = window.0.try_wait().expect("a process");
            }
            assert_eq!(status.and_then(|status| status.code()), Some(2));
            let text = fs::read_to_string(data.join("errors")).expect("standard error");
            let sentences: Vec<&str> = text
                .lines()
                .filter(|line| line.starts_with("microsim: "))
                .collect();
            assert_eq!(sentences.len(), 1, "{text}");
            for part in [
                "the graphics driver failed",
                "could not be had back",
                "what was recorded is safe",
            ] {
                assert!(sentences[0].contains(part), "{text}");
            }
            let session = the_session(data);
            assert_eq!(report_beside(&session)["verdict"], "aborted");
            finish(microsim_tests::command(["replay", "--verify"]).arg(&session)).expect(0);
        },
    );
}
