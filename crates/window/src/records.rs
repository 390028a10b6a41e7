//! Trainees and results: who there is, and what is shown of whom.

use crate::attempts::{self, Attempts};
use crate::courses::{self, Courses};
use crate::learning::{self, Chosen};
use crate::ledger::{Change, Debrief, Ledger, Person, Selection};
use crate::look;
use crate::person::{self, Details};
use crate::rows::{TWO_LINES, row};
use crate::shortcut;
use crate::text::{self, Phrase};
use eframe::egui::{self, Align, Key, Label, Layout, RichText, ScrollArea, TextEdit, Ui};
use microsim_vocabulary::Language;

/// What is shown of somebody.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Tab {
    #[default]
    Results,
    Learning,
    Courses,
    Details,
}

const TABS: [(Tab, Phrase); 4] = [
    (Tab::Results, text::RESULTS),
    (Tab::Learning, text::LEARNING),
    (Tab::Courses, text::COURSES),
    (Tab::Details, text::DETAILS),
];

/// What the operator asked for.
#[derive(Debug)]
pub enum Wanted {
    /// The modules.
    Back,
    /// The other language.
    Language,
    /// Courses and store.
    Upkeep,
    /// What came of a session.
    Debrief(Box<Debrief>),
    /// The session as it was recorded.
    Replay(Box<Debrief>),
}

/// What the screen shows, and what is entered on it.
#[derive(Debug, Default)]
pub struct Records {
    people: Vec<Person>,
    /// The group whose members are listed.
    group: Option<String>,
    /// What their names contain.
    search: String,
    /// Name of somebody new.
    name: String,
    chosen: Option<Person>,
    tab: Tab,
    attempts: Attempts,
    learning: Chosen,
    courses: Courses,
    details: Details,
    /// What came of what was asked for last: a sentence, and whether it is a complaint.
    message: Option<(String, bool)>,
}

impl Records {
    /// With somebody chosen, by id.
    pub fn new(ledger: &dyn Ledger, trainee: Option<&str>) -> Self {
        let mut records = Self::default();
        records.read(ledger);
        records.choose(ledger, trainee);
        records
    }

    /// Reads again who there is.
    fn read(&mut self, ledger: &dyn Ledger) {
        self.people = self.or_complain(ledger.people());
        let known = |group: &String| self.people.iter().any(|p| p.groups.contains(group));
        self.group = self.group.take().filter(known);
    }

    /// Shows somebody, or everybody.
    fn choose(&mut self, ledger: &dyn Ledger, trainee: Option<&str>) {
        let found = self.people.iter().find(|p| Some(&p.id[..]) == trainee);
        self.chosen = found.cloned();
        if self.chosen.is_none() {
            self.tab = Tab::Results;
        }
        let attempts = ledger.attempts(&self.selection());
        let attempts = self.or_complain(attempts);
        self.attempts.take(attempts, self.chosen.is_some());
        self.details = Details::of(self.chosen.as_ref());
        self.learning = Chosen::default();
        self.courses = Courses::default();
        if let Some(id) = trainee {
            let last = self.attempts.levels().next();
            let learning = last.map(|(module, level)| ledger.learning(id, &module, level));
            let learning = learning.map(|learning| self.or_complain_one(learning));
            self.learning = Chosen::new(self.attempts.levels(), learning.flatten());
            let progress = self.or_complain(ledger.progress(id));
            let all = self.or_complain(ledger.courses());
            self.courses = Courses::new(progress, all, id);
        }
    }

    fn or_complain<T: Default>(&mut self, read: Result<T, String>) -> T {
        read.unwrap_or_else(|why| {
            self.message = Some((why, true));
            T::default()
        })
    }

    fn or_complain_one<T>(&mut self, read: Result<T, String>) -> Option<T> {
        self.or_complain(read.map(Some))
    }

    /// Of whom results are listed.
    fn selection(&self) -> Selection {
        Selection {
            trainee: self.chosen.as_ref().map(|person| person.id.clone()),
            group: self.group.clone(),
        }
    }

    /// The group that an export of a group is of: the one that is listed, or the one of whoever is chosen.
    fn group_to_export(&self) -> Option<String> {
        let own = self.chosen.as_ref().and_then(|p| p.groups.first());
        self.group.as_ref().or(own).cloned()
    }

    /// Shows it.
    pub fn show(&mut self, ui: &mut Ui, ledger: &dyn Ledger, language: Language) -> Option<Wanted> {
        let mut wanted = None;
        egui::Panel::top("records")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    ui.heading(text::RECORDS.of(language));
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        if shortcut::button(ui, text::BACK.of(language), shortcut::BACK) {
                            wanted = Some(Wanted::Back);
                        }
                        if shortcut::button(ui, text::LANGUAGE.of(language), shortcut::LANGUAGE) {
                            wanted = Some(Wanted::Language);
                        }
                        if shortcut::button(ui, text::UPKEEP.of(language), shortcut::UPKEEP) {
                            wanted = Some(Wanted::Upkeep);
                        }
                    });
                });
                ui.add_space(4.0);
            });
        egui::Panel::left("people")
            .exact_size(300.0)
            .resizable(false)
            .show(ui, |ui| self.show_people(ui, ledger, language));
        egui::CentralPanel::default().show(ui, |ui| {
            wanted = self.show_tabs(ui, ledger, language).or(wanted.take());
        });
        wanted
    }

    fn show_people(&mut self, ui: &mut Ui, ledger: &dyn Ledger, language: Language) {
        let all = text::ALL_GROUPS.of(language);
        let mut groups: Vec<String> = self.people.iter().flat_map(|p| p.groups.clone()).collect();
        groups.sort();
        groups.dedup();
        let before = self.group.clone();
        let shown = self.group.clone().unwrap_or_else(|| all.to_owned());
        egui::ComboBox::from_id_salt("group")
            .selected_text(shown)
            .width(ui.available_width())
            .truncate()
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut self.group, None, all);
                for group in groups {
                    ui.selectable_value(&mut self.group, Some(group.clone()), group);
                }
            });
        if self.group != before {
            self.choose(ledger, None);
        }
        let search = TextEdit::singleline(&mut self.search).hint_text(text::SEARCH.of(language));
        ui.add(search.desired_width(f32::INFINITY));
        ui.add_space(4.0);
        let search = self.search.to_lowercase();
        let is_listed = |person: &&Person| {
            let in_group = self
                .group
                .as_ref()
                .is_none_or(|g| person.groups.contains(g));
            in_group && person.name.to_lowercase().contains(&search)
        };
        let listed: Vec<Person> = self.people.iter().filter(is_listed).cloned().collect();
        let room = (ui.available_height() - 46.0).max(TWO_LINES);
        ScrollArea::vertical()
            .id_salt("people")
            .max_height(room)
            .auto_shrink([false, false])
            .show_rows(ui, TWO_LINES, listed.len(), |ui, range| {
                for person in &listed[range] {
                    let is_chosen = self.chosen.as_ref().is_some_and(|c| c.id == person.id);
                    if row(ui, TWO_LINES, is_chosen, &person.id, |ui| {
                        show_person(ui, person, language);
                    }) {
                        self.message = None;
                        let id = (!is_chosen).then_some(&person.id[..]);
                        self.choose(ledger, id);
                    }
                }
            });
        ui.horizontal(|ui| {
            let name = TextEdit::singleline(&mut self.name).hint_text(text::NEW_NAME.of(language));
            let entered = ui.add(name.desired_width(ui.available_width() - 130.0));
            let by_key = entered.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let is_name = !self.name.trim().is_empty();
            let add = ui.add_enabled(is_name, egui::Button::new(text::ADD.of(language)));
            if is_name && (add.clicked() || by_key) {
                let name = self.name.trim().to_owned();
                let group = self.group.clone();
                if self.change(ledger, &Change::Add { name, group }, None) {
                    self.name.clear();
                }
            }
        });
    }

    /// Changes the store and shows what is in it then; `chosen` is shown, or whoever was.
    fn change(&mut self, ledger: &dyn Ledger, change: &Change, chosen: Option<&str>) -> bool {
        self.message = None;
        if let Err(why) = ledger.change(change) {
            self.message = Some((why, true));
            return false;
        }
        let chosen = chosen.map(str::to_owned);
        let chosen = chosen.or_else(|| self.chosen.as_ref().map(|person| person.id.clone()));
        self.read(ledger);
        self.choose(ledger, chosen.as_deref());
        true
    }

    fn show_tabs(
        &mut self,
        ui: &mut Ui,
        ledger: &dyn Ledger,
        language: Language,
    ) -> Option<Wanted> {
        ui.horizontal(|ui| {
            let shown = match (&self.chosen, &self.group) {
                (Some(person), _) => &person.name,
                (None, Some(group)) => group,
                (None, None) => text::EVERYBODY.of(language),
            };
            let room = ui.available_width() - 400.0;
            crate::rows::cell(ui, room, Align::Min, look::heading(shown));
            for (tab, title) in TABS {
                let title = RichText::new(title.of(language));
                let is_there = tab == Tab::Results || self.chosen.is_some();
                let button = egui::Button::selectable(self.tab == tab, title);
                if ui.add_enabled(is_there, button).clicked() {
                    self.tab = tab;
                    self.message = None;
                }
            }
        });
        if let Some((message, is_complaint)) = &self.message {
            let colour = if *is_complaint { look::BAD } else { look::GOOD };
            ui.add(Label::new(RichText::new(message).color(colour)).wrap());
        }
        ui.add_space(6.0);
        match self.tab {
            Tab::Results => {
                let of = attempts::Of {
                    selection: self.selection(),
                    group: self.group_to_export(),
                };
                match self.attempts.show(ui, &of, ledger, language)? {
                    attempts::Asked::Message(message, is_complaint) => {
                        self.message = Some((message, is_complaint));
                    }
                    attempts::Asked::Debrief(debrief) => return Some(Wanted::Debrief(debrief)),
                    attempts::Asked::Replay(debrief) => return Some(Wanted::Replay(debrief)),
                }
            }
            Tab::Learning => {
                let asked = learning::show(ui, &mut self.learning, language);
                if let (Some((module, level)), Some(person)) = (asked, &self.chosen) {
                    let learning = ledger.learning(&person.id, &module, level);
                    let learning = self.or_complain_one(learning);
                    self.learning.take((module, level), learning);
                }
            }
            Tab::Courses => {
                if let Some(person) = self.chosen.clone()
                    && let Some(change) = courses::show(ui, &mut self.courses, &person.id, language)
                {
                    self.change(ledger, &change, None);
                }
            }
            Tab::Details => {
                if let Some(person) = self.chosen.clone()
                    && let Some(asked) = person::show(ui, &mut self.details, &person, language)
                {
                    match asked {
                        person::Asked::Change(change) => {
                            self.change(ledger, &change, None);
                        }
                        person::Asked::Belongings => {
                            let found = ledger.belongings(&person.id);
                            let found = self.or_complain_one(found);
                            self.details.confirm_erasure(found);
                        }
                    }
                }
            }
        }
        None
    }
}

fn show_person(ui: &mut Ui, person: &Person, language: Language) {
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        ui.add_space(3.0);
        let name = RichText::new(&person.name).strong();
        ui.add(Label::new(name).truncate().selectable(false));
        let sessions = match person.sessions {
            1 => text::ONE_SESSION,
            _ => text::SESSIONS,
        };
        let mut parts = vec![format!("{} {}", person.sessions, sessions.of(language))];
        if !person.groups.is_empty() {
            parts.push(person.groups.join(", "));
        }
        let parts = look::quiet(parts.join(" · "));
        ui.add(Label::new(parts).truncate().selectable(false));
    });
}
