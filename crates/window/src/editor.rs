//! The level editor: the numbers of a level with what they mean, their units and ranges, and a copy of it with others.

use crate::copies::{Changes, LevelCopies};
use crate::look;
use crate::number_words::in_german;
use crate::rows::{cell, in_a_row};
use crate::shortcut;
use crate::station::Choice;
use crate::text::{self, Phrase, local};
use eframe::egui::{self, Align, Label, Layout, RichText, ScrollArea, TextEdit, Ui, WidgetText};
use microsim_message::LocalText;
use microsim_settings::{Form, LevelNumber, NumberGroup, WrongNumber};
use microsim_vocabulary::Language;

/// Width of the names of numbers \[points\].
const NAMES: f32 = 170.0;
/// Width of values \[points\].
const VALUES: f32 = 130.0;
/// Width of ranges \[points\].
const RANGES: f32 = 200.0;
/// Height of a number \[points\].
const LINE: f32 = 32.0;
/// Height of the row that stores a copy \[points\].
const STORE: f32 = 42.0;
/// Width of the name of a copy \[points\].
const COPY_NAME: f32 = 200.0;

/// A number with what the operator has typed.
#[derive(Debug)]
struct Row {
    number: LevelNumber,
    text: String,
}

impl Row {
    /// Why it cannot stand like this.
    fn wrong(&self) -> Option<WrongNumber> {
        self.number.read(&self.text).err()
    }

    /// Whether something else stands there than before. Its value may differ from that of the level in the last digits, which a text does not show.
    fn is_changed(&self) -> bool {
        self.text.trim() != self.number.text
    }
}

/// What stands below the numbers.
#[derive(Debug)]
enum Note {
    Stored(String),
    NotStored(String),
    /// Whoever leaves now loses what they changed.
    Discard,
}

/// A level whose copy is being made.
#[derive(Debug)]
pub struct Editor {
    choice: Choice,
    /// Of module and level.
    titles: (LocalText, LocalText),
    rows: Vec<Row>,
    name: String,
    /// What is wrong with the level as a whole.
    complaints: Vec<String>,
    note: Option<Note>,
    /// Whether something was changed since it was stored.
    is_open: bool,
}

/// What the operator asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The modules.
    Back,
    /// The other language.
    Language,
    /// There is a variant of this name now.
    Stored(String),
}

fn title_of(group: NumberGroup) -> Phrase {
    match group {
        NumberGroup::Tissue => text::OF_TISSUE,
        NumberGroup::Contact => text::OF_CONTACT,
        NumberGroup::Limit => text::OF_LIMITS,
        NumberGroup::Metrics => text::OF_METRICS,
        NumberGroup::Module => text::OF_MODULE,
    }
}

/// Why a text is no value, in a sentence.
fn sentence(number: &LevelNumber, why: &WrongNumber, language: Language) -> String {
    let units = || number.units().join(", ");
    match why {
        WrongNumber::NotANumber => text::NO_NUMBER.of(language).to_owned(),
        WrongNumber::DecimalComma => text::DECIMAL_COMMA.of(language).to_owned(),
        WrongNumber::NotWhole => text::NOT_WHOLE.of(language).to_owned(),
        WrongNumber::NoUnit => format!("{} {}", text::WITHOUT_UNIT.of(language), units()),
        WrongNumber::OtherUnit => format!("{} {}", text::WRONG_UNIT.of(language), units()),
        WrongNumber::OutOfRange => {
            let range = number.range_text();
            format!("{} {range}", text::OUT_OF_RANGE.of(language))
        }
    }
}

impl Editor {
    /// The numbers of a level, as they are.
    ///
    /// # Errors
    /// Why the level cannot be read.
    pub fn new(
        copies: &(impl LevelCopies + ?Sized),
        choice: Choice,
        titles: (LocalText, LocalText),
    ) -> Result<Self, String> {
        let numbers = copies.numbers(&choice)?.into_iter();
        let row = |number: LevelNumber| Row {
            text: number.text.clone(),
            number,
        };
        Ok(Self {
            choice,
            titles,
            rows: numbers.map(row).collect(),
            name: String::new(),
            complaints: Vec::new(),
            note: None,
            is_open: false,
        })
    }

    fn changes(&self) -> Changes {
        let changed = self.rows.iter().filter(|row| row.is_changed());
        let change = |row: &Row| (row.number.key.clone(), row.text.trim().to_owned());
        changed.map(change).collect()
    }

    fn is_wrong(&self) -> bool {
        self.rows.iter().any(|row| row.wrong().is_some())
    }

    /// Shows it.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        copies: &(impl LevelCopies + ?Sized),
        language: Language,
    ) -> Option<Wanted> {
        let mut wanted = None;
        let mut leaves = false;
        egui::Panel::top("edited")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    ui.heading(text::EDITOR.of(language));
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        leaves = shortcut::button(ui, text::BACK.of(language), shortcut::BACK);
                        if shortcut::button(ui, text::LANGUAGE.of(language), shortcut::LANGUAGE) {
                            wanted = Some(Wanted::Language);
                        }
                    });
                });
                let (module, level) = &self.titles;
                let title = format!(
                    "{} · {} {}: {}",
                    local(module, language),
                    text::LEVEL.of(language),
                    self.choice.level,
                    local(level, language)
                );
                ui.add(Label::new(title).truncate());
                ui.label(look::quiet(text::SHIPPED_STAYS.of(language)));
                ui.add_space(4.0);
            });
        egui::Panel::bottom("copy")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                let stored = self.show_store(ui, copies, language);
                wanted = stored.map(Wanted::Stored).or(wanted.take());
                ui.add_space(6.0);
            });
        let is_changed = egui::CentralPanel::default()
            .show(ui, |ui| self.show_numbers(ui, language))
            .inner;
        if is_changed {
            self.is_open = true;
            self.note = None;
            let is_level = !self.is_wrong();
            self.complaints = match is_level {
                true => copies.complaints(&self.choice, &self.changes()),
                false => Vec::new(),
            };
        }
        if leaves {
            match self.is_open && !matches!(self.note, Some(Note::Discard)) {
                true => self.note = Some(Note::Discard),
                false => wanted = Some(Wanted::Back),
            }
        }
        wanted
    }

    /// The name of the copy, and what is to be known of it; its name if it was stored.
    fn show_store(
        &mut self,
        ui: &mut Ui,
        copies: &(impl LevelCopies + ?Sized),
        language: Language,
    ) -> Option<String> {
        let mut stored = None;
        let is_name = Form::Identifier.accepts(&self.name);
        in_a_row(ui, STORE, |ui| {
            ui.label(text::COPY_NAME.of(language));
            let edit = TextEdit::singleline(&mut self.name).desired_width(COPY_NAME);
            ui.add(edit);
            let is_ready = is_name && !self.is_wrong() && self.complaints.is_empty();
            let store = look::main_button(text::STORE_COPY.of(language));
            if ui.add_enabled(is_ready, store).clicked() {
                let path = copies.store_copy(&self.choice, &self.name, &self.changes());
                self.note = Some(match path {
                    Ok(path) => {
                        self.is_open = false;
                        stored = Some(self.name.clone());
                        Note::Stored(path.display().to_string())
                    }
                    Err(why) => Note::NotStored(why),
                });
            }
        });
        let bad = |text: String| RichText::new(text).color(look::BAD);
        let words: WidgetText = match &self.note {
            Some(Note::Stored(path)) => {
                let stored = text::COPY_STORED.of(language);
                RichText::new(format!("{stored} {path}"))
                    .color(look::GOOD)
                    .into()
            }
            Some(Note::NotStored(why)) => {
                bad(format!("{} {why}", text::COPY_NOT_STORED.of(language))).into()
            }
            Some(Note::Discard) => bad(text::DISCARD.of(language).to_owned()).into(),
            None if self.is_wrong() => bad(text::MENDED_FIRST.of(language).to_owned()).into(),
            None if !self.complaints.is_empty() => {
                let all = self.complaints.join("; ");
                bad(format!("{} {all}", text::NOT_A_LEVEL.of(language))).into()
            }
            None if !self.name.is_empty() && !is_name => {
                bad(text::NAME_RULE.of(language).to_owned()).into()
            }
            None => look::quiet(text::NAME_RULE.of(language)).into(),
        };
        ui.add(Label::new(words).wrap());
        stored
    }

    /// The numbers; whether one of them was changed now.
    fn show_numbers(&mut self, ui: &mut Ui, language: Language) -> bool {
        let mut is_changed = false;
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let mut above: Option<(NumberGroup, LocalText)> = None;
            for row in &mut self.rows {
                let of = (row.number.group, row.number.subject.clone());
                if above.as_ref().is_none_or(|(group, _)| *group != of.0) {
                    ui.add_space(10.0);
                    ui.label(look::heading(title_of(of.0).of(language)));
                }
                if above.as_ref() != Some(&of) {
                    let subject = local(&of.1, language);
                    if !subject.is_empty() {
                        ui.add_space(4.0);
                        ui.strong(subject);
                    }
                    above = Some(of);
                }
                is_changed |= show_row(ui, row, language);
            }
        });
        is_changed
    }
}

/// A number; whether it was changed now.
fn show_row(ui: &mut Ui, row: &mut Row, language: Language) -> bool {
    let mut is_changed = false;
    let wrong = row.wrong();
    in_a_row(ui, LINE, |ui| {
        cell(ui, NAMES, Align::Min, row.number.name.replace('_', " "));
        let colour = match wrong {
            Some(_) => look::BAD,
            None => look::TEXT,
        };
        let edit = TextEdit::singleline(&mut row.text)
            .id_salt(row.number.key.to_string())
            .desired_width(VALUES)
            .text_color(colour);
        is_changed = ui.add(edit).changed();
        let range = match row.number.range_text() {
            none if none.is_empty() => text::ANY_VALUE.of(language).to_owned(),
            range => range,
        };
        cell(ui, RANGES, Align::Min, look::quiet(range));
        let units = row.number.units().join(", ");
        let was = match row.is_changed() {
            true => format!("{} {}", text::WAS.of(language), row.number.text),
            false => units,
        };
        ui.add(Label::new(look::quiet(was)).truncate());
    });
    if let Some(why) = &row.wrong() {
        let why = sentence(&row.number, why, language);
        ui.label(RichText::new(why).color(look::BAD));
    }
    let meaning = match language {
        Language::German => in_german(&row.number.name),
        Language::English => None,
    };
    let meaning = meaning.filter(|_| row.number.group != NumberGroup::Module);
    let meaning = meaning.unwrap_or(&row.number.doc);
    ui.add(Label::new(look::quiet(meaning)).wrap());
    is_changed
}
