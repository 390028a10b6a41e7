//! The window, used from outside: keys, mouse and what is seen on a display without a screen.

use microsim_tests::alter::change_header;
use microsim_tests::desktop::{Blob, Display, Shot};
use microsim_tests::peers::{Peer, or_skipped};
use microsim_tests::stations::Station;
use microsim_tests::{command, finish, microsim};
use serde_json::Value;
use std::cell::Cell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The part of the display that shows the field: panels of 270 pixels stand at both sides.
const FIELD: [[usize; 2]; 2] = [[275, 0], [1005, 720]];
/// Pixels per millimetre of a field of 25 mm that is 720 pixels high, and the cosine of its tilt of 50°.
const SCALE: f64 = 720.0 / 25.0;
const FORESHORTENING: f64 = 0.643;
/// Where a level is introduced before it begins.
const INTRODUCTION: [[usize; 2]; 2] = [[455, 0], [830, 210]];

/// Where the button of trainees and results lies in the launcher, the first name on their screen, and the buttons there that compare and export.
const RECORDS: [i32; 2] = [929, 24];
const FIRST_NAME: [i32; 2] = [150, 145];
const COMPARE: [i32; 2] = [380, 120];
const EXPORT: [i32; 2] = [500, 645];
/// On the screen of settings the language and the button that stores them.
const GERMAN: [i32; 2] = [350, 72];
const STORE: [i32; 2] = [80, 665];
/// On the screen of courses and data the first course, the line for a path and the button that reads the file.
const FIRST_COURSE: [i32; 2] = [150, 80];
const PATH: [i32; 2] = [400, 493];
const READ: [i32; 2] = [1070, 493];

/// Where the bar of a replay's time line lies.
const TIME_LINE: [[usize; 2]; 2] = [[0, 574], [1280, 588]];

/// The orange of a mark (0.85, 0.4, 0.05 and lit from above).
fn is_mark([r, g, b]: [u8; 3]) -> bool {
    r > 150 && (60..190).contains(&g) && b < 70 && i16::from(r) - i16::from(g) > 60
}

/// The blue of the scissors; that of buttons is brighter, the mat is greener.
fn is_scissors([r, g, b]: [u8; 3]) -> bool {
    b > 55 && g < 150 && i16::from(b) - i16::from(r) > 25 && i16::from(b) - i16::from(g) > 18
}

/// The light blue of the button that begins a level, and of the frame around it.
fn is_button([r, g, b]: [u8; 3]) -> bool {
    b > 200 && g > 150 && r < 130
}

/// The green of a verdict.
fn is_passed([r, g, b]: [u8; 3]) -> bool {
    r < 90 && g > 180 && (130..190).contains(&b)
}

fn window(display: &Display, data: &Path, arguments: &[&str]) -> Peer {
    let mut program = display.program(data, arguments.iter().copied());
    Peer(program.spawn().expect("the program starts"))
}

/// Keeps a picture for people in the folder that `MICROSIM_SHOTS` names, if it is set: those of the README are made so.
fn keep(display: &Display, name: &str) {
    if let Some(folder) = std::env::var_os("MICROSIM_SHOTS") {
        display.keep(&PathBuf::from(folder).join(name).with_extension("png"));
    }
}

fn some(blob: Option<Blob>, least: usize) -> Option<Blob> {
    blob.filter(|blob| blob.count >= least)
}

/// The one file of a kind in a folder, once it is there.
fn the_file(folder: &Path, extension: &str, most: Duration) -> PathBuf {
    let start = Instant::now();
    loop {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut files = entries
            .map(|e| e.path())
            .filter(|p| p.extension().is_some_and(|e| e == extension));
        if let Some(file) = files.next() {
            return file;
        }
        assert!(
            start.elapsed() < most,
            "no .{extension} in {} within {most:?}",
            folder.display()
        );
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Plays "One cut" in a new window, with what is recorded below `data`; gives the report, and whether the screen shows that it is passed.
fn play(display: &Display, data: &Path) -> (Value, bool) {
    let _window = window(display, data, &["window", "--size", "1280x720"]);

    // The launcher has come once there is text on it; the first module is chosen, the arrow chooses its second level.
    let is_text = |[r, g, b]: [u8; 3]| r > 220 && g > 220 && b > 220;
    let text = |shot: &Shot| some(shot.find([[0, 0], [500, 700]], is_text), 500);
    display.wait_for("the launcher", Duration::from_secs(60), text);
    // Beside the modules stand pictures of what is trained: pink tissue, where all else is grey and blue.
    let pink = |shot: &Shot| {
        let is_pink = |[r, g, b]: [u8; 3]| r > 150 && r > g.saturating_add(40) && b > 70;
        some(shot.find([[12, 84], [92, 700]], is_pink), 300)
    };
    display.wait_for("pictures of modules", Duration::from_secs(10), pink);
    keep(display, "window-launcher");
    display.focus("MicroSim");
    display.point([900, 640]);
    display.key("Right");
    display.key("Return");

    // Nothing moves before it is begun.
    let mark = |shot: &Shot| some(shot.find(FIELD, is_mark), 60);
    let (shot, mark) = display.wait_for("the mark", Duration::from_secs(60), mark);
    assert!(
        some(shot.find(FIELD, is_scissors), 100).is_some(),
        "the scissors are there"
    );
    keep(display, "window-introduction");
    // What introduces the level stands in the field, in a frame as blue as the scissors.
    let button = |shot: &Shot| some(shot.find(INTRODUCTION, is_button), 20);
    display.wait_for("the introduction", Duration::from_secs(10), button);
    display.key("Return");
    let gone = |shot: &Shot| button(shot).is_none().then_some(());
    display.wait_for("the training", Duration::from_secs(30), gone);

    // As high as the tissue: 2 mm up are eight steps of a hundredth of the field; that it rose is seen. A picture may still be that of the introduction, in a frame of their blue:
    // they are where two in a row show them.
    let upper = |shot: &Shot| some(shot.find(FIELD, is_scissors), 100).map(|blob| blob.top[1]);
    let last = Cell::new(f64::NAN);
    let at_rest = |shot: &Shot| {
        let now = upper(shot).filter(|_| button(shot).is_none());
        let now = now.unwrap_or(f64::NAN);
        (last.replace(now) == now).then_some(now)
    };
    let (_, start) = display.wait_for("the scissors at rest", Duration::from_secs(30), at_rest);
    for _ in 0..8 {
        display.key("w");
        std::thread::sleep(Duration::from_millis(80));
    }
    // Straight towards the mark: 20°, at 0.006 rad a pixel.
    display.button(3, true);
    display.drag([-20_f64.to_radians() / 0.006, 0.0], 30);
    display.button(3, false);

    // Beneath the mark, then forward until the tips are 1.3 mm behind the middle of the tissue. Two blades are seen, the upper one further up by half of what they are open: 20° over
    // 8 mm from the hinge, seen under the tilt.
    let rise = 2.0 * 0.766 * SCALE;
    let has_risen = |shot: &Shot| upper(shot).filter(|now| start - now > 0.5 * rise);
    display.wait_for("that the scissors rise", Duration::from_secs(10), has_risen);
    keep(display, "window-turned");
    let tips = |display: &Display| {
        let shot = display.shot();
        let blob = some(shot.find(FIELD, is_scissors), 100).expect("the scissors are in the field");
        let blade = 8.0 * 10_f64.to_radians().sin() * 0.766 * SCALE;
        [blob.top[0], blob.top[1] + blade]
    };
    for steps in [50, 15] {
        let [x, y] = tips(display);
        let behind = 1.3 * FORESHORTENING * SCALE;
        // What is seen of the mark lies 0.3 mm above the middle.
        let middle = mark.centre[1] + 0.3 * 0.766 * SCALE;
        display.drag([mark.centre[0] - x, 0.0], steps);
        display.drag([0.0, middle - behind - y], 2 * steps);
        std::thread::sleep(Duration::from_millis(500));
    }
    keep(display, "window-training");
    display.button(1, true);
    std::thread::sleep(Duration::from_millis(1000));
    display.button(1, false);

    let sessions = data.join("sessions");
    let report = the_file(&sessions, "json", Duration::from_secs(90));
    let passed = |shot: &Shot| some(shot.find([[0, 0], [640, 60]], is_passed), 200);
    let seen = display.wait_for("the verdict", Duration::from_secs(60), |shot| {
        passed(shot).or_else(|| {
            some(
                shot.find([[0, 0], [640, 60]], |[r, g, b]| {
                    r > 200 && (120..180).contains(&g) && b < 100
                }),
                200,
            )
        })
    });
    keep(display, "window-debrief");
    let is_passed = passed(&seen.0).is_some();
    if is_passed {
        replay(display);
        display.wait_for("the verdict again", Duration::from_secs(60), passed);
    }
    let report: Value =
        serde_json::from_slice(&std::fs::read(report).expect("read")).expect("JSON");
    (report, is_passed)
}

/// The knob of the time line of a replay, across [pixels]: a disc of nearly white on the bar, which is green as far as it was compared.
fn knob(shot: &Shot) -> Option<f64> {
    let is_white = |[r, g, b]: [u8; 3]| r > 220 && g > 220 && b > 220;
    some(shot.find(TIME_LINE, is_white), 40).map(|blob| blob.centre[0])
}

/// From the debrief to the replay and back: it plays, goes a tick back, to the end and to the begin, and is the same as what was recorded.
fn replay(display: &Display) {
    let most = Duration::from_secs(120);
    display.focus("MicroSim");
    display.key("r");
    // Its first tick: the mark and the scissors as they were, and the knob at the left end.
    let view = [[5, 70], [980, 520]];
    let (_, begin) = display.wait_for("the replay", most, |shot| {
        some(shot.find(view, is_mark), 60)?;
        some(shot.find(view, is_scissors), 100)?;
        knob(shot).filter(|x| *x < 60.0)
    });
    // The state of the comparison is green text above the picture.
    let standing = [[0, 40], [985, 75]];
    let same = |shot: &Shot| some(shot.find(standing, is_passed), 100);
    display.wait_for("that it is the same", most, same);
    display.key("5");
    display.key("space");
    let (_, played) = display.wait_for("that it plays", most, |shot| {
        knob(shot).filter(|x| *x > begin + 60.0)
    });
    display.key("space");
    // Forty ticks back are at least eight pixels of the time line of a run of less than a minute. What is on its way to the picture when it pauses comes before.
    let (_, paused) = display.wait_for("that it pauses", most, |_| {
        let before = knob(&display.shot())?;
        std::thread::sleep(Duration::from_millis(1000));
        knob(&display.shot()).filter(|now| (now - before).abs() < 1.0)
    });
    assert!(paused >= played - 1.0, "{paused} and {played}");
    for _ in 0..40 {
        display.key("Left");
    }
    display.wait_for("that it goes back", most, |shot| {
        knob(shot).filter(|x| *x < paused - 3.0)
    });
    display.key("End");
    display.wait_for("the end", most, |shot| knob(shot).filter(|x| *x > 1200.0));
    let (shot, _) = display.wait_for("that it is the same to the end", most, same);
    let is_orange = |[r, g, b]: [u8; 3]| r > 200 && (120..180).contains(&g) && b < 100;
    assert_eq!(
        some(shot.find(standing, is_orange), 20),
        None,
        "nothing differs"
    );
    keep(display, "window-replay");
    display.key("Home");
    display.wait_for("the begin", most, |shot| {
        some(shot.find(view, is_mark), 60)?;
        knob(shot).filter(|x| (x - begin).abs() < 2.0)
    });
    display.key("Escape");
}

/// Whoever sees the launcher, the mark and the scissors, and has read the help beside the picture, passes "One cut". The session replays to the bit.
#[test]
fn coordination_level_2_is_passed_by_mouse_and_keyboard() {
    let Some(display) = or_skipped("a display without a screen", Display::open()) else {
        return;
    };
    let pictures = &microsim(["doctor", "--json"]).json()["pictures"];
    if pictures["on"] != true {
        eprintln!("SKIPPED: {}", pictures["why"]);
        return;
    }
    // On a busy machine pictures come so slowly that whoever waits for them stands still for too long: then it is tried again, as people do.
    for attempt in 1.. {
        let folder = tempfile::tempdir().expect("a folder");
        let data = folder.path().join("data");
        std::fs::create_dir(&data).expect("a folder");
        let (report, is_seen) = play(&display, &data);
        if report["verdict"] != "passed" && attempt < 5 {
            eprintln!("attempt {attempt}: {}", report["reasons"]);
            continue;
        }
        assert_eq!(report["verdict"], "passed", "{}", report["reasons"]);
        assert!(is_seen, "the verdict is on the screen");
        let solver = &report["solver"];
        assert_eq!(solver["held"], 0, "{solver}");

        let session = the_file(&data.join("sessions"), "session", Duration::from_secs(1));
        for threads in ["1", "2"] {
            let mut replay = command(["replay", "--verify", "--threads", threads]);
            finish(replay.arg(&session)).expect(0);
        }
        return;
    }
}

/// The journey of the README: the two attempts of A. Muster are found, compared, and the group exported, with four clicks.
#[test]
fn four_clicks_find_compare_and_export() {
    let Some(display) = or_skipped("a display without a screen", Display::open()) else {
        return;
    };
    let pictures = &microsim(["doctor", "--json"]).json()["pictures"];
    if pictures["on"] != true {
        eprintln!("SKIPPED: {}", pictures["why"]);
        return;
    }
    let station = Station::new();
    for name in ["A. Muster", "B. Beispiel", "C. Exempel"] {
        station.add(name);
        let group = if name.starts_with('C') {
            "2025"
        } else {
            "2026"
        };
        station
            .microsim(&["trainees", "group", group, "--add", name])
            .expect(0);
    }
    for (name, script, who) in [
        ("1", "fail-too-slow", "A. Muster"),
        ("2", "pass", "A. Muster"),
        ("3", "pass", "B. Beispiel"),
        ("4", "pass", "C. Exempel"),
    ] {
        finish(&mut station.run(name, script, &["--trainee", who, "--no-pictures"])).expect(0);
    }
    let _window = window(&display, &station.data(), &["window", "--size", "1280x720"]);
    let is_text = |[r, g, b]: [u8; 3]| r > 220 && g > 220 && b > 220;
    let text = |shot: &Shot| some(shot.find([[0, 60], [500, 700]], is_text), 500);
    display.wait_for("the launcher", Duration::from_secs(60), text);
    let most = Duration::from_secs(30);
    // Words in the colours of verdicts, and of what became better or worse.
    let is_orange = |[r, g, b]: [u8; 3]| r > 200 && (120..180).contains(&g) && b < 100;
    let list = [[320, 100], [1280, 640]];
    display.click(RECORDS);
    display.wait_for("the results of all", most, |shot| {
        some(shot.find(list, is_passed), 200)
    });
    display.click(FIRST_NAME);
    // Both attempts of one, of which one failed, marked: the letters are blue.
    let is_blue = |[r, g, b]: [u8; 3]| r < 120 && (150..200).contains(&g) && b > 200;
    display.wait_for("the results of A. Muster", most, |shot| {
        some(shot.find([[316, 145], [332, 205]], is_blue), 20)
    });
    keep(&display, "window-results");
    display.click(COMPARE);
    let better = [[1100, 160], [1280, 640]];
    display.wait_for("what became better and worse", most, |shot| {
        some(shot.find(better, is_passed), 40)?;
        some(shot.find(better, is_orange), 20)
    });
    keep(&display, "window-comparison");
    display.click(EXPORT);
    let table = the_file(&station.data().join("tables"), "csv", most);
    let done = [[320, 60], [1280, 130]];
    display.wait_for("that it is written", most, |shot| {
        some(shot.find(done, is_passed), 100)
    });
    keep(&display, "window-export");
    let mut reader = csv::Reader::from_path(table).expect("a table");
    let header = reader.headers().expect("a header").clone();
    let at = |name: &str| header.iter().position(|h| h == name).expect("a column");
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("a row")).collect();
    let column = |name: &str| -> BTreeSet<&str> { rows.iter().map(|r| &r[at(name)]).collect() };
    assert_eq!(column("session").len(), 3);
    assert_eq!(column("groups"), BTreeSet::from(["2026"]));
    assert_eq!(column("name"), BTreeSet::from(["A. Muster", "B. Beispiel"]));
    read_files(&display, &station);
}

/// The settings are changed and stored by mouse; the next window has them, and the program refuses none of what was written.
#[test]
fn settings_are_stored_for_the_station() {
    let Some(display) = or_skipped("a display without a screen", Display::open()) else {
        return;
    };
    let pictures = &microsim(["doctor", "--json"]).json()["pictures"];
    if pictures["on"] != true {
        eprintln!("SKIPPED: {}", pictures["why"]);
        return;
    }
    let station = Station::new();
    let most = Duration::from_secs(60);
    let _window = window(&display, &station.data(), &["window", "--size", "1280x720"]);
    let is_text = |[r, g, b]: [u8; 3]| r > 220 && g > 220 && b > 220;
    let launcher = |shot: &Shot| some(shot.find([[0, 60], [500, 700]], is_text), 500);
    display.wait_for("the launcher", most, launcher);
    display.focus("MicroSim");
    display.key("F5");
    // Below the rows there is nothing, where the launcher has modules.
    display.wait_for("the settings", most, |shot| {
        let below = shot.find([[0, 480], [520, 620]], is_text);
        some(shot.find([[0, 60], [300, 340]], is_text), 200).filter(|_| below.is_none())
    });
    keep(&display, "window-settings");
    display.click(GERMAN);
    // The German heading is longer than "Settings".
    display.wait_for("German", most, |shot| {
        some(shot.find([[110, 8], [160, 36]], is_text), 20)
    });
    display.click(STORE);
    let file = the_file(
        &station.data().join("config"),
        "toml",
        Duration::from_secs(30),
    );
    assert!(file.ends_with("window.toml"), "{}", file.display());
    display.wait_for("that it is stored", most, |shot| {
        some(shot.find([[0, 640], [1280, 720]], is_passed), 50)
    });
    let text = std::fs::read_to_string(&file).expect("it was written");
    assert!(
        text.contains("language = \"de\"\n") && text.contains("stereo = \"mono\""),
        "{text}"
    );
    station.microsim(&["check"]).expect(0);
}

/// From the results: a course is read from its file, whose path is typed, and shown with the group that takes it; a table with a mistake is refused with its line.
fn read_files(display: &Display, station: &Station) {
    let most = Duration::from_secs(30);
    let orange = |[r, g, b]: [u8; 3]| r > 200 && (120..180).contains(&g) && b < 100;
    let said = [[0, 610], [1280, 720]];
    let folder = station.folder();
    let course = folder.join("course.toml");
    let shipped = microsim_tests::tree().join("config/courses/first-steps.toml");
    std::fs::copy(shipped, &course).expect("the shipped course");
    let table = folder.join("experts.csv");
    let rows = "module,level,metric,source,n,mean,sd\ntouch-spheres,one,time,experts,12,30,4.5\n";
    std::fs::write(&table, rows).expect("a table");
    display.focus("MicroSim");
    display.key("F6");
    std::thread::sleep(Duration::from_secs(1));
    let read = |file: &Path| {
        display.click(PATH);
        std::thread::sleep(Duration::from_secs(1));
        display.key("ctrl+a");
        display.text(file.to_str().expect("text"));
        std::thread::sleep(Duration::from_millis(500));
        display.click(READ);
    };
    read(&course);
    display.wait_for("that the course is read", most, |shot| {
        some(shot.find(said, is_passed), 100)
    });
    station
        .microsim(&["courses", "enrol", "first-steps", "--group", "2026"])
        .expect(0);
    read(&table);
    display.wait_for("what is wrong with the table", most, |shot| {
        some(shot.find(said, orange), 100)
    });
    display.click(FIRST_COURSE);
    std::thread::sleep(Duration::from_secs(1));
    keep(display, "window-data");
    let courses = station.microsim(&["courses", "list", "--json"]).expect(0);
    let courses = &courses.json()["courses"];
    assert_eq!(courses[0]["name"], "first-steps");
}

/// A session that cannot be replayed: why, in the language of the window, before there is one. No display is needed for that.
#[test]
fn what_cannot_be_replayed_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = folder.path().join("text.session");
    std::fs::write(&text, "no session").expect("a file");
    let missing = folder.path().join("missing.session");
    for (session, why) in [
        (&text, "not a session file"),
        (&missing, "there is no such file"),
    ] {
        for (language, what) in [
            ("en", "the session cannot be replayed: session "),
            (
                "de",
                "die Aufzeichnung kann nicht abgespielt werden: session ",
            ),
        ] {
            let mut program = command(["window", "--lang", language, "--replay"]);
            let finished = finish(program.arg(session).env_remove("DISPLAY")).expect(2);
            assert_eq!(finished.err.trim().lines().count(), 1, "{finished:?}");
            for part in [what, why, &session.display().to_string()] {
                assert!(finished.err.contains(part), "{part}: {finished:?}");
            }
        }
    }
}

/// A session of a module that is not installed here is refused as well.
#[test]
fn a_session_of_a_module_that_is_not_installed_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let session = folder.path().join("a.session");
    let args = ["--input", "script:level1-pass.toml", "--no-pictures"];
    microsim_tests::run("touch-spheres", &session, &args);
    let bytes = std::fs::read(&session).expect("a session");
    let other = change_header(&bytes, |header| {
        header.plan.module = "elsewhere".into();
    });
    std::fs::write(&session, other).expect("a file");
    let mut program = command(["window", "--replay"]);
    let finished = finish(program.arg(&session).env_remove("DISPLAY")).expect(2);
    let expected = ["cannot be replayed", "elsewhere"];
    assert!(
        expected.iter().all(|part| finished.err.contains(part)),
        "{finished:?}"
    );
}

/// Where there is no display: one sentence, exit status 2, and everything else goes on working.
#[test]
fn without_a_display_one_sentence_says_what_is_missing() {
    for arguments in [&["window"][..], &[]] {
        let mut program = command(arguments);
        let finished = finish(program.env_remove("DISPLAY")).expect(2);
        assert_eq!(finished.err.trim().lines().count(), 1, "{finished:?}");
        assert!(finished.err.contains("no display"), "{finished:?}");
    }
}
