//! A replay around its picture, and how a debrief leads to it.

use super::records::{LONG, SIZE, click_on};
use super::{LANGUAGES, SIZES, check, check_height, everywhere, long_debrief, texts};
use crate::console::{Asked, Console, by_key};
use crate::debrief::{self, Next};
use crate::film_row::{self, FilmRow};
use crate::films::{Filmed, Video};
use crate::ghost::Track;
use crate::ledger::Debrief;
use crate::player::State;
use crate::references::{Ghost, Motion, ReadTrack, Reference, References};
use crate::replay::waiting;
use crate::timeline;
use eframe::egui::{self, Key, Ui};
use microsim_host::playback::Standing;
use microsim_host::replay::Difference;
use microsim_message::LocalText;
use microsim_render::Quality;
use microsim_report::Report;
use microsim_vocabulary::Language;

fn state() -> State {
    State {
        is_open: true,
        range: 0..25_000,
        shown: Some(12_345),
        working: None,
        standing: Standing {
            compared: 20_000,
            difference: None,
            is_complete: false,
            complaint: None,
        },
        rebuilt: Vec::new(),
        rate: Some(0.25),
        failure: None,
    }
}

fn differing() -> State {
    let what = "message \"tool.states\" of \"translator\" differs: recorded ".to_owned();
    State {
        standing: Standing {
            compared: 20_000,
            difference: Some(Difference {
                tick: 1234,
                what: what + &"{\"tools\":[]} ".repeat(40),
            }),
            is_complete: false,
            complaint: None,
        },
        working: Some((24_000, 0.4)),
        ..state()
    }
}

fn show(ui: &mut Ui, report: &Report, state: &State, language: Language) -> Vec<Asked> {
    let marks = timeline::marks(report);
    let curves = [
        timeline::speeds(report, language),
        timeline::forces(report, language),
    ];
    let console = Console {
        report,
        marks: &marks,
        curves: &curves,
        state,
        plays: true,
        speed: 2,
        magnification: 12.5,
        quality: Quality::Medium,
        ghost: true,
        films: true,
        panels: true,
    };
    console.show(ui, &mut Vec::new(), language)
}

#[test]
fn a_replay_has_room_for_its_texts() {
    let report = long_debrief().report;
    let states = [
        ("replay", state()),
        ("replay that differs", differing()),
        ("replay that is not open yet", State::default()),
        (
            "replay that differs and broke off",
            State {
                failure: Some("session a.session: ".repeat(20)),
                rebuilt: vec!["hand".into(), "tissue".into()],
                ..differing()
            },
        ),
        (
            "replay that broke off",
            State {
                failure: Some("session a.session: ".repeat(20)),
                ..state()
            },
        ),
    ];
    for (what, state) in states {
        for language in LANGUAGES {
            for size in SIZES {
                let found = texts(size, Vec::new(), |ui| {
                    show(ui, &report, &state, language);
                });
                check(what, size, &found);
                check_height(what, size, &found);
            }
        }
    }
}

/// Whether it is the same stands there in words, in both languages.
#[test]
fn a_difference_is_on_the_screen() {
    let report = long_debrief().report;
    let all = |state: &State, language| {
        let found = texts(SIZE, Vec::new(), |ui| {
            show(ui, &report, state, language);
        });
        found
            .into_iter()
            .map(|(text, ..)| text + "\n")
            .collect::<String>()
    };
    let same = all(&state(), Language::English);
    assert!(
        same.contains("the same so far: tick 19999 / 24999"),
        "{same}"
    );
    assert!(!same.contains("Differs"), "{same}");
    assert!(same.contains("computed at ×0.25"), "{same}");
    let complete = State {
        standing: Standing {
            compared: 25_000,
            is_complete: true,
            ..state().standing
        },
        ..state()
    };
    let whole = all(&complete, Language::German);
    assert!(whole.contains("bis zum Ende gleich"), "{whole}");
    // A torn one is the same as far as there is something of it.
    let torn = State {
        standing: Standing {
            complaint: Some("the last record is cut off".into()),
            ..complete.standing.clone()
        },
        ..complete
    };
    let torn = all(&torn, Language::English);
    assert!(
        torn.contains("as far as it can be read: the last record is cut off"),
        "{torn}"
    );
    assert!(!torn.contains("to the end"), "{torn}");
    for (language, words) in [
        (
            Language::English,
            "Differs at tick 1234. What is shown from there on is not what was recorded",
        ),
        (
            Language::German,
            "Weicht ab bei Tick 1234. Was von dort an zu sehen ist, wurde so nicht aufgezeichnet",
        ),
    ] {
        let differs = all(&differing(), language);
        assert!(differs.contains(words), "{differs}");
        assert!(differs.contains(": message \"tool"), "{differs}");
        assert!(
            !differs.contains("so far") && !differs.contains("bisher"),
            "{differs}"
        );
        // A failure does not hide it, and it is known what may be the reason.
        let both = State {
            failure: Some("the disk is gone".into()),
            rebuilt: vec!["hand".into(), "tissue".into()],
            ..differing()
        };
        let both = all(&both, language);
        assert!(both.contains(words), "{both}");
        assert!(both.contains(": the disk is gone"), "{both}");
        assert!(both.contains(": hand, tissue)"), "{both}");
    }
}

/// Before a tick is compared it is not the same, and after a failure nothing is waited for.
#[test]
fn nothing_is_claimed_and_nothing_is_waited_for_in_vain() {
    let report = long_debrief().report;
    let resumed = State {
        range: 310..400,
        shown: None,
        standing: Standing {
            compared: 310,
            ..Standing::default()
        },
        ..state()
    };
    let found = texts(SIZE, Vec::new(), |ui| {
        show(ui, &report, &resumed, Language::English);
    });
    let all: String = found.into_iter().map(|(text, ..)| text + "\n").collect();
    assert!(all.contains("No tick is compared yet"), "{all}");
    assert!(!all.contains("the same"), "{all}");

    let waits = |state: &State| waiting(state).map(|waiting| waiting.of(Language::English));
    assert!(waits(&State::default()).is_some_and(|text| text.contains("is read")));
    let empty = State {
        range: 0..0,
        ..state()
    };
    assert!(waits(&empty).is_some_and(|text| text.contains("no tick")));
    let failed = State {
        failure: Some("the disk is gone".into()),
        ..State::default()
    };
    assert_eq!(waits(&failed), None);
}

#[test]
fn buttons_and_events_of_a_replay_are_clicked() {
    let report = long_debrief().report;
    let state = state();
    let second = format!("10.0 s  {}", report.moments[1].text.en);
    for (button, wanted) in [
        ("Pause", Asked::PlayOrPause),
        ("×¼", Asked::Speed(0)),
        ("Back to the debrief (Esc)", Asked::Back),
        ("Deutsch", Asked::Language),
        (&second[..], Asked::GoTo(1250)),
    ] {
        let mut asked = Vec::new();
        click_on(button, |ui| {
            asked.extend(show(ui, &report, &state, Language::English));
        });
        assert_eq!(asked, [wanted], "{button}");
    }
}

/// All that the player does has a key of its own.
#[test]
fn keys_of_a_replay() {
    let keys = [
        Key::Space,
        Key::ArrowLeft,
        Key::ArrowRight,
        Key::ArrowUp,
        Key::ArrowDown,
        Key::Home,
        Key::End,
        Key::Num1,
        Key::Num5,
        Key::Escape,
    ];
    let asked: Vec<Asked> = keys.into_iter().filter_map(by_key).collect();
    let expected = [
        Asked::PlayOrPause,
        Asked::Step(-1),
        Asked::Step(1),
        Asked::EventBefore,
        Asked::EventAfter,
        Asked::Begin,
        Asked::End,
        Asked::Speed(0),
        Asked::Speed(4),
        Asked::Back,
    ];
    assert_eq!(asked, expected);
    for of_the_microscope in [Key::Plus, Key::Minus, Key::Num0, Key::I, Key::U, Key::F2] {
        assert_eq!(by_key(of_the_microscope), None);
    }
}

/// Its button, its key, and each event lead from a debrief to the replay.
#[test]
fn a_debrief_leads_to_the_replay() {
    let debrief = long_debrief();
    let mut next = None;
    let mut show = |ui: &mut Ui| {
        next = debrief::show(ui, &debrief, true, Language::English).or(next);
    };
    click_on("Replay (R)", &mut show);
    assert_eq!(next.take(), Some(Next::Replay(0)));
    let mut show = |ui: &mut Ui| {
        next = debrief::show(ui, &debrief, true, Language::English).or(next);
    };
    let second = format!("10.0 s  {}", debrief.report.moments[1].text.en);
    click_on(&second, &mut show);
    assert_eq!(next.take(), Some(Next::Replay(1250)));
    let mut show = |ui: &mut Ui| {
        next = debrief::show(ui, &debrief, true, Language::English).or(next);
    };
    let key = crate::shortcut::press(Key::R);
    texts(SIZE, vec![key], &mut show);
    assert_eq!(next.take(), Some(Next::Replay(0)));
}

/// References that are there, or not; a track that is read at once, never, or cannot be read.
struct Shelf {
    known: usize,
    track: fn() -> Result<Track, String>,
}

impl References for Shelf {
    fn references(&self, _: &Debrief) -> (Vec<Reference>, Option<String>) {
        let reference = |k: usize| Reference {
            title: LocalText::new(
                format!("{k} {}", "eigener bester Versuch ".repeat(5)),
                format!("{k} {}", "best own attempt ".repeat(5)),
            ),
            motion: Motion::Session("a.session".into()),
        };
        let lacks = (self.known > 2).then(|| "store.sqlite: locked ".repeat(20));
        ((0..self.known).map(reference).collect(), lacks)
    }

    fn track(&self, _: &Debrief, _: &Reference) -> Result<ReadTrack, String> {
        let track = self.track;
        Ok(Box::new(move |_| track()))
    }
}

/// Takes what is read, once it is.
fn wait_for(ghost: &mut Ghost) {
    let since = std::time::Instant::now();
    while !ghost.take() {
        assert!(since.elapsed().as_secs() < 20, "never read");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

#[test]
fn a_reference_is_read_shown_and_hidden() {
    let debrief = long_debrief();
    let shelf = Shelf {
        known: 2,
        track: || Ok(Track::default()),
    };
    let mut ghost = Ghost::default();
    assert!(ghost.track().is_none() && !ghost.is_on);
    ghost.toggle(&shelf, &debrief, || ());
    wait_for(&mut ghost);
    assert!(ghost.is_on && ghost.track().is_some());
    ghost.toggle(&shelf, &debrief, || ());
    assert!(!ghost.is_on && ghost.track().is_none());
    // Again it is not read again.
    ghost.toggle(&shelf, &debrief, || ());
    assert!(ghost.track().is_some() && !ghost.take());
}

#[test]
fn the_row_of_a_reference_has_room_for_its_texts() {
    let debrief = long_debrief();
    let fails: fn() -> Result<Track, String> = || Err("session a.session: torn ".repeat(20));
    let reads: fn() -> Result<Track, String> = || Ok(Track::default());
    for (known, track) in [(0, reads), (1, reads), (3, reads), (3, fails)] {
        let shelf = Shelf { known, track };
        let mut ghost = Ghost::default();
        ghost.toggle(&shelf, &debrief, || ());
        if known > 0 {
            wait_for(&mut ghost);
        }
        everywhere("a reference", |ui, language| {
            egui::Panel::top("reference").show(ui, |ui| {
                let of = (&shelf, &debrief);
                ghost.show(ui, of, 3.0, || (), language)
            });
            show(ui, &debrief.report, &state(), language);
        });
    }
}

fn film_row(ended: Option<Result<Filmed, String>>) -> FilmRow {
    let mut row = FilmRow::default();
    row.set_ended(ended);
    row
}

#[test]
fn the_row_of_a_film_has_room_for_its_texts() {
    let folder: std::path::PathBuf = format!("/home/somebody/{LONG}/a.film-1").into();
    let filmed = |video| {
        Some(Ok(Filmed {
            folder: folder.clone(),
            pictures: 12_345,
            video,
        }))
    };
    let report = long_debrief().report;
    for ended in [
        None,
        Some(Err("no space left on the device ".repeat(8))),
        filmed(Video::Made(folder.join("film.mp4"))),
        filmed(Video::NoProgram),
        filmed(Video::Failed("no encoder ".repeat(20))),
        filmed(Video::Stopped),
    ] {
        let mut row = film_row(ended);
        let mut all = |ui: &mut Ui, language| {
            egui::Panel::bottom("film").show(ui, |ui| {
                row.show(ui, (Some(1234), &(0..30_000), 0.008), language)
            });
            show(ui, &report, &state(), language);
        };
        everywhere("a film", &mut all);
        for size in SIZES {
            let found = texts(size, Vec::new(), |ui| all(ui, Language::German));
            check_height("a film", size, &found);
        }
    }
}

/// From the tick that is shown, to another one, and all of it again.
#[test]
fn the_section_of_a_film_is_chosen_by_mouse() {
    let mut row = film_row(None);
    let mut press = |text: &str, now: u64| {
        let mut wanted = None;
        click_on(text, |ui| {
            let of = (Some(now), &(0..1000), 0.008);
            wanted = row.show(ui, of, Language::English).or(wanted);
        });
        wanted
    };
    let whole = Some(film_row::Wanted::Begin([0, 999]));
    assert_eq!(press("Make it", 5), whole);
    assert_eq!(press("From here", 100), None);
    assert_eq!(press("Up to here", 250), None);
    let part = Some(film_row::Wanted::Begin([100, 250]));
    assert_eq!(press("Make it", 5), part);
    // What would end before it begins begins or ends where the whole does.
    assert_eq!(press("From here", 300), None);
    let rest = Some(film_row::Wanted::Begin([300, 999]));
    assert_eq!(press("Make it", 5), rest);
    assert_eq!(press("Up to here", 200), None);
    let beginning = Some(film_row::Wanted::Begin([0, 200]));
    assert_eq!(press("Make it", 5), beginning);
    assert_eq!(press("All of it", 5), None);
    assert_eq!(press("Make it", 5), whole);
}
