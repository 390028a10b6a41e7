//! Trainees and results: each tab laid out, and used with the mouse.

use super::{check_height, everywhere, texts, words};
use crate::ledger::{
    Attempt, Change, ComparedRow, Comparison, CourseEntry, CourseLevel, CourseProgress, CourseStep,
    Debrief, Done, Job, Learning, Ledger, Participant, Percentile, Person, Role, Selection,
    StandingRow, StepState, Work,
};
use crate::records::Records;
use eframe::egui::{Event, Modifiers, PointerButton, Ui};
use microsim_report::Verdict;
use microsim_vocabulary::Language;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

pub(super) const SIZE: [f32; 2] = [1280.0, 720.0];
pub(super) const LONG: &str =
    "Ein sehr langer Name, der in keine Spalte passt, Freiherr von und zu";

/// A store in memory, and what was asked of it.
#[derive(Default)]
pub(super) struct Memory {
    pub(super) changes: RefCell<Vec<Change>>,
    pub(super) works: RefCell<Vec<Work>>,
    /// What the next work comes to.
    pub(super) next: RefCell<Option<Scripted>>,
    exports: RefCell<Vec<(Selection, PathBuf, bool)>>,
    compared: RefCell<Vec<[String; 2]>>,
    pub(super) is_broken: bool,
}

/// Work that comes to what a test has written.
pub(super) struct Scripted {
    pub(super) outcome: Result<Done, String>,
    /// It states that a quarter is done, and goes on until this is dropped.
    pub(super) until: Option<Receiver<()>>,
}

impl Job for Scripted {
    fn run(self: Box<Self>, progress: &mut dyn FnMut(Option<f64>, String)) -> Result<Done, String> {
        progress(
            Some(0.25),
            format!("/home/somebody/sessions/{LONG}.session"),
        );
        if let Some(until) = &self.until {
            let _ = until.recv();
        }
        self.outcome
    }
}

fn attempt(number: usize, verdict: Verdict) -> Attempt {
    Attempt {
        id: format!("session-{number}"),
        started: "2026-11-26 08:15".into(),
        module: "module-1".into(),
        title: words(5),
        level: 2,
        verdict,
        score: Some(66.0),
        duration: 1234.5,
        who: LONG.into(),
    }
}

impl Ledger for Memory {
    fn people(&self) -> Result<Vec<Person>, String> {
        if self.is_broken {
            return Err("store.sqlite: locked by another process".into());
        }
        let person = |name: &str, groups: &[&str]| Person {
            id: format!("id-of-{name}"),
            name: name.into(),
            role: Role::Trainee,
            groups: groups.iter().map(|group| (*group).into()).collect(),
            sessions: 12,
        };
        Ok(vec![
            person("A. Muster", &["2026"]),
            person("B. Beispiel", &["2026", LONG]),
            person(LONG, &[]),
        ])
    }

    fn courses(&self) -> Result<Vec<CourseEntry>, String> {
        if self.is_broken {
            return Err("store.sqlite: locked by another process".into());
        }
        let level = |level| CourseLevel {
            title: words(5),
            level,
            passes: level,
        };
        let course = |name: &str, title, groups: &[&str], trainees: &[&str]| CourseEntry {
            name: name.into(),
            title,
            in_order: true,
            levels: (1..=12).map(level).collect(),
            groups: groups.iter().map(|group| (*group).into()).collect(),
            trainees: trainees.iter().map(|id| (*id).into()).collect(),
        };
        Ok(vec![
            course("first", words(3), &[LONG], &["id-of-A. Muster"]),
            course("second", words(9), &[], &[]),
        ])
    }

    fn groups(&self) -> Result<Vec<String>, String> {
        Ok(vec!["2026".into(), LONG.into()])
    }

    fn attempts(&self, of: &Selection) -> Result<Vec<Attempt>, String> {
        let verdicts = [Verdict::Failed, Verdict::Passed, Verdict::Aborted];
        let all = (0..12).rev().map(|k| attempt(k, verdicts[k % 3]));
        Ok(all
            .filter(|_| of.trainee.as_deref() != Some(LONG))
            .collect())
    }

    fn compare(&self, ids: [&str; 2]) -> Result<Comparison, String> {
        self.compared.borrow_mut().push(ids.map(str::to_owned));
        let row = |k: usize| ComparedRow {
            title: words(k + 1),
            unit: "mm/s".into(),
            values: [Some(-1234.5), (k != 2).then_some(0.25)],
            outside: [k == 1, false],
            is_better: [None, Some(true), Some(false)][k % 3],
        };
        Ok(Comparison {
            attempts: [attempt(1, Verdict::Failed), attempt(2, Verdict::Passed)],
            same_level: false,
            rows: (0..18).map(row).collect(),
        })
    }

    fn learning(&self, _: &str, _: &str, _: u32) -> Result<Learning, String> {
        let standing = |percentile| StandingRow {
            title: words(7),
            unit: "mm".into(),
            value: 123.4,
            source: LONG.into(),
            size: 120,
            percentile,
        };
        Ok(Learning {
            values: vec![-0.09, -0.18, 0.73, 0.64],
            limits: [-1.9, 1.9],
            rates: [0.05, 0.15],
            decision: Some((3, false)),
            standings: [
                Percentile::At(20.0),
                Percentile::Below(5.0),
                Percentile::Above(95.0),
            ]
            .map(standing)
            .into(),
        })
    }

    fn progress(&self, _: &str) -> Result<Vec<CourseProgress>, String> {
        let step = |state, is_next| CourseStep {
            module: "module-1".into(),
            title: words(4),
            level: 3,
            state,
            is_next,
            row: [1, 3],
            attempts: [4, 12],
        };
        Ok(vec![CourseProgress {
            name: "first".into(),
            title: words(4),
            steps: vec![
                step(StepState::Mastered(12), false),
                step(StepState::Open, true),
                step(StepState::Locked, false),
            ],
        }])
    }

    fn debrief(&self, _: &str) -> Result<Debrief, String> {
        Err("its session is gone".into())
    }

    fn table(&self) -> PathBuf {
        PathBuf::from("/home/somebody/tables/results-2026-11-26.csv")
    }

    fn export(&self, of: &Selection, file: &Path, names: bool) -> Result<usize, String> {
        let export = (of.clone(), file.to_owned(), names);
        self.exports.borrow_mut().push(export);
        Ok(24)
    }

    fn belongings(&self, _: &str) -> Result<[usize; 2], String> {
        Ok([12, 60])
    }

    fn change(&self, change: &Change) -> Result<(), String> {
        self.changes.borrow_mut().push(change.clone());
        Ok(())
    }

    fn export_file(&self) -> PathBuf {
        PathBuf::from("/home/somebody/tables/store-2026-11-26-08-15.json")
    }

    fn job(&self, work: &Work) -> Box<dyn Job> {
        self.works.borrow_mut().push(work.clone());
        Box::new(
            self.next
                .take()
                .expect("a test that has said what it comes to"),
        )
    }
}

/// Clicks the first of the texts that is this one.
#[track_caller]
fn click(records: &mut Records, memory: &Memory, text: &str) {
    click_on(text, |ui| {
        records.show(ui, memory, Language::English);
    });
}

/// The same on any screen.
#[track_caller]
pub(super) fn click_on(text: &str, show: impl FnMut(&mut Ui)) {
    click_in(SIZE, text, show);
}

/// The same in a window of any size. A button may have its key behind its text.
#[track_caller]
pub(super) fn click_in(size: [f32; 2], text: &str, mut show: impl FnMut(&mut Ui)) {
    let mut show = |events| texts(size, events, &mut show);
    let found = show(Vec::new());
    let with_key = format!("{text} (");
    let is_wanted = |found: &str| found == text || found.starts_with(&with_key);
    let place = found.iter().find(|(found, ..)| is_wanted(found));
    let place = place
        .unwrap_or_else(|| panic!("no {text:?} in {found:?}"))
        .1;
    let button = |pressed| Event::PointerButton {
        pos: place.center(),
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    show(vec![
        Event::PointerMoved(place.center()),
        button(true),
        button(false),
    ]);
}

fn shown(records: &mut Records, memory: &Memory) -> String {
    let all = texts(SIZE, Vec::new(), |ui| {
        records.show(ui, memory, Language::English);
    });
    all.into_iter().map(|(text, ..)| text + "\n").collect()
}

/// Behind the button that opens this screen: a name, two attempts of it side by side, the table of its group.
#[test]
fn three_clicks_find_compare_and_export() {
    let memory = Memory::default();
    let mut records = Records::new(&memory, None);
    click(&mut records, &memory, "A. Muster");
    click(&mut records, &memory, "Compare A and B");
    // The last two attempts, the earlier one first.
    let ids = ["session-10", "session-11"].map(str::to_owned);
    assert_eq!(*memory.compared.borrow(), [ids]);
    assert!(shown(&mut records, &memory).contains("Not the same level"));
    click(&mut records, &memory, "Export the group");
    let group = Selection {
        trainee: None,
        group: Some("2026".into()),
    };
    assert_eq!(*memory.exports.borrow(), [(group, memory.table(), true)]);
    assert!(shown(&mut records, &memory).contains("24 sessions are in /home"));
}

#[test]
fn nothing_is_removed_without_a_second_click() {
    let memory = Memory::default();
    let mut records = Records::new(&memory, Some("id-of-A. Muster"));
    click(&mut records, &memory, "Details");
    let id = || "id-of-A. Muster".to_owned();
    for (button, change) in [
        ("Erase …", Change::Erase { id: id() }),
        ("Anonymise …", Change::Anonymise { id: id() }),
    ] {
        click(&mut records, &memory, button);
        assert!(memory.changes.borrow().is_empty(), "{button}");
        click(&mut records, &memory, "Cancel");
        assert!(memory.changes.borrow().is_empty(), "{button}");
        click(&mut records, &memory, button);
        click(&mut records, &memory, "Remove for good");
        assert_eq!(memory.changes.take(), [change], "{button}");
    }
}

#[test]
fn roles_courses_and_levels_are_changed() {
    let memory = Memory::default();
    let mut records = Records::new(&memory, Some("id-of-A. Muster"));
    let id = || "id-of-A. Muster".to_owned();
    click(&mut records, &memory, "Details");
    click(&mut records, &memory, "instructor");
    click(&mut records, &memory, "Take out");
    click(&mut records, &memory, "Courses");
    click(&mut records, &memory, "Enrol");
    click(&mut records, &memory, "Unlock");
    click(&mut records, &memory, "Take out");
    let role = Role::Instructor;
    let (group, member) = ("2026".to_owned(), false);
    let (module, level) = ("module-1".to_owned(), 3);
    let expected = [
        Change::Role { id: id(), role },
        Change::Group {
            id: id(),
            group,
            member,
        },
        // The one that is not taken yet.
        Change::Enrol {
            who: Participant::Trainee(id()),
            course: "second".into(),
            takes: true,
        },
        Change::Unlock {
            id: id(),
            course: "first".into(),
            module,
            level,
        },
        Change::Enrol {
            who: Participant::Trainee(id()),
            course: "first".into(),
            takes: false,
        },
    ];
    assert_eq!(*memory.changes.borrow(), expected);
}

#[test]
fn a_store_that_cannot_be_read_is_named() {
    let memory = Memory {
        is_broken: true,
        ..Memory::default()
    };
    let mut records = Records::new(&memory, None);
    let text = shown(&mut records, &memory);
    assert!(text.contains("locked by another process"), "{text}");
}

#[test]
fn trainees_and_results_have_room_for_their_texts() {
    let memory = Memory::default();
    for tab in [
        "",
        "Learning curve",
        "Courses",
        "Details",
        "Compare A and B",
    ] {
        let mut records = Records::new(&memory, Some("id-of-B. Beispiel"));
        if !tab.is_empty() {
            click(&mut records, &memory, tab);
        }
        if tab == "Details" {
            click(&mut records, &memory, "Erase …");
        }
        everywhere(tab, |ui, language| {
            records.show(ui, &memory, language);
        });
        for size in super::SIZES {
            let found = texts(size, Vec::new(), |ui| {
                records.show(ui, &memory, Language::German);
            });
            check_height(tab, size, &found);
        }
    }
    let mut everybody = Records::new(&memory, None);
    everywhere("everybody", |ui, language| {
        everybody.show(ui, &memory, language);
    });
}
