//! Cards of the list of modules and of that of levels.

use crate::gallery::LevelPicture;
use crate::look;
use crate::station::{LevelEntry, ModuleEntry};
use crate::text::{self, local};
use eframe::egui::{self, Align, Layout, Margin, Rect, Sense, Ui, Vec2, vec2};
use microsim_message::LocalText;
use microsim_vocabulary::Language;

/// Width of a picture's place over its height.
const RATIO: f32 = 4.0 / 3.0;
/// Space around the picture of a module \[points\].
const MARGIN: i8 = 4;
/// Smallest and largest height of the picture of a module \[points\]: three lines of its summary, and what is sharp still.
const OF_MODULE: [f32; 2] = [60.0, 96.0];
/// Part of the list's height that the picture of the chosen level has, and its smallest and largest height \[points\].
const PART: f32 = 0.28;
const OF_LEVEL: [f32; 2] = [96.0, 240.0];

/// A training module in the list.
pub struct ModuleCard<'a> {
    pub module: &'a ModuleEntry,
    /// Its picture, if it brings one, and the height of the place that it has in any case \[points\].
    pub picture: (Option<&'a LevelPicture>, f32),
    pub chosen: bool,
    /// Whether the list is to show it.
    pub scrolls: bool,
}

impl ModuleCard<'_> {
    /// Height of pictures with which so many cards fill a list, as far as they can \[points\].
    pub fn picture_height(ui: &Ui, count: usize) -> f32 {
        let of_card = ui.available_height() / count.max(1) as f32;
        let around = 2.0 * f32::from(MARGIN) + ui.spacing().item_spacing.y;
        (of_card - around).clamp(OF_MODULE[0], OF_MODULE[1])
    }

    /// Shows it; whether it was pressed.
    pub fn show(&self, ui: &mut Ui, language: Language) -> bool {
        let title = local(&self.module.title, language);
        let (picture, height) = self.picture;
        let margin = Margin {
            right: 12,
            ..Margin::same(MARGIN)
        };
        let card = look::card(self.chosen).inner_margin(margin);
        let shown = card.show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.horizontal(|ui| {
                let (place, _) = ui.allocate_exact_size(size_of(height), Sense::hover());
                match picture {
                    Some(picture) => picture.draw(ui, place),
                    None => empty(ui, place),
                }
                ui.vertical(|ui| {
                    ui.spacing_mut().item_spacing.y = 4.0;
                    ui.strong(title);
                    ui.label(look::quiet(local(&self.module.summary, language)));
                });
            });
        });
        if self.scrolls {
            shown.response.scroll_to_me(None);
        }
        is_pressed(ui, &shown.response, title)
    }
}

/// A level in the list.
pub struct LevelCard<'a> {
    pub level: &'a LevelEntry,
    /// Why it is not open to the trainee.
    pub locked: Option<&'a LocalText>,
    /// Its picture, and the height of the list \[points\].
    pub picture: Option<(&'a LevelPicture, f32)>,
    pub chosen: bool,
    /// Whether the list is to show it.
    pub scrolls: bool,
}

impl LevelCard<'_> {
    /// Shows it; whether it was pressed.
    pub fn show(&self, ui: &mut Ui, language: Language) -> bool {
        let title = format!(
            "{} {}: {}",
            text::LEVEL.of(language),
            self.level.number,
            local(&self.level.title, language)
        );
        let shown = look::card(self.chosen).show(ui, |ui| {
            ui.set_width(ui.available_width());
            let Some((picture, list)) = self.picture else {
                self.show_texts(ui, &title, language);
                return;
            };
            let height = (PART * list).clamp(OF_LEVEL[0], OF_LEVEL[1]);
            let size = picture.size_in(size_of(height));
            ui.with_layout(Layout::right_to_left(Align::TOP), |ui| {
                let (place, _) = ui.allocate_exact_size(size, Sense::hover());
                picture.draw(ui, place);
                ui.vertical(|ui| {
                    self.show_texts(ui, &title, language);
                });
            });
        });
        if self.scrolls {
            shown.response.scroll_to_me(None);
        }
        is_pressed(ui, &shown.response, &title)
    }

    fn show_texts(&self, ui: &mut Ui, title: &str, language: Language) {
        ui.horizontal_wrapped(|ui| {
            ui.strong(title);
            if let Some(why) = self.locked {
                let locked = format!("{}: {}", text::LOCKED.of(language), local(why, language));
                ui.label(look::quiet(locked).color(look::BAD));
            }
        });
        ui.label(look::quiet(local(&self.level.summary, language)));
        if self.chosen {
            let tools = self.level.tools.iter();
            let tools = tools.map(|tool| local(&tool.title, language));
            let tools = tools.collect::<Vec<_>>().join(", ");
            ui.label(look::quiet(format!(
                "{}: {tools}",
                text::INSTRUMENTS.of(language)
            )));
        }
    }
}

fn size_of(height: f32) -> Vec2 {
    vec2(RATIO * height, height)
}

/// The place of a picture that is not there.
fn empty(ui: &Ui, place: Rect) {
    ui.painter().rect_filled(place, 5.0, look::BACKGROUND);
}

/// Whether a card was clicked, or chosen by keyboard.
fn is_pressed(ui: &Ui, card: &egui::Response, name: &str) -> bool {
    let response = ui.interact(card.rect, card.id.with(name), Sense::click());
    response
        .on_hover_cursor(egui::CursorIcon::PointingHand)
        .clicked()
}
