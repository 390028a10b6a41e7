//! `config/window.toml`: how the window looks.

use crate::document::{Loaded, Reading, load_text};
use crate::error::{ConfigErrors, KeyPath};
use crate::files::schema_of;
use crate::kinds::{own_defaults, quantity, ratio};
use crate::table::table;
use microsim_vocabulary::{EyeLayout, Language, PedalKey, PictureQuality, Unit};
use std::path::Path;

/// Farthest eyes \[m\].
pub const BASE_MAX: f64 = 0.07;
/// Nearest and farthest main lens of surgical microscopes \[m\].
pub const WORKING_DISTANCES: [f64; 2] = [0.2, 0.45];
/// Slowest and fastest motion by gamepads and SpaceMice at full deflection \[diameters of the field per second\].
pub const CONTROLLER_SPEEDS: [f64; 2] = [0.05, 2.0];

table! {
    /// How the window looks. Nothing that is computed or recorded depends on it.
    #[derive(Copy)]
    pub struct WindowSettings {
        /// Language of all texts; without it that of `report.language` of config/host.toml.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        language: Option<Language>,
        /// How much is done for a picture.
        quality: PictureQuality => "automatic",
        /// How the pictures of both eyes lie in the window.
        stereo: EyeLayout => "mono",
        /// Between both eyes, in the plane of the main lens \[m\]; negative exchanges them.
        stereo_base: f64 = quantity(Unit::Length, -BASE_MAX, BASE_MAX) => 0.024,
        /// From the main lens to the plane of focus \[m\].
        working_distance: f64 = quantity(Unit::Length, WORKING_DISTANCES[0], WORKING_DISTANCES[1]) => 0.25,
        /// Whether what is out of focus is blurred, where the picture quality is high.
        depth_of_field: bool => true,
        /// Whether the window fills the screen when it opens.
        full_screen: bool => false,
        /// Whether panels stand beside the picture; without them the picture takes all of the window.
        panels: bool => true,
        /// Whether touch, cuts, tears and too much force are heard, where there is a device for it.
        audio: bool => true,
        /// How loud, from 0 to 1.
        volume: f64 = ratio(1.0) => 0.5,
        /// How fast gamepads and SpaceMice move a tip at full deflection, in diameters of the field per second.
        controller_speed: f64 = quantity(Unit::Ratio, CONTROLLER_SPEEDS[0], CONTROLLER_SPEEDS[1]) => 0.5,
        /// Keys that a foot switch sends.
        pedal: Pedal => own_defaults(),
    }
}

table! {
    /// Keys that a foot switch sends, beside those of the keyboard.
    #[derive(Copy, Eq, Default)]
    pub struct Pedal {
        /// More magnification.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        magnify: Option<PedalKey>,
        /// Less magnification.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        reduce: Option<PedalKey>,
        /// The plane of focus up.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        focus_up: Option<PedalKey>,
        /// The plane of focus down.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        focus_down: Option<PedalKey>,
        /// Begin, pause, go on.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pause: Option<PedalKey>,
        /// The other hand.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        other_hand: Option<PedalKey>,
        /// Jaws stay closed, or no longer.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        hold_closed: Option<PedalKey>,
    }
}

impl Pedal {
    /// Each key with the name of what it does.
    pub fn keys(&self) -> [(&'static str, Option<PedalKey>); 7] {
        [
            ("magnify", self.magnify),
            ("reduce", self.reduce),
            ("focus_up", self.focus_up),
            ("focus_down", self.focus_down),
            ("pause", self.pause),
            ("other_hand", self.other_hand),
            ("hold_closed", self.hold_closed),
        ]
    }
}

impl Default for WindowSettings {
    fn default() -> Self {
        Self {
            language: None,
            quality: PictureQuality::Automatic,
            stereo: EyeLayout::Mono,
            stereo_base: 0.024,
            working_distance: 0.25,
            depth_of_field: true,
            full_screen: false,
            panels: true,
            audio: true,
            volume: 0.5,
            controller_speed: 0.5,
            pedal: Pedal::default(),
        }
    }
}

impl WindowSettings {
    /// The file that has them: lengths to a micrometre.
    pub fn text(&self) -> String {
        let millimetres = |length: f64| (1e6 * length).round() / 1e3;
        let pedal = self.pedal.keys().into_iter();
        let pedal = pedal.filter_map(|(name, key)| Some(format!("{name} = \"{}\"\n", key?.name())));
        let pedal: String = pedal.collect();
        let pedal = match pedal.is_empty() {
            true => pedal,
            false => format!("\n[pedal]\n{pedal}"),
        };
        let hundredths = |number: f64| (1e2 * number).round() / 1e2;
        let language = self
            .language
            .map(|language| format!("language = \"{}\"\n", language.name()));
        format!(
            "# How the window looks; written by its settings screen. `microsim schema window --markdown` lists all keys.\n\
             {}quality = \"{}\"\nstereo = \"{}\"\nstereo_base = \"{} mm\"\nworking_distance = \"{} mm\"\n\
             depth_of_field = {}\nfull_screen = {}\npanels = {}\naudio = {}\nvolume = {}\ncontroller_speed = {}\n{pedal}",
            language.unwrap_or_default(),
            self.quality.name(),
            self.stereo.name(),
            millimetres(self.stereo_base),
            millimetres(self.working_distance),
            self.depth_of_field,
            self.full_screen,
            self.panels,
            self.audio,
            hundredths(self.volume),
            hundredths(self.controller_speed)
        )
    }
}

/// Reads the file of the window from a text; `file` is the name that complaints use.
pub fn read_window(text: &str, file: &str) -> Result<Loaded<WindowSettings>, ConfigErrors> {
    let mut reading = Reading::new(text, file, &schema_of::<WindowSettings>("window"))?;
    let pedal = reading.value()["pedal"].as_object().cloned();
    let keys: Vec<(String, serde_json::Value)> = pedal.into_iter().flatten().collect();
    for (at, (name, key)) in keys.iter().enumerate() {
        let is_used =
            |(_, earlier): &(String, serde_json::Value)| earlier == key && key.is_string();
        if let Some((earlier, _)) = keys[..at].iter().find(|earlier| is_used(earlier)) {
            let found = format!("{key}, which is that of `{earlier}` as well");
            let place = KeyPath::root().key("pedal").key(name);
            reading.complain(&place, &found, "a key of its own");
        }
    }
    reading.finish()
}

/// Reads the file of the window at `path`.
pub fn load_window(path: &Path) -> Result<Loaded<WindowSettings>, ConfigErrors> {
    let text = load_text(path, "the settings of the window (config/window.toml)")?;
    read_window(&text, &path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> WindowSettings {
        match read_window(text, "window.toml") {
            Ok(loaded) => loaded.settings,
            Err(errors) => panic!("{errors}"),
        }
    }

    /// An empty file has the defaults, and so has the one that is shipped.
    #[test]
    fn defaults_are_those_of_the_shipped_file() {
        assert_eq!(read(""), WindowSettings::default());
        let shipped = include_str!("../../../config/window.toml");
        assert_eq!(read(shipped), WindowSettings::default());
    }

    /// A name that is none, one that has a meaning already, and one that is used twice: each with its line.
    #[test]
    fn wrong_keys_of_a_foot_switch_are_named_with_their_line() {
        for (text, line, part) in [
            ("[pedal]\npause = \"Foot\"\n", "window.toml:2", "Foot"),
            ("[pedal]\nmagnify = \"Tab\"\n", "window.toml:2", "Tab"),
            (
                "[pedal]\nmagnify = \"F7\"\nreduce = \"F13\"\npause = \"F7\"\n",
                "window.toml:4",
                "which is that of `magnify` as well",
            ),
        ] {
            let errors = read_window(text, "window.toml")
                .expect_err(text)
                .to_string();
            assert!(errors.contains(line) && errors.contains(part), "{errors}");
        }
    }

    #[test]
    fn what_is_written_is_read() {
        assert_eq!(
            read(&WindowSettings::default().text()),
            WindowSettings::default()
        );
        for stereo in EyeLayout::ALL {
            for quality in PictureQuality::ALL {
                let settings = WindowSettings {
                    language: Some(Language::German),
                    quality,
                    stereo,
                    stereo_base: -0.0225,
                    working_distance: 0.4,
                    depth_of_field: false,
                    full_screen: true,
                    panels: false,
                    audio: false,
                    volume: 0.15,
                    controller_speed: 1.25,
                    pedal: Pedal {
                        pause: Some(PedalKey::F13),
                        focus_up: Some(PedalKey::Digit7),
                        ..Pedal::default()
                    },
                };
                let again = read(&settings.text());
                assert!((again.stereo_base - settings.stereo_base).abs() < 1e-12);
                assert!((again.working_distance - settings.working_distance).abs() < 1e-12);
                let same = WindowSettings {
                    stereo_base: settings.stereo_base,
                    working_distance: settings.working_distance,
                    ..again
                };
                assert_eq!(same, settings);
            }
        }
    }
}
