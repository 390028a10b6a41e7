//! Name, role and groups of somebody; removing the name, or everything.

use crate::ledger::{Change, Person, Role};
use crate::look;
use crate::text::{self, Phrase};
use eframe::egui::{self, Button, Label, RichText, TextEdit, Ui};
use microsim_vocabulary::Language;

const ROLES: [(Role, Phrase); 3] = [
    (Role::Trainee, text::ROLE_TRAINEE),
    (Role::Instructor, text::ROLE_INSTRUCTOR),
    (Role::Operator, text::ROLE_OPERATOR),
];

/// What is entered.
#[derive(Debug, Default)]
pub struct Details {
    name: String,
    group: String,
    /// What is about to be removed.
    removal: Option<Removal>,
}

/// What can be removed of somebody.
#[derive(Clone, Copy, Debug)]
enum Removal {
    Name,
    /// With so many sessions and files.
    Everything([usize; 2]),
}

impl Details {
    /// Of somebody.
    pub fn of(person: Option<&Person>) -> Self {
        Self {
            name: person.map_or_else(String::new, |person| person.name.clone()),
            ..Self::default()
        }
    }

    /// Asks whether somebody is to be erased with so many sessions and files.
    pub fn confirm_erasure(&mut self, belongings: Option<[usize; 2]>) {
        self.removal = belongings.map(Removal::Everything);
    }
}

/// What the operator asked for.
#[derive(Debug)]
pub enum Asked {
    /// A change of the store.
    Change(Change),
    /// What would go with an erasure.
    Belongings,
}

/// Shows them.
pub fn show(
    ui: &mut Ui,
    details: &mut Details,
    person: &Person,
    language: Language,
) -> Option<Asked> {
    let id = || person.id.clone();
    let mut change = None;
    let mut asks_for_belongings = false;
    egui::Grid::new("details").num_columns(2).show(ui, |ui| {
        ui.label(text::NAME.of(language));
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(&mut details.name).desired_width(260.0));
            let name = details.name.trim();
            let is_new = !name.is_empty() && name != person.name;
            let rename = Button::new(text::RENAME.of(language));
            if ui.add_enabled(is_new, rename).clicked() {
                let name = name.to_owned();
                change = Some(Change::Rename { id: id(), name });
            }
        });
        ui.end_row();
        ui.label(text::ROLE.of(language));
        ui.horizontal(|ui| {
            for (role, title) in ROLES {
                let is_chosen = person.role == role;
                let button = Button::selectable(is_chosen, title.of(language));
                if ui.add(button).clicked() && !is_chosen {
                    change = Some(Change::Role { id: id(), role });
                }
            }
        });
        ui.end_row();
        ui.label(text::GROUPS.of(language));
        ui.vertical(|ui| {
            for group in &person.groups {
                ui.horizontal(|ui| {
                    if ui.small_button(text::TAKE_OUT.of(language)).clicked() {
                        change = Some(Change::Group {
                            id: id(),
                            group: group.clone(),
                            member: false,
                        });
                    }
                    ui.add(Label::new(group).truncate());
                });
            }
            ui.horizontal(|ui| {
                let line = TextEdit::singleline(&mut details.group);
                ui.add(line.desired_width(260.0));
                let group = details.group.trim();
                let put = Button::new(text::PUT_IN.of(language));
                if ui.add_enabled(!group.is_empty(), put).clicked() {
                    change = Some(Change::Group {
                        id: id(),
                        group: group.to_owned(),
                        member: true,
                    });
                }
            });
        });
        ui.end_row();
        ui.label("Id");
        ui.add(Label::new(look::quiet(&person.id)).truncate());
        ui.end_row();
    });
    ui.add_space(20.0);
    ui.label(look::heading(text::REMOVE.of(language)));
    ui.label(look::quiet(text::REMOVE_EXPLAINED.of(language)));
    ui.horizontal(|ui| {
        if ui.button(text::ANONYMISE.of(language)).clicked() {
            details.removal = Some(Removal::Name);
        }
        asks_for_belongings = ui.button(text::ERASE.of(language)).clicked();
    });
    if let Some(removal) = details.removal {
        let what = match removal {
            Removal::Name => text::NAME_GOES.of(language).to_owned(),
            Removal::Everything([sessions, files]) => format!(
                "{sessions} {}, {files} {}",
                text::SESSIONS.of(language),
                text::FILES_GO.of(language)
            ),
        };
        let what = RichText::new(format!("{}: {what}", person.name));
        ui.add(Label::new(what.color(look::BAD)).wrap());
        ui.horizontal(|ui| {
            let remove = RichText::new(text::FOR_GOOD.of(language)).color(look::BAD);
            if ui.button(remove).clicked() {
                change = Some(match removal {
                    Removal::Name => Change::Anonymise { id: id() },
                    Removal::Everything(_) => Change::Erase { id: id() },
                });
            }
            if ui.button(text::CANCEL.of(language)).clicked() {
                details.removal = None;
            }
        });
    }
    match asks_for_belongings {
        true => Some(Asked::Belongings),
        false => change.map(Asked::Change),
    }
}
