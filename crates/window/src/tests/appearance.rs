//! The settings screen, laid out and used with mouse and keyboard.

use super::records::{LONG, SIZE, click_on};
use super::{SIZES, check_height, everywhere, texts};
use crate::appearance::{Appearance, Wanted, changes_picture};
use eframe::egui::{Key, Ui};
use microsim_settings::WindowSettings;
use microsim_vocabulary::{EyeLayout, Language, PictureQuality};

#[test]
fn the_settings_have_room_for_their_texts() {
    let messages = [
        None,
        Some((
            format!("Stored in /home/somebody/{LONG}/window.toml"),
            false,
        )),
        Some((
            format!("/home/somebody/{LONG}/window.toml cannot be written"),
            true,
        )),
    ];
    for message in messages {
        let mut appearance = Appearance { message };
        let mut settings = WindowSettings {
            stereo: EyeLayout::RedCyan,
            ..WindowSettings::default()
        };
        let mut show = |ui: &mut Ui, language| {
            appearance.show(ui, &mut settings, language);
        };
        everywhere("settings", &mut show);
        for size in SIZES {
            let found = texts(size, Vec::new(), |ui| show(ui, Language::German));
            check_height("settings", size, &found);
        }
    }
}

/// Clicks a text of the screen; what was asked for.
fn click(settings: &mut WindowSettings, text: &str) -> Option<Wanted> {
    let mut appearance = Appearance {
        message: Some(("Stored in there".into(), false)),
    };
    let mut wanted = None;
    click_on(text, |ui| {
        wanted = appearance.show(ui, settings, Language::English).or(wanted);
    });
    if wanted == Some(Wanted::Changed) {
        assert_eq!(
            appearance.message, None,
            "what was stored is not what holds now"
        );
    }
    wanted
}

#[test]
fn settings_are_changed_by_mouse() {
    let mut settings = WindowSettings::default();
    for text in ["Deutsch", "high", "where the quality is high", "F11", "F3"] {
        assert_eq!(click(&mut settings, text), Some(Wanted::Changed), "{text}");
    }
    let expected = WindowSettings {
        language: Some(Language::German),
        quality: PictureQuality::High,
        depth_of_field: false,
        full_screen: true,
        panels: false,
        ..WindowSettings::default()
    };
    assert_eq!(settings, expected);
    assert_eq!(
        click(&mut settings, "Store for this station"),
        Some(Wanted::Store)
    );
    assert_eq!(
        click(&mut settings, "Back to the modules"),
        Some(Wanted::Back)
    );
    assert_eq!(settings, expected);
}

#[test]
fn escape_leads_back() {
    let key = crate::shortcut::press(Key::Escape);
    let mut wanted = None;
    texts(SIZE, vec![key], |ui| {
        let mut settings = WindowSettings::default();
        wanted = Appearance::default().show(ui, &mut settings, Language::German);
    });
    assert_eq!(wanted, Some(Wanted::Back));
}

/// A window that was opened in another language than the one of its settings.
#[test]
fn a_language_is_chosen_though_it_is_set() {
    let mut settings = WindowSettings {
        language: Some(Language::German),
        ..WindowSettings::default()
    };
    assert_eq!(click(&mut settings, "Deutsch"), Some(Wanted::Changed));
    assert_eq!(settings.language, Some(Language::German));
}

/// Only what concerns the picture changes it: a quality that was chosen by a key stays otherwise.
#[test]
fn language_panels_and_full_screen_leave_the_picture_as_it_is() {
    let before = WindowSettings::default();
    let beside = WindowSettings {
        language: Some(Language::English),
        panels: !before.panels,
        full_screen: !before.full_screen,
        ..before
    };
    assert!(!changes_picture(&before, &beside));
    for of_picture in [
        WindowSettings {
            quality: PictureQuality::High,
            ..beside
        },
        WindowSettings {
            stereo: EyeLayout::RedCyan,
            ..beside
        },
        WindowSettings {
            working_distance: 0.123,
            ..beside
        },
    ] {
        assert!(changes_picture(&before, &of_picture), "{of_picture:?}");
    }
}
