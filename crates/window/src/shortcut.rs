//! Buttons that have a key of their own, which stands beside their text: whoever works by keyboard needs neither Tab nor a pointer.

use crate::look;
use eframe::egui::{Context, Event, Id, Key, Modifiers, Popup, Ui};

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

/// All of them.
#[cfg(test)]
pub const ALL: [Key; 7] = [RECORDS, SETTINGS, UPKEEP, LANGUAGE, RESTART, ABORT, BACK];

/// Where it is noted whether a widget had the keyboard, or a menu was open, in the last picture.
fn in_use() -> Id {
    Id::unique("the keyboard is in use")
}

/// Notes at the end of a picture who has the keyboard: a key of the next one is meant for that, also the Escape key, with which egui takes it away before anything is shown.
pub fn note_use(context: &Context) {
    let has_focus = context.memory(|memory| memory.focused().is_some());
    let is_used = has_focus || Popup::is_any_open(context);
    context.data_mut(|data| data.insert_temp(in_use(), is_used));
}

/// Whether keys are those of the screen, and not of a text, another widget or a menu.
pub fn is_free(ui: &Ui) -> bool {
    let was_used = ui.data(|data| data.get_temp::<bool>(in_use()));
    !was_used.unwrap_or_default() && ui.memory(|memory| memory.focused().is_none())
}

/// Whether a key of the screen was pressed, alone, and not held.
pub fn is_pressed(ui: &Ui, key: Key) -> bool {
    let is_press = |event: &Event| match event {
        Event::Key {
            key: pressed,
            pressed: true,
            repeat: false,
            modifiers,
            ..
        } => *pressed == key && modifiers.is_none(),
        _ => false,
    };
    is_free(ui) && ui.input(|input| input.events.iter().any(is_press))
}

/// A press of a key, alone, as the window is given it.
pub fn press(key: Key) -> Event {
    Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::NONE,
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{CentralPanel, RawInput, TextEdit};

    fn key(pressed: bool, modifiers: Modifiers) -> Event {
        Event::Key {
            key: Key::Escape,
            physical_key: None,
            pressed,
            // egui finds out which is one by what was not released.
            repeat: false,
            modifiers,
        }
    }

    /// The first Escape takes the keyboard away from a text, the second one leaves the screen.
    #[test]
    fn a_key_is_first_meant_for_the_text_that_is_typed() {
        let context = Context::default();
        let show = |events: Vec<Event>, has_focus: bool| {
            let input = RawInput {
                events,
                ..RawInput::default()
            };
            let mut is_left = false;
            let mut output = context.run_ui(input, |ui| {
                CentralPanel::default().show(ui, |ui| {
                    let mut text = String::new();
                    let field = ui.add(TextEdit::singleline(&mut text));
                    if has_focus {
                        field.request_focus();
                    }
                    is_left = is_pressed(ui, BACK);
                });
                note_use(ui.ctx());
            });
            output.textures_delta.clear();
            is_left
        };
        let escape = || [true, false].map(|is| key(is, Modifiers::NONE)).to_vec();
        assert!(!show(Vec::new(), true));
        assert!(!show(escape(), false), "it ends the typing");
        assert!(show(escape(), false));
        assert!(!show(vec![key(true, Modifiers::CTRL)], false));
        assert!(!show(vec![key(true, Modifiers::NONE)], false), "held");
    }
}
