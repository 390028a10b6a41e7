//! `config/window.toml`: how the window looks.

use crate::document::{Loaded, Reading, load_text};
use crate::error::ConfigErrors;
use crate::files::schema_of;
use crate::kinds::{quantity, ratio};
use crate::table::table;
use microsim_vocabulary::{EyeLayout, Language, PictureQuality, Unit};
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
        }
    }
}

impl WindowSettings {
    /// The file that has them: lengths to a micrometre.
    pub fn text(&self) -> String {
        let millimetres = |length: f64| (1e6 * length).round() / 1e3;
        let hundredths = |number: f64| (1e2 * number).round() / 1e2;
        let language = self
            .language
            .map(|language| format!("language = \"{}\"\n", language.name()));
        format!(
            "# How the window looks; written by its settings screen. `microsim schema window --markdown` lists all keys.\n\
             {}quality = \"{}\"\nstereo = \"{}\"\nstereo_base = \"{} mm\"\nworking_distance = \"{} mm\"\n\
             depth_of_field = {}\nfull_screen = {}\npanels = {}\naudio = {}\nvolume = {}\ncontroller_speed = {}\n",
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
    Reading::new(text, file, &schema_of::<WindowSettings>("window"))?.finish()
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
