//! Choosing: who trains, which module, which level.

use crate::look;
use crate::shortcut;
use crate::station::{Catalogue, Choice, LevelEntry, ModuleEntry, TraineeEntry};
use crate::text::{self, local};
use eframe::egui::{self, Align, Event, Key, Layout, ScrollArea, Sense, Ui};
use microsim_message::LocalText;
use microsim_settings::DominantHand;
use microsim_vocabulary::Language;

/// What is chosen so far.
#[derive(Clone, Debug, Default)]
pub struct Launcher {
    /// Place of the module in the catalogue.
    pub module: usize,
    /// Level, from 1.
    pub level: u32,
    /// A variant of it, instead of the level itself.
    pub variant: Option<String>,
    /// Id of the trainee.
    pub trainee: Option<String>,
    /// The trainee's dominant hand.
    pub hand: DominantHand,
    /// Whether the lists are to show what was chosen by keyboard.
    scrolls: bool,
}

/// What the operator asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A run of what is chosen.
    Begin(Choice),
    /// Trainees and results.
    Records,
    /// How the window looks.
    Settings,
    /// Another copy of what is chosen.
    Edit(Choice),
    /// The other language.
    Language,
    /// The end.
    Quit,
}

/// What the launcher shows.
pub struct Offer<'a> {
    /// What can be trained.
    pub catalogue: &'a Catalogue,
    /// Who trains here, or why that is not known.
    pub trainees: &'a Result<Vec<TraineeEntry>, String>,
    /// Why a level is not open to the trainee.
    pub locked: &'a dyn Fn(&Choice) -> Option<LocalText>,
}

impl Launcher {
    /// Nothing is chosen but the hand.
    pub fn of_hand(hand: DominantHand) -> Self {
        Self {
            hand,
            ..Self::default()
        }
    }

    /// What is chosen, if there is anything to choose.
    pub fn choice(&self, catalogue: &Catalogue) -> Option<Choice> {
        let module = catalogue.modules.get(self.module)?;
        Some(Choice {
            module: module.name.clone(),
            level: self.level.max(1),
            variant: self.variant.clone(),
            trainee: self.trainee.clone(),
            hand: self.hand,
        })
    }

    /// Shows it.
    pub fn show(&mut self, ui: &mut Ui, offer: &Offer<'_>, language: Language) -> Option<Wanted> {
        let mut wanted = self.choose_by_keys(ui, offer.catalogue);
        egui::Panel::top("title")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    ui.heading("MicroSim");
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        if ui.button(text::QUIT.of(language)).clicked() {
                            wanted = Some(Wanted::Quit);
                        }
                        if shortcut::button(ui, text::LANGUAGE.of(language), shortcut::LANGUAGE) {
                            wanted = Some(Wanted::Language);
                        }
                        if shortcut::button(ui, text::SETTINGS.of(language), shortcut::SETTINGS) {
                            wanted = Some(Wanted::Settings);
                        }
                        if shortcut::button(ui, text::RESULTS.of(language), shortcut::RECORDS) {
                            wanted = Some(Wanted::Records);
                        }
                        self.choose_trainee(ui, offer, language);
                    });
                });
                ui.add_space(4.0);
            });
        egui::Panel::left("modules")
            .exact_size(ui.available_width() * 0.42)
            .resizable(false)
            .show(ui, |ui| {
                ui.label(look::heading(text::CHOOSE_MODULE.of(language)));
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    for (index, module) in offer.catalogue.modules.iter().enumerate() {
                        let chosen = index == self.module;
                        if module_card(ui, module, chosen, chosen && self.scrolls, language) {
                            self.choose_module(index);
                        }
                    }
                    for complaint in &offer.catalogue.complaints {
                        ui.label(look::quiet(complaint).color(look::BAD));
                    }
                });
            });
        egui::CentralPanel::default().show(ui, |ui| {
            let Some(module) = offer.catalogue.modules.get(self.module) else {
                return;
            };
            ui.label(look::heading(text::LEVELS.of(language)));
            let levels = ui.available_height() - 92.0;
            ScrollArea::vertical()
                .max_height(levels)
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    for level in &module.levels {
                        let choice = Choice {
                            module: module.name.clone(),
                            level: level.number,
                            variant: level.variant.clone(),
                            trainee: self.trainee.clone(),
                            hand: self.hand,
                        };
                        let locked = (offer.locked)(&choice);
                        let chosen = self.is_chosen(level);
                        let scrolls = chosen && self.scrolls;
                        if level_card(ui, level, (chosen, scrolls), locked.as_ref(), language) {
                            self.choose_level(level);
                        }
                    }
                });
            ui.add_space(8.0);
            ui.horizontal(|ui| {
                let begin = ui.add(look::main_button(text::BEGIN.of(language)));
                if begin.clicked() {
                    wanted = self.choice(offer.catalogue).map(Wanted::Begin);
                }
                if ui.button(text::EDIT_LEVEL.of(language)).clicked() {
                    wanted = self.choice(offer.catalogue).map(Wanted::Edit);
                }
            });
            let mut is_left = self.hand == DominantHand::Left;
            let hand = ui.checkbox(&mut is_left, text::LEFT_HANDED.of(language));
            if hand.clicked() {
                self.change_hand();
            }
        });
        wanted
    }

    fn change_hand(&mut self) {
        self.hand = match self.hand {
            DominantHand::Right => DominantHand::Left,
            DominantHand::Left => DominantHand::Right,
        };
    }

    fn choose_module(&mut self, index: usize) {
        (self.module, self.level, self.variant) = (index, 1, None);
    }

    fn choose_level(&mut self, level: &LevelEntry) {
        (self.level, self.variant) = (level.number, level.variant.clone());
    }

    fn is_chosen(&self, level: &LevelEntry) -> bool {
        (level.number, &level.variant) == (self.level.max(1), &self.variant)
    }

    fn choose_trainee(&mut self, ui: &mut Ui, offer: &Offer<'_>, language: Language) {
        let nobody = text::NOBODY.of(language);
        match offer.trainees {
            Err(why) => {
                ui.label(look::quiet(why).color(look::BAD));
            }
            Ok(trainees) => {
                let chosen = trainees
                    .iter()
                    .find(|t| Some(&t.id) == self.trainee.as_ref());
                let shown = chosen.map_or(nobody, |trainee| &trainee.name);
                egui::ComboBox::from_id_salt("trainee")
                    .selected_text(shown)
                    .width(190.0)
                    .show_ui(ui, |ui| {
                        ui.selectable_value(&mut self.trainee, None, nobody);
                        for trainee in trainees {
                            let id = Some(trainee.id.clone());
                            ui.selectable_value(&mut self.trainee, id, &trainee.name);
                        }
                    });
            }
        }
        ui.label(text::TRAINEE.of(language));
    }

    /// Arrows choose, up and down the module, left and right the level, H the trainee's hand, Enter begins, and E changes a copy: in the order in which they were pressed, however slow the pictures are.
    fn choose_by_keys(&mut self, ui: &Ui, catalogue: &Catalogue) -> Option<Wanted> {
        let last = catalogue.modules.len().checked_sub(1)?;
        if !shortcut::is_free(ui) {
            return None;
        }
        let is_press = |event: &Event| match event {
            Event::Key {
                key, pressed: true, ..
            } => Some(*key),
            _ => None,
        };
        let keys: Vec<Key> = ui.input(|input| input.events.iter().filter_map(is_press).collect());
        self.scrolls = !keys.is_empty();
        for key in keys {
            let levels = &catalogue.modules[self.module.min(last)].levels;
            let place = levels.iter().position(|level| self.is_chosen(level));
            let place = place.unwrap_or_default();
            match key {
                Key::ArrowDown if self.module < last => self.choose_module(self.module + 1),
                Key::ArrowUp if self.module > 0 => self.choose_module(self.module - 1),
                Key::ArrowRight | Key::ArrowLeft => {
                    let place = match key {
                        Key::ArrowRight => place + 1,
                        _ => place.saturating_sub(1),
                    };
                    if let Some(level) = levels.get(place) {
                        self.choose_level(level);
                    }
                }
                Key::H => self.change_hand(),
                Key::Enter => return self.choice(catalogue).map(Wanted::Begin),
                Key::E => return self.choice(catalogue).map(Wanted::Edit),
                _ => {}
            }
        }
        None
    }
}

fn module_card(
    ui: &mut Ui,
    module: &ModuleEntry,
    chosen: bool,
    scrolls: bool,
    language: Language,
) -> bool {
    let title = local(&module.title, language);
    let shown = look::card(chosen).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.strong(title);
        ui.label(look::quiet(local(&module.summary, language)));
    });
    if scrolls {
        shown.response.scroll_to_me(None);
    }
    is_pressed(ui, &shown.response, title)
}

fn level_card(
    ui: &mut Ui,
    level: &LevelEntry,
    (chosen, scrolls): (bool, bool),
    locked: Option<&LocalText>,
    language: Language,
) -> bool {
    let title = format!(
        "{} {}: {}",
        text::LEVEL.of(language),
        level.number,
        local(&level.title, language)
    );
    let shown = look::card(chosen).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.horizontal_wrapped(|ui| {
            ui.strong(&title);
            if let Some(why) = locked {
                let locked = format!("{}: {}", text::LOCKED.of(language), local(why, language));
                ui.label(look::quiet(locked).color(look::BAD));
            }
        });
        ui.label(look::quiet(local(&level.summary, language)));
        if chosen {
            let tools = level.tools.iter().map(|tool| local(&tool.title, language));
            let tools = tools.collect::<Vec<_>>().join(", ");
            ui.label(look::quiet(format!(
                "{}: {tools}",
                text::INSTRUMENTS.of(language)
            )));
        }
    });
    if scrolls {
        shown.response.scroll_to_me(None);
    }
    is_pressed(ui, &shown.response, &title)
}

/// Whether a card was clicked, or chosen by keyboard.
fn is_pressed(ui: &Ui, card: &egui::Response, name: &str) -> bool {
    let response = ui.interact(card.rect, card.id.with(name), Sense::click());
    response
        .on_hover_cursor(egui::CursorIcon::PointingHand)
        .clicked()
}
