//! A foot switch: a keyboard of few keys, whose keys do what others do.

use crate::look;
use crate::steering::Stage;
use crate::text::{self, Phrase};
use eframe::egui::{Event, Key, Ui};
use microsim_settings::Pedal;
use microsim_vocabulary::{Language, PedalKey};

/// The keys that are set: what each does in words, and the key of the keyboard that does it.
fn keys(pedal: &Pedal, stage: Stage) -> Vec<(PedalKey, Phrase, Option<Key>)> {
    let seen = matches!(stage, Stage::Run | Stage::Replay);
    let run = stage == Stage::Run;
    let pause = match stage {
        Stage::Before => Some(Key::Enter),
        Stage::Run => Some(Key::Escape),
        Stage::Replay => Some(Key::Space),
        Stage::Other => None,
    };
    let keys = [
        (pedal.magnify, text::MAGNIFY, seen.then_some(Key::Plus)),
        (pedal.reduce, text::REDUCE, seen.then_some(Key::Minus)),
        (pedal.focus_up, text::FOCUS_UP, seen.then_some(Key::U)),
        (pedal.focus_down, text::FOCUS_DOWN, seen.then_some(Key::O)),
        (pedal.pause, text::PAUSE, pause),
        (pedal.other_hand, text::OTHER_HAND, run.then_some(Key::Tab)),
        (pedal.hold_closed, text::HOLD_CLOSED, run.then_some(Key::C)),
    ];
    let set = keys.into_iter();
    set.filter_map(|(key, what, by)| Some((key?, what, by)))
        .collect()
}

/// The key of the keyboard in the place of one that a foot switch sends.
fn translate(event: &mut Event, pedal: &Pedal, stage: Stage) {
    if let Event::Key { key, .. } = event {
        let name = key.name();
        let mut keys = keys(pedal, stage).into_iter();
        let by =
            keys.find(|(sent, ..)| Key::from_name(sent.name()).is_some_and(|k| k.name() == name));
        *key = by.and_then(|(.., by)| by).unwrap_or(*key);
    }
}

/// Translates what was pressed since the last picture.
pub fn press_keys(ui: &Ui, pedal: &Pedal, stage: Stage) {
    ui.ctx().input_mut(|input| {
        for event in &mut input.events {
            translate(event, pedal, stage);
        }
    });
}

/// Shows which of its keys does what.
pub fn help(ui: &mut Ui, pedal: &Pedal, language: Language) {
    for (key, what, _) in keys(pedal, Stage::Run) {
        let switch = text::FOOT_SWITCH.of(language);
        ui.label(look::quiet(format!(
            "{switch} {}: {}",
            key.name(),
            what.of(language)
        )));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shortcut::{self, press};

    /// Every name is that of a key, and none of a key that has a meaning already.
    #[test]
    fn every_key_of_a_foot_switch_is_one_of_the_window() {
        // Under the microscope, in a replay, and on the screens that come before and after: a foot may still be on it.
        let hands = [Key::Tab, Key::C, Key::Q, Key::E, Key::W, Key::S];
        let scope = [
            Key::Plus,
            Key::Minus,
            Key::Equals,
            Key::Num0,
            Key::Home,
            Key::I,
            Key::J,
        ];
        let scope = scope.into_iter().chain([Key::K, Key::L, Key::U, Key::O]);
        let replay = Key::ALL.iter().copied();
        let replay = replay.filter(|key| crate::console::by_key(*key).is_some());
        let screens = [
            Key::Enter,
            Key::H,
            Key::N,
            Key::A,
            Key::R,
            Key::F2,
            Key::F3,
            Key::F11,
        ];
        let used: Vec<Key> = (hands.into_iter().chain(scope).chain(replay))
            .chain(screens)
            .chain(shortcut::ALL)
            .collect();
        for key in PedalKey::ALL {
            let found = Key::from_name(key.name());
            assert!(found.is_some_and(|key| !used.contains(&key)), "{key:?}");
        }
    }

    #[test]
    fn a_foot_switch_presses_the_keys_of_what_is_shown() {
        let pedal = Pedal {
            pause: Some(PedalKey::F13),
            magnify: Some(PedalKey::PageUp),
            other_hand: Some(PedalKey::B),
            ..Pedal::default()
        };
        for (sent, stage, expected) in [
            (Key::F13, Stage::Before, Key::Enter),
            (Key::F13, Stage::Run, Key::Escape),
            (Key::F13, Stage::Replay, Key::Space),
            (Key::PageUp, Stage::Run, Key::Plus),
            (Key::B, Stage::Run, Key::Tab),
            // Where names are typed it is a letter.
            (Key::B, Stage::Other, Key::B),
            (Key::F14, Stage::Run, Key::F14),
        ] {
            let mut event = press(sent);
            translate(&mut event, &pedal, stage);
            assert_eq!(event, press(expected));
        }
    }
}
