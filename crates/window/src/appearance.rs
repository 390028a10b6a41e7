//! The settings screen: how the window looks. What is changed holds at once, and for later windows of this station once it is stored.

use crate::look;
use crate::rows::cell;
use crate::shortcut;
use crate::text::{self, Phrase, number};
use eframe::egui::{
    self, Align, Button, ComboBox, Label, Layout, RichText, ScrollArea, Slider, Ui,
};
use microsim_settings::{BASE_MAX, CONTROLLER_SPEEDS, WORKING_DISTANCES, WindowSettings};
use microsim_vocabulary::{EyeLayout, Language, PictureQuality};

/// Width of the names of settings \[points\].
const NAMES: f32 = 300.0;

/// What the operator asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Other settings hold from now on.
    Changed,
    /// They hold for later windows as well.
    Store,
    /// The modules.
    Back,
}

/// What the screen shows besides the settings.
#[derive(Clone, Debug, Default)]
pub struct Appearance {
    /// What came of storing them: a sentence, and whether it is a complaint.
    pub message: Option<(String, bool)>,
}

fn quality_name(quality: PictureQuality) -> Phrase {
    match quality {
        PictureQuality::Automatic => text::AUTOMATIC,
        PictureQuality::Low => text::LOW,
        PictureQuality::Medium => text::MEDIUM,
        PictureQuality::High => text::HIGH,
    }
}

fn layout_name(layout: EyeLayout) -> Phrase {
    match layout {
        EyeLayout::Mono => text::MONO,
        EyeLayout::SideBySide => text::SIDE_BY_SIDE,
        EyeLayout::TopBottom => text::TOP_BOTTOM,
        EyeLayout::RowInterleaved => text::ROW_INTERLEAVED,
        EyeLayout::RedCyan => text::RED_CYAN,
    }
}

/// A row: a name, and what its setting is changed with.
fn row(ui: &mut Ui, name: Phrase, language: Language, show: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        cell(ui, NAMES, Align::Min, name.of(language));
        show(ui);
    });
}

/// A length that is chosen in steps of half a millimetre.
fn length(ui: &mut Ui, metres: &mut f64, [least, most]: [f64; 2], language: Language) {
    let mut millimetres = (2e3 * *metres).round() / 2.0;
    let slider = Slider::new(&mut millimetres, 1e3 * least..=1e3 * most)
        .step_by(0.5)
        .custom_formatter(|value, _| number(value, 1, language))
        .custom_parser(|text| text.replace(',', ".").parse().ok())
        .suffix(" mm");
    if ui.add(slider).changed() {
        *metres = millimetres / 1e3;
    }
}

/// A number that is chosen in steps of a twentieth.
fn fraction(
    ui: &mut Ui,
    value: &mut f64,
    [least, most]: [f64; 2],
    suffix: &str,
    language: Language,
) {
    let slider = Slider::new(value, least..=most)
        .step_by(0.05)
        .custom_formatter(|value, _| number(value, 2, language))
        .custom_parser(|text| text.replace(',', ".").parse().ok())
        .suffix(suffix);
    ui.add(slider);
}

impl Appearance {
    /// Shows it.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        settings: &mut WindowSettings,
        language: Language,
    ) -> Option<Wanted> {
        let mut wanted = None;
        egui::Panel::top("settings")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                ui.horizontal(|ui| {
                    ui.heading(text::SETTINGS.of(language));
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        if shortcut::button(ui, text::BACK.of(language), shortcut::BACK) {
                            wanted = Some(Wanted::Back);
                        }
                    });
                });
                ui.add_space(4.0);
            });
        egui::Panel::bottom("store")
            .show_separator_line(false)
            .show(ui, |ui| {
                ui.add_space(6.0);
                let store = look::main_button(text::STORE_SETTINGS.of(language));
                if ui.add(store).clicked() {
                    wanted = Some(Wanted::Store);
                }
                let note = match &self.message {
                    Some((message, true)) => RichText::new(message).color(look::BAD),
                    Some((message, false)) => RichText::new(message).color(look::GOOD),
                    None => look::quiet(text::HOLDS_AT_ONCE.of(language)),
                };
                ui.add(Label::new(note).wrap());
                ui.add_space(6.0);
            });
        let before = *settings;
        let mut is_chosen = false;
        egui::CentralPanel::default().show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                is_chosen = show_settings(ui, settings, language);
            });
        });
        if is_chosen || *settings != before {
            self.message = None;
            wanted = wanted.or(Some(Wanted::Changed));
        }
        wanted
    }
}

/// Whether other settings of the picture hold, so that the next one is drawn otherwise. What is measured of the machine is measured once, and a quality that was
/// chosen by a key stays.
pub fn changes_picture(before: &WindowSettings, after: &WindowSettings) -> bool {
    let other_than_picture = WindowSettings {
        language: after.language,
        panels: after.panels,
        full_screen: after.full_screen,
        controller_speed: after.controller_speed,
        audio: after.audio,
        volume: after.volume,
        pedal: after.pedal,
        ..*before
    };
    other_than_picture != *after
}

/// Shows the rows; whether a language was chosen, which may be the one that is set and not the one that is shown.
fn show_settings(ui: &mut Ui, settings: &mut WindowSettings, language: Language) -> bool {
    let mut is_chosen = false;
    row(ui, text::LANGUAGE_OF_TEXTS, language, |ui| {
        for (of, name) in [
            (Language::German, "Deutsch"),
            (Language::English, "English"),
        ] {
            if ui.add(Button::selectable(language == of, name)).clicked() {
                settings.language = Some(of);
                is_chosen = true;
            }
        }
    });
    row(ui, text::QUALITY, language, |ui| {
        for quality in PictureQuality::ALL {
            let name = quality_name(quality).of(language);
            ui.selectable_value(&mut settings.quality, quality, name);
        }
    });
    row(ui, text::DEPTH_OF_FIELD, language, |ui| {
        ui.checkbox(&mut settings.depth_of_field, text::IF_HIGH.of(language));
    });
    row(ui, text::STEREO, language, |ui| {
        ComboBox::from_id_salt("stereo")
            .selected_text(layout_name(settings.stereo).of(language))
            .width(320.0)
            .show_ui(ui, |ui| {
                for layout in EyeLayout::ALL {
                    let name = layout_name(layout).of(language);
                    ui.selectable_value(&mut settings.stereo, layout, name);
                }
            });
    });
    row(ui, text::STEREO_BASE, language, |ui| {
        length(
            ui,
            &mut settings.stereo_base,
            [-BASE_MAX, BASE_MAX],
            language,
        );
    });
    row(ui, text::WORKING_DISTANCE, language, |ui| {
        length(
            ui,
            &mut settings.working_distance,
            WORKING_DISTANCES,
            language,
        );
    });
    row(ui, text::FULL_SCREEN, language, |ui| {
        ui.checkbox(&mut settings.full_screen, "F11");
    });
    row(ui, text::PANELS, language, |ui| {
        ui.checkbox(&mut settings.panels, "F3");
    });
    row(ui, text::AUDIO, language, |ui| {
        ui.checkbox(&mut settings.audio, text::AUDIO_OF.of(language));
    });
    row(ui, text::VOLUME, language, |ui| {
        fraction(ui, &mut settings.volume, [0.0, 1.0], "", language);
    });
    row(ui, text::CONTROLLER_SPEED, language, |ui| {
        let speed = &mut settings.controller_speed;
        let suffix = text::FIELDS_PER_SECOND.of(language);
        fraction(ui, speed, CONTROLLER_SPEEDS, suffix, language);
    });
    is_chosen
}
