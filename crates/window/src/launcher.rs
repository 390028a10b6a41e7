//! Choosing: who trains, which module, which level.

use crate::cards::{LevelCard, ModuleCard};
use crate::gallery::Gallery;
use crate::level_pictures::LevelPictures;
use crate::look;
use crate::shortcut;
use crate::station::{Catalogue, Choice, LevelEntry, TraineeEntry};
use crate::text;
use eframe::egui::{self, Align, Event, Key, Layout, ScrollArea, Ui};
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
    gallery: Gallery,
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
    /// What is trained, as it looks.
    pub pictures: &'a dyn LevelPictures,
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
                self.choose_among_modules(ui, offer, language);
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
                        // A variant may look otherwise.
                        let has_picture = chosen && level.variant.is_none();
                        let of = (&module.name[..], level.number);
                        let picture = has_picture
                            .then(|| self.gallery.picture(ui.ctx(), offer.pictures, of))
                            .flatten();
                        let card = LevelCard {
                            level,
                            locked: locked.as_ref(),
                            picture: picture.as_ref().map(|picture| (picture, levels)),
                            chosen,
                            scrolls: chosen && self.scrolls,
                        };
                        if card.show(ui, language) {
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

    fn choose_among_modules(&mut self, ui: &mut Ui, offer: &Offer<'_>, language: Language) {
        let modules = &offer.catalogue.modules;
        let height = ModuleCard::picture_height(ui, modules.len());
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for (index, module) in modules.iter().enumerate() {
                let chosen = index == self.module;
                let of = (&module.name[..], 1);
                let picture = self.gallery.picture(ui.ctx(), offer.pictures, of);
                let card = ModuleCard {
                    module,
                    picture: (picture.as_ref(), height),
                    chosen,
                    scrolls: chosen && self.scrolls,
                };
                if card.show(ui, language) {
                    self.choose_module(index);
                }
            }
            let complaints = offer.catalogue.complaints.iter();
            for complaint in complaints.chain(self.gallery.complaints()) {
                ui.label(look::quiet(complaint).color(look::BAD));
            }
        });
    }

    /// Lets go of the pictures, and so of the device that shows them: they are read again when they are shown next.
    pub fn let_go_of_pictures(&mut self) {
        self.gallery = Gallery::default();
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
