//! The level editor, laid out, and used with mouse and keyboard.

use super::records::{LONG, SIZE};
use super::{LANGUAGES, SIZES, check_height, collect, everywhere, texts, words};
use crate::copies::{Changes, LevelCopies};
use crate::editor::{Editor, Wanted};
use crate::look;
use crate::station::Choice;
use eframe::egui::{
    self, Event, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, Ui, pos2, vec2,
};
use microsim_settings::{KeyPath, LevelNumber, NumberGroup, Unit};
use microsim_vocabulary::Language;
use std::cell::RefCell;
use std::path::PathBuf;

/// Copies in memory.
#[derive(Default)]
struct Memory {
    stored: RefCell<Vec<(String, Changes)>>,
    /// What is wrong with every level that is changed.
    complaint: Option<String>,
    is_full: bool,
}

fn number(group: NumberGroup, name: &str, unit: Unit, range: [f64; 2], text: &str) -> LevelNumber {
    LevelNumber {
        key: KeyPath::root().key("body").at(0).key(name),
        group,
        subject: words(3),
        name: name.into(),
        doc: "What it means in a sentence. ".repeat(8),
        unit,
        range,
        is_whole: false,
        value: unit.parse(text).expect("a quantity"),
        text: text.into(),
    }
}

impl LevelCopies for Memory {
    fn numbers(&self, _: &Choice) -> Result<Vec<LevelNumber>, String> {
        use NumberGroup::{Contact, Limit, Metrics, Module, Tissue};
        let any = [f64::NEG_INFINITY, f64::INFINITY];
        Ok(vec![
            number(
                Tissue,
                "youngs_modulus",
                Unit::Pressure,
                [1.0, 1e11],
                "80 kPa",
            ),
            number(
                Tissue,
                "fibre_dispersion",
                Unit::Ratio,
                [0.0, 1.0 / 3.0],
                "0.2",
            ),
            number(
                Tissue,
                "volume_modulus",
                Unit::Pressure,
                [0.0, 1e11],
                "1 MPa",
            ),
            number(Contact, "force_limit", Unit::Force, [0.0, 1e3], "30 mN"),
            number(Limit, "max", Unit::Time, any, "60 s"),
            number(Limit, "full", Unit::Angle, any, "12 deg"),
            number(
                Metrics,
                "movement_speed",
                Unit::Speed,
                [1e-6, 1.0],
                "1 mm/s",
            ),
            number(Module, "handover", Unit::Time, [0.0, 10.0], "2 s"),
        ])
    }

    fn complaints(&self, _: &Choice, _: &Changes) -> Vec<String> {
        self.complaint.iter().cloned().collect()
    }

    fn store_copy(&self, _: &Choice, name: &str, changes: &Changes) -> Result<PathBuf, String> {
        if self.is_full {
            return Err(format!("/home/{LONG} cannot be written: no space left"));
        }
        let stored = (name.to_owned(), changes.clone());
        self.stored.borrow_mut().push(stored);
        Ok(PathBuf::from(format!("/home/{LONG}/level2.{name}.toml")))
    }
}

fn editor(memory: &Memory) -> Editor {
    let choice = Choice {
        module: "module-1".into(),
        level: 2,
        variant: None,
        trainee: None,
        hand: Default::default(),
    };
    Editor::new(memory, choice, (words(4), words(6))).expect("numbers")
}

/// A window that stays open from one picture to the next.
struct Shown<'a> {
    context: egui::Context,
    memory: &'a Memory,
    editor: Editor,
    wanted: Vec<Wanted>,
}

impl<'a> Shown<'a> {
    fn new(memory: &'a Memory) -> Self {
        let context = egui::Context::default();
        look::apply(&context);
        let mut shown = Self {
            context,
            memory,
            editor: editor(memory),
            wanted: Vec::new(),
        };
        shown.picture(Vec::new());
        shown.picture(Vec::new());
        shown
    }

    /// The texts of the next picture, and where they stand.
    fn picture(&mut self, events: Vec<Event>) -> Vec<(String, Rect)> {
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(SIZE[0], SIZE[1]))),
            events,
            ..RawInput::default()
        };
        let (editor, memory) = (&mut self.editor, self.memory);
        let mut wanted = None;
        let mut output = self.context.run_ui(input, |ui: &mut Ui| {
            wanted = editor.show(ui, memory, Language::English);
        });
        self.wanted.extend(wanted);
        output.textures_delta.clear();
        let mut found = Vec::new();
        for clipped in &output.shapes {
            collect(&clipped.shape, clipped.clip_rect, &mut found);
        }
        let found = found.into_iter();
        found.map(|(text, place, _)| (text, place)).collect()
    }

    fn has(&mut self, text: &str) -> bool {
        let found = self.picture(Vec::new());
        found.iter().any(|(found, _)| found.contains(text))
    }

    fn click(&mut self, at: Pos2) {
        let button = |pressed| Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.picture(vec![Event::PointerMoved(at), button(true)]);
        self.picture(vec![button(false)]);
    }

    #[track_caller]
    fn click_on(&mut self, text: &str) {
        let found = self.picture(Vec::new());
        let place = found.iter().find(|(found, _)| found == text);
        self.click(place.unwrap_or_else(|| panic!("no {text:?}")).1.center());
    }

    fn press(&mut self, key: Key, modifiers: Modifiers) {
        let event = |pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        };
        self.picture(vec![event(true), event(false)]);
    }

    /// Replaces a value.
    #[track_caller]
    fn write(&mut self, old: &str, new: &str) {
        self.click_on(old);
        self.press(Key::A, Modifiers::COMMAND);
        self.picture(vec![Event::Text(new.into())]);
        self.picture(Vec::new());
    }

    /// Gives the copy a name.
    fn write_name(&mut self, name: &str) {
        let found = self.picture(Vec::new());
        let label = found.iter().find(|(text, _)| text == "Name of the copy");
        let label = label.expect("its label").1;
        self.click(pos2(label.right() + 40.0, label.center().y));
        self.picture(vec![Event::Text(name.into())]);
        self.picture(Vec::new());
    }
}

#[test]
fn the_editor_has_room_for_its_texts() {
    let memory = Memory::default();
    let mut editor = editor(&memory);
    everywhere("the editor", |ui, language| {
        editor.show(ui, &memory, language);
    });
    for language in LANGUAGES {
        for size in SIZES {
            let found = texts(size, Vec::new(), |ui| {
                editor.show(ui, &memory, language);
            });
            check_height("the editor", size, &found);
        }
    }
}

#[test]
fn a_number_out_of_its_range_is_marked_at_once_and_not_stored() {
    let memory = Memory::default();
    let mut shown = Shown::new(&memory);
    shown.write_name("hard");
    shown.write("80 kPa", "0.5 Pa");
    assert!(shown.has("Outside the range 1 Pa … 100 GPa") && shown.has("before 80 kPa"));
    shown.click_on("Store the copy");
    assert!(memory.stored.borrow().is_empty() && shown.wanted.is_empty());
    for (old, new, why) in [
        ("0.5 Pa", "90", "The unit is missing: Pa, GPa, MPa, kPa"),
        ("90", "90 mm", "Another unit than Pa"),
        ("90 mm", "0,9 MPa", "The decimal sign is a point."),
        ("0,9 MPa", "stiff", "That is no number."),
    ] {
        shown.write(old, new);
        assert!(shown.has(why), "{why}");
    }
    shown.write("stiff", "0.2 MPa");
    assert!(!shown.has("First mend"));
    shown.click_on("Store the copy");
    let key = KeyPath::root().key("body").at(0).key("youngs_modulus");
    let expected = ("hard".to_owned(), vec![(key, "0.2 MPa".to_owned())]);
    assert_eq!(*memory.stored.borrow(), [expected]);
    assert_eq!(shown.wanted, [Wanted::Stored("hard".into())]);
    assert!(shown.has("level2.hard.toml"));
}

/// Neither a level that the reader refuses nor a full disk loses what was typed.
#[test]
fn what_could_not_be_stored_is_still_there() {
    let refusing = Memory {
        complaint: Some("`full` below `zero`".into()),
        ..Memory::default()
    };
    let mut shown = Shown::new(&refusing);
    shown.write_name("hard");
    shown.write("60 s", "50 s");
    assert!(shown.has("Like this it is no level: `full` below `zero`"));
    shown.click_on("Store the copy");
    assert!(refusing.stored.borrow().is_empty());

    let full = Memory {
        is_full: true,
        ..Memory::default()
    };
    let mut shown = Shown::new(&full);
    shown.write_name("hard");
    shown.write("60 s", "50 s");
    shown.click_on("Store the copy");
    assert!(shown.has("no space left") && shown.has("50 s"));
    shown.press(Key::Escape, Modifiers::NONE);
    assert!(shown.wanted.is_empty() && shown.has("once more discards"));
    shown.press(Key::Escape, Modifiers::NONE);
    assert_eq!(shown.wanted, [Wanted::Back]);
}

#[test]
fn a_level_as_it_is_is_left_at_once() {
    let memory = Memory::default();
    let mut shown = Shown::new(&memory);
    shown.press(Key::Escape, Modifiers::NONE);
    assert_eq!(shown.wanted, [Wanted::Back]);
}
