//! Courses and the store as a whole: laid out, and used with mouse, keyboard and dropped files.

use super::records::{LONG, Memory, SIZE, Scripted, click_on};
use super::{LANGUAGES, SIZES, check, check_height, texts};
use crate::ledger::{Change, Done, Participant, Work};
use crate::look;
use crate::upkeep::Upkeep;
use eframe::egui::{self, DroppedFile, Pos2, RawInput, Rect, Ui, vec2};
use microsim_message::LocalText;
use microsim_vocabulary::Language;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc;
use std::time::{Duration, Instant};

fn opened(memory: &Memory) -> Upkeep {
    let mut upkeep = Upkeep::default();
    upkeep.read(memory);
    upkeep
}

fn shown(upkeep: &mut Upkeep, memory: &Memory, language: Language) -> String {
    let all = texts(SIZE, Vec::new(), |ui| {
        upkeep.show(ui, memory, language);
    });
    all.into_iter().map(|(text, ..)| text + "\n").collect()
}

#[track_caller]
fn click(upkeep: &mut Upkeep, memory: &Memory, text: &str) {
    click_on(text, |ui| {
        upkeep.show(ui, memory, Language::English);
    });
}

/// Shows the screen until a text is on it.
#[track_caller]
fn wait_for(upkeep: &mut Upkeep, memory: &Memory, text: &str) -> String {
    let start = Instant::now();
    loop {
        let found = shown(upkeep, memory, Language::English);
        if found.contains(text) {
            return found;
        }
        assert!(start.elapsed() < Duration::from_secs(20), "{found}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[derive(Debug)]
struct Dropped(&'static str);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        Path::new(self.0)
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the window reads no file".into())
    }
}

/// Drops files onto the window.
fn drop_files(upkeep: &mut Upkeep, memory: &Memory, files: &[&'static str]) {
    let context = egui::Context::default();
    look::apply(&context);
    let dropped = files.iter().map(|path| Arc::new(Dropped(path)) as _);
    let input = RawInput {
        screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(SIZE[0], SIZE[1]))),
        dropped_files: dropped.collect(),
        ..RawInput::default()
    };
    let show = |ui: &mut Ui| {
        upkeep.show(ui, memory, Language::English);
    };
    context.run_ui(input, show).textures_delta.clear();
}

fn is_done(sentence: &str) -> Scripted {
    Scripted {
        outcome: Ok(Done {
            is_good: true,
            sentences: vec![LocalText::new("auf Deutsch", sentence.to_owned())],
        }),
        until: None,
    }
}

#[test]
fn a_dropped_file_is_read_with_one_click() {
    let memory = Memory::default();
    let mut upkeep = opened(&memory);
    for file in ["/a/course.toml", "/a/experts.csv", "/a/store.json"] {
        drop_files(&mut upkeep, &memory, &[file]);
        assert!(memory.works.borrow().is_empty(), "nothing before the click");
        *memory.next.borrow_mut() = Some(is_done("it is in the store"));
        click(&mut upkeep, &memory, "Read in");
        assert_eq!(memory.works.take(), [Work::Read(PathBuf::from(file))]);
        wait_for(&mut upkeep, &memory, "it is in the store");
        assert!(shown(&mut upkeep, &memory, Language::German).contains("auf Deutsch"));
    }
    // A folder is one of sessions; of several files the first is taken, and that is said.
    drop_files(&mut upkeep, &memory, &["/a/sessions", "/b.toml"]);
    let found = shown(&mut upkeep, &memory, Language::English);
    assert!(found.contains("One file at a time"), "{found}");
    *memory.next.borrow_mut() = Some(is_done("all are read"));
    click(&mut upkeep, &memory, "Rebuild");
    let folder = Some(PathBuf::from("/a/sessions"));
    assert_eq!(memory.works.take(), [Work::Rebuild(folder)]);
    wait_for(&mut upkeep, &memory, "all are read");
}

#[test]
fn the_store_is_exported_checked_and_rebuilt() {
    let memory = Memory::default();
    let mut upkeep = opened(&memory);
    let export = PathBuf::from("/home/somebody/tables/store-2026-11-26-08-15.json");
    for (button, work) in [
        ("Export all", Work::Export(export)),
        ("Check", Work::Check),
        ("Rebuild", Work::Rebuild(None)),
    ] {
        *memory.next.borrow_mut() = Some(is_done(button));
        click(&mut upkeep, &memory, button);
        assert_eq!(memory.works.take(), [work]);
        wait_for(&mut upkeep, &memory, &format!("{button}\n"));
    }
    // Nothing is typed or dropped, so there is nothing to read.
    click(&mut upkeep, &memory, "Read in");
    assert!(memory.works.borrow().is_empty());
}

/// File, line and what was expected, as the commands state them, under a heading in the language of the screen.
#[test]
fn what_is_wrong_with_a_file_is_shown_in_full() {
    let memory = Memory::default();
    let mut upkeep = opened(&memory);
    let why = "/a/experts.csv:3: column `level`: found \"one\", expected a whole number";
    drop_files(&mut upkeep, &memory, &["/a/experts.csv"]);
    *memory.next.borrow_mut() = Some(Scripted {
        outcome: Err(why.into()),
        until: None,
    });
    click(&mut upkeep, &memory, "Read in");
    let found = wait_for(&mut upkeep, &memory, "Not done:");
    assert!(found.contains(why), "{found}");
    let found = shown(&mut upkeep, &memory, Language::German);
    assert!(
        found.contains("Nicht ausgeführt:") && found.contains(why),
        "{found}"
    );
    // The path is still there, to be tried again.
    assert!(found.contains("/a/experts.csv\n"), "{found}");
}

/// While work goes on, how far it is stands there and no other work begins; the courses can be used.
#[test]
fn work_goes_on_beside_the_screen() {
    let memory = Memory::default();
    let mut upkeep = opened(&memory);
    let (ends, until) = mpsc::channel();
    *memory.next.borrow_mut() = Some(Scripted {
        until: Some(until),
        ..is_done("12 sessions are entered")
    });
    click(&mut upkeep, &memory, "Rebuild");
    wait_for(&mut upkeep, &memory, "25 %");
    click(&mut upkeep, &memory, "Check");
    assert_eq!(memory.works.take(), [Work::Rebuild(None)]);
    let first = crate::text::local(&super::words(3), Language::English).to_owned();
    click(&mut upkeep, &memory, &first);
    assert!(shown(&mut upkeep, &memory, Language::English).contains("Groups that take it"));
    everywhere("work", &memory, &mut upkeep);
    drop(ends);
    wait_for(&mut upkeep, &memory, "12 sessions are entered");
}

#[test]
fn groups_take_courses_and_courses_are_removed() {
    let memory = Memory::default();
    let mut upkeep = opened(&memory);
    let title = |n| crate::text::local(&super::words(n), Language::English).to_owned();
    click(&mut upkeep, &memory, &title(3));
    let enrol = |group: &str, takes| Change::Enrol {
        who: Participant::Group(group.into()),
        course: "first".into(),
        takes,
    };
    // The group that does not take it yet.
    click(&mut upkeep, &memory, "Enrol group");
    assert_eq!(memory.changes.take(), [enrol("2026", true)]);
    click(&mut upkeep, &memory, "Take out");
    assert_eq!(memory.changes.take(), [enrol(LONG, false)]);
    // It goes with the second click alone.
    let size = [SIZE[0], 1600.0];
    let mut find = |text: &str| click_at(size, text, &mut upkeep, &memory);
    find("Remove course …");
    assert!(memory.changes.borrow().is_empty());
    find("Cancel");
    find("Remove course …");
    find("Remove for good");
    let course = "first".to_owned();
    assert_eq!(memory.changes.take(), [Change::RemoveCourse { course }]);
}

/// Clicks a text of a window of another size, where nothing has to be scrolled.
#[track_caller]
fn click_at(size: [f32; 2], text: &str, upkeep: &mut Upkeep, memory: &Memory) {
    super::records::click_in(size, text, |ui| {
        upkeep.show(ui, memory, Language::English);
    });
}

fn everywhere(what: &str, memory: &Memory, upkeep: &mut Upkeep) {
    for language in LANGUAGES {
        for size in SIZES {
            let found = texts(size, Vec::new(), |ui| {
                upkeep.show(ui, memory, language);
            });
            check(what, size, &found);
            check_height(what, size, &found);
        }
    }
}

#[test]
fn courses_and_data_have_room_for_their_texts() {
    let memory = Memory::default();
    let mut upkeep = opened(&memory);
    everywhere("nothing chosen", &memory, &mut upkeep);
    let title = crate::text::local(&super::words(9), Language::English).to_owned();
    let is_title = |text: &str| title.starts_with(text.trim_end_matches('…')) && text.len() > 20;
    let found = texts(SIZE, Vec::new(), |ui| {
        upkeep.show(ui, &memory, Language::English);
    });
    let cut = found.iter().find(|(text, ..)| is_title(text));
    let cut = cut.unwrap_or_else(|| panic!("no {title:?} in {found:?}"));
    click(&mut upkeep, &memory, &cut.0);
    everywhere("a course", &memory, &mut upkeep);
    // A long complaint scrolls.
    drop_files(&mut upkeep, &memory, &["/a/experts.csv"]);
    *memory.next.borrow_mut() = Some(Scripted {
        outcome: Err([LONG; 30].join("; ")),
        until: None,
    });
    click(&mut upkeep, &memory, "Read in");
    wait_for(&mut upkeep, &memory, "Not done:");
    everywhere("a complaint", &memory, &mut upkeep);
    let mut broken = Memory::default();
    broken.is_broken = true;
    let mut upkeep = opened(&broken);
    let found = shown(&mut upkeep, &broken, Language::English);
    assert!(found.contains("locked by another process"), "{found}");
    everywhere("a broken store", &broken, &mut upkeep);
}
