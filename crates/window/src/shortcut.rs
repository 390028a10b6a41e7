//! Buttons that have a key of their own, which stands beside their text: whoever works by keyboard needs neither Tab nor a pointer.

use crate::look;
use eframe::egui::{Key, Ui};

/// Trainees and results.
pub const RECORDS: Key = Key::F4;
/// Settings.
pub const SETTINGS: Key = Key::F5;
/// Courses and data.
pub const UPKEEP: Key = Key::F6;
/// The other language.
pub const LANGUAGE: Key = Key::F8;
/// From the beginning.
pub const RESTART: Key = Key::F9;
/// The end of a run without a verdict.
pub const ABORT: Key = Key::F10;
/// To the screen before.
pub const BACK: Key = Key::Escape;

/// Whether a key was pressed that is not meant for a text or a widget.
pub fn is_pressed(ui: &Ui, key: Key) -> bool {
    ui.memory(|memory| memory.focused().is_none()) && ui.input(|input| input.key_pressed(key))
}

/// A button; whether it or its key was pressed.
pub fn button(ui: &mut Ui, text: &str, key: Key) -> bool {
    ui.button(labelled(text, key)).clicked() || is_pressed(ui, key)
}

/// The button that most people want; whether it or its key was pressed.
pub fn main_button(ui: &mut Ui, text: &str, key: Key) -> bool {
    ui.add(look::main_button(&labelled(text, key))).clicked() || is_pressed(ui, key)
}

/// The text of a button with its key.
pub fn labelled(text: &str, key: Key) -> String {
    match key {
        Key::Escape => format!("{text} (Esc)"),
        key => format!("{text} ({})", key.name()),
    }
}
